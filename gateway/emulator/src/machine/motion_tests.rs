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
