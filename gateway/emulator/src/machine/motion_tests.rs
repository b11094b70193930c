//! A plant with weight, and drives that brake.
use super::super::*;
use crate::bench::{Bench, DT};

/// Six axes that fall with 1 rad/s2.
struct Falling(f64);

impl Plant for Falling {
    fn read(&self, theta: &mut [f64; AXES], _: &mut [f64; AXES]) {
        *theta = [-self.0 * self.0 / 2.0; AXES];
    }

    fn step(&mut self, _: &[f64; AXES]) -> Result<(), Error> {
        self.0 += DT;
        Ok(())
    }
}

#[test]
fn a_plant_that_nothing_holds_moves_before_the_drives_are_enabled() {
    let enabled_at = |rest: Option<u64>| {
        let mut bench = Bench::new("drives.count = 6");
        bench.machine.plant = Box::new(Falling(0.0));
        if let Some(steps) = rest {
            bench.machine.rest(steps).unwrap();
        }
        bench.enable();
        assert_eq!(bench.machine.cycle(), None);
        (bench.machine.theta[0], bench.machine.frames)
    };
    assert_eq!(enabled_at(None).0, 0.0);
    let (theta, frames) = enabled_at(Some(1000));
    let time = (1000 + frames) as f64 * DT;
    assert!(frames > 3 && (theta + time * time / 2.0).abs() < 1e-12, "{theta} {frames}");
}

#[test]
fn a_drive_without_power_brakes_only_where_it_is_told_to() {
    let distance = |options: &str| {
        let mut bench = Bench::new(options);
        bench.enable();
        for _ in 0..400 {
            bench.cycle(15, 1000);
        }
        let mut moved = |count| {
            let at = bench.cycle(0, 0).unwrap().0[0].position;
            (0..count).for_each(|_| drop(bench.cycle(0, 0)));
            f64::from(bench.cycle(0, 0).unwrap().0[0].position - at)
        };
        moved(200);
        moved(200)
    };
    let coasting = distance("drives.count = 6");
    let braked = distance("drives.count = 6\ndrives.braking = 1.0");
    // speed falls as exp(-d t / J), d = 0.2 by friction and 1 by the brake, J = 0.05 kg m2: over the
    // two windows of 201 steps the distances are as exp(-d t / J) (1 - exp(-d t / J)) / d
    let far = |d: f64| {
        let left = (-d * 201.0 * DT / 0.05).exp();
        left * (1.0 - left) / d
    };
    let share = braked / coasting;
    // explicit steps: d dt / J = 0.006 of the braked one in each of 400 steps is 0.7 %
    assert!((share / (far(1.2) / far(0.2)) - 1.0).abs() < 0.03, "{share}");
}

#[test]
fn an_axis_that_jams_stays_where_it_is_under_torque_until_the_fault_ends() {
    let fault = "kind = \"jam\"\ncycle = 200\ncount = 300\nposition = 3";
    let mut bench = Bench::new(&format!("drives.count = 6\n[[fault]]\n{fault}"));
    bench.enable();
    let mut seen = Vec::new();
    while bench.machine.cycle().is_none_or(|cycle| cycle < 600) {
        bench.cycle(15, 1000);
        seen.push(bench.machine.theta);
    }
    let moved = |axis: usize, from: usize, to: usize| seen[to][axis] - seen[from][axis];
    // 3 N m on a spring of 5000 N m/rad, once its swing has died down: m / c = 2.5 ms
    assert!((moved(3, 200, 450) - 3.0 / 5000.0).abs() < 1e-3, "{}", moved(3, 200, 450));
    assert!(moved(3, 300, 480).abs() < 1e-5, "{}", moved(3, 300, 480));
    assert!(moved(2, 300, 480) > 0.1 && moved(3, 520, 590) > 0.01);
}

#[test]
fn the_process_is_to_stand_still_once() {
    let mut bench = Bench::new("drives.count = 6\n[[fault]]\nkind = \"pause\"\ncycle = 3");
    bench.enable();
    let pauses: Vec<_> = (0..8)
        .map(|_| {
            bench.cycle(15, 0);
            (bench.machine.cycle(), bench.machine.take_pause())
        })
        .filter(|(_, paused)| *paused)
        .collect();
    assert_eq!(pauses, [(Some(3), true)]);
}

#[test]
fn extremes_are_of_the_mean_over_four_steps_and_of_either_sign() {
    let mut extremes = Extremes::default();
    for k in 0..5 {
        let mut theta = [0.0; AXES];
        theta[2] = -0.1 * f64::from(k);
        extremes.note(&theta, 0.5);
    }
    assert!((extremes.fastest - 0.4 / 2.0).abs() < 1e-12, "{}", extremes.fastest);
    assert!((extremes.farthest - 0.4).abs() < 1e-12);
}
