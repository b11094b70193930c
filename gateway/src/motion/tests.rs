//! From any state within the limits, with any single fault, the machine ends at rest where it rests.

use super::*;

const H: f64 = 0.00025;
const REST: Axes = [-0.34, -0.35, -0.34, -0.37, -0.35, -0.37];
const WEIGHT: Axes = [0.6; AXES];
/// Inertia [kg m2], friction and torque of short-circuited windings over speed [N m s/rad] of every axis of the model.
const INERTIA: f64 = 0.098;
const FRICTION: f64 = 0.3;
const BRAKING: f64 = 1.8;
/// End stops at 30 degrees to either side.
const STROKE: f64 = std::f64::consts::FRAC_PI_6;

fn pace() -> Pace {
    Pace { speed: 0.25, brake: 0.1, pause: 0.3, base_step: H }
}

fn mechanics() -> Mechanics {
    let gains = Gains { kp: [164.28; AXES], t_i: 0.2008, t_d: 0.0319, t_f: 0.00538 };
    Mechanics { gains, weight: WEIGHT, torque: 6.0, pace: pace() }
}

/// Uniform in -1 to 1 (SplitMix64).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ z >> 31) as f64 / u64::MAX as f64 * 2.0 - 1.0
    }

    fn axes(&mut self, most: f64) -> Axes {
        std::array::from_fn(|_| self.next() * most)
    }
}

#[test]
fn a_path_has_no_step_in_position_or_rate_and_keeps_its_speed() {
    let mut chance = Chance(1);
    for _ in 0..200 {
        let (from, rate) = (chance.axes(0.5), chance.axes(3.0));
        let path = Path::new(from, rate, REST, pace());
        let at: Vec<_> = (0..=path.cycles()).map(|k| path.at(k)).collect();
        assert_eq!((at[0], at[at.len() - 1]), (from, REST));
        for k in 0..AXES {
            let rates: Vec<_> = at.windows(2).map(|w| (w[1][k] - w[0][k]) / H).collect();
            // the first rate is the wanted one: its mean over a cycle differs by 3 s^2, s = 1 / 400
            assert!((rates[0] - rate[k]).abs() <= 1e-4 * rate[k].abs(), "{} {}", rates[0], rate[k]);
            // braking falls by at most 1.5 rate / 0.1 s, moving by 5.8 d / T^2, T = 1.875 D / 0.25 s
            // for the axis with the longest way D
            let stop = path.stop();
            let far = (0..AXES).fold(0.0, |far: f64, k| far.max((REST[k] - stop[k]).abs()));
            let moves = 5.8 * (REST[k] - stop[k]).abs() / (1.875 * far / 0.25).powi(2);
            let most = (1.5 * rate[k].abs() / 0.1).max(moves) * H;
            assert!(rates.windows(2).all(|w| (w[1] - w[0]).abs() <= most * 1.001));
            let fast = rates.iter().fold(0.0, |fast: f64, rate| fast.max(rate.abs()));
            assert!(fast <= rate[k].abs().max(0.25) * 1.001, "{fast}");
        }
    }
}

/// The acceleration of the smooth motion is at most 10 / sqrt(3) times its way over the square of its time.
#[test]
fn a_short_way_takes_no_larger_acceleration_than_one_in_the_time_of_a_brake() {
    for far in [1e-9, 1e-6, 1e-4, 5e-3, 0.013] {
        let path = Path::new(REST, [0.0; AXES], REST.map(|angle| angle + far), pace());
        let most = 5.78 * far / (pace().brake * pace().brake);
        for k in 0..path.cycles() {
            let thetadd = path.motion(k).thetadd[0].abs();
            // differences of angles of 0.4 rad have so many digits
            assert!(thetadd < most + 1e-8, "{far} rad, cycle {k}: {thetadd} rad/s2");
        }
    }
}

#[test]
fn a_machine_at_rest_starts_without_braking() {
    let path = Path::new(REST, [0.0; AXES], [0.0; AXES], pace());
    let cycles = (1.875 * 0.37 / 0.25 / H + 0.3 / H).round() as u32;
    assert_eq!((path.cycles(), path.stop()), (cycles, REST));
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    /// The encoder of this axis is frozen or shifted, and known to be wrong.
    Blind(usize),
    /// Only one reply in eight arrives.
    Lost,
    /// The weight of the machine file is wrong by 30 %.
    Weight(f64),
}

/// Six axes with weight and end stops; the holding torque is the line of `Mechanics::holding`.
struct Machine {
    theta: Axes,
    rate: Axes,
    weight: f64,
}

impl Machine {
    /// `braked`: axes whose drive has no power and short-circuits its windings.
    fn step(&mut self, tau: &Axes, braked: &[bool; AXES]) {
        for k in 0..AXES {
            let carried = self.weight * WEIGHT[k] * (1.0 - self.theta[k] / REST[k]);
            let damping = FRICTION + f64::from(u8::from(braked[k])) * BRAKING;
            self.rate[k] += H * (tau[k] - carried - damping * self.rate[k]) / INERTIA;
            self.theta[k] += H * self.rate[k];
            if self.theta[k].abs() > STROKE {
                (self.theta[k], self.rate[k]) = (STROKE.copysign(self.theta[k]), 0.0);
            }
        }
    }
}

#[test]
fn from_any_state_with_any_single_fault_the_machine_ends_at_rest() {
    let mut chance = Chance(2);
    let faults =
        [Fault::None, Fault::Blind(2), Fault::Lost, Fault::Weight(0.7), Fault::Weight(1.3)];
    for fault in faults {
        for _ in 0..20 {
            let weight = if let Fault::Weight(share) = fault { share } else { 1.0 };
            let (theta, rate) = (chance.axes(0.4), chance.axes(1.0));
            let mut machine = Machine { theta, rate, weight };
            let blind = std::array::from_fn(|k| fault == Fault::Blind(k));
            let mut mover =
                Mover::new(mechanics(), Path::new(theta, rate, REST, pace()), REST, blind);
            mover.step(&theta, 0);
            let (mut seen, mut n, mut fast) = (theta, 0, 0.0_f64);
            while mover.left() > 0 {
                machine.step(&mover.tau, &blind);
                if fault != Fault::Lost || n % 8 == 0 {
                    seen = machine.theta;
                }
                mover.step(&seen, 0);
                n += 1;
                fast = machine.rate.iter().fold(fast, |fast, rate| fast.max(rate.abs()));
                assert!(mover.tau.iter().all(|tau| tau.abs() <= 6.0));
            }
            let began = rate.iter().fold(0.0, |began: f64, rate| began.max(rate.abs()));
            assert!(fast <= began.max(1.0) * 1.05, "{fault:?}: {fast} rad/s from {began}");
            // then the power is taken: nothing may fall
            let mut fallen: f64 = 0.0;
            for _ in 0..8000 {
                machine.step(&[0.0; AXES], &blind);
                fallen = machine.rate.iter().fold(fallen, |fallen, rate| fallen.max(rate.abs()));
            }
            assert!(fallen < 0.5, "{fault:?}: {fallen} rad/s after the power was taken");
            assert!(machine.rate.iter().all(|rate| rate.abs() < 0.1), "{fault:?}");
        }
    }
}

#[test]
fn an_axis_that_moves_towards_its_stop_is_braked_before_it() {
    let (mut chance, mut shorter) = (Chance(3), 0);
    for _ in 0..200 {
        let theta = chance.axes(0.1).map(|angle| angle + 0.4_f64.copysign(angle));
        let rate = chance.axes(1.0);
        let mut machine = Machine { theta, rate, weight: 1.0 };
        let brakes = Brakes { pace: pace(), shortest: H, most: 6.0, limits: [(-0.52, 0.52); AXES] };
        let times = brakes.soonest(&theta, &rate);
        shorter += times.iter().filter(|time| **time < pace().brake).count();
        let path = brakes.path(&theta, &rate, times, &REST);
        let mut mover = Mover::new(mechanics(), path, REST, [false; AXES]);
        for _ in 0..path.braking() {
            let (m, hold) = (mover.motion(), mechanics().holding(&mover.r, &REST));
            let moving = |k: usize| INERTIA * m.thetadd[k] + FRICTION * m.thetad[k];
            mover.model = Some(std::array::from_fn(|k| hold[k] + moving(k)));
            mover.step(&machine.theta, 0);
            machine.step(&mover.tau, &[false; AXES]);
            assert!(machine.theta.iter().all(|theta| theta.abs() < STROKE), "{theta:?} {rate:?}");
        }
    }
    assert!(shorter > 30, "{shorter} of 1200 axes");
}

#[test]
fn a_landing_begins_with_the_torque_that_it_is_given_within_its_limit() {
    let from = [0.3; AXES];
    let path = Path::new(from, [0.0; AXES], REST, pace());
    let mut mover = Mover::new(mechanics(), path, REST, [false; AXES]);
    let given = [-2.0, 0.0, 1.2, 3.0, 5.9, 16.0];
    mover.begin_with(&given, &mover.holding());
    mover.step(&from, 0);
    for (tau, given) in mover.tau.iter().zip(given) {
        assert!((tau - given.clamp(-6.0, 6.0)).abs() < 1e-12, "{tau} {given}");
    }
}

#[test]
fn a_torque_at_its_limit_winds_nothing_up() {
    let path = Path::new([0.0; AXES], [0.0; AXES], [0.0; AXES], pace());
    let mut mover = Mover::new(mechanics(), path, REST, [false; AXES]);
    // 0.1 rad off for a second: 16 N m are wanted
    (0..4000).for_each(|_| mover.step(&[0.1; AXES], 0));
    assert_eq!(mover.tau, [-6.0; AXES]);
    mover.step(&[0.0; AXES], 0);
    (0..200).for_each(|_| mover.step(&[0.0; AXES], 0));
    assert!(mover.tau[0].abs() < 1.5, "{}", mover.tau[0]);
}

#[test]
fn skipped_cycles_delay_the_path_and_kick_nothing() {
    let path = Path::new(REST, [0.0; AXES], [0.0; AXES], pace());
    let mut mover = Mover::new(mechanics(), path, REST, [false; AXES]);
    (0..4000).for_each(|_| {
        let theta = mover.r;
        mover.step(&theta, 0)
    });
    let (r, left, tau) = (mover.r, mover.left(), mover.tau);
    // 0.1 s without a cycle, in which the axes moved on by 5 mrad
    mover.step(&r.map(|r| r - 0.005), 400);
    let step = mover.r[0] - r[0];
    assert!(step.abs() <= 0.25 * H && mover.left() == left - 1, "{step} {}", mover.left());
    // 164 N m/rad of proportional gain alone; the rate of a cycle would add 4 N m
    assert!((mover.tau[0] - tau[0] - 164.28 * (0.005 + step)).abs() < 0.1, "{}", mover.tau[0]);
}

#[test]
fn another_path_goes_on_without_a_step_of_the_torque() {
    // the weight is a third more than known: the sum of the errors carries the rest
    let mut machine = Machine { theta: REST, rate: [0.0; AXES], weight: 1.3 };
    let to = [0.0; AXES];
    let path = Path::new(REST, [0.0; AXES], to, pace());
    let mut mover = Mover::new(mechanics(), path, REST, [false; AXES]);
    let mut last = [0.0; AXES];
    let mut poses = [[0.05; AXES], [-0.1; AXES]].into_iter();
    let mut end = to;
    for n in 0.. {
        mover.step(&machine.theta, 0);
        let most = (0..AXES).fold(0.0, |most: f64, k| most.max((mover.tau[k] - last[k]).abs()));
        assert!(n == 0 || most < 0.05, "cycle {n}: a step of {most} N m");
        last = mover.tau;
        machine.step(&mover.tau, &[false; AXES]);
        if mover.left() > 0 {
            continue;
        }
        let off = (0..AXES).fold(0.0, |off: f64, k| off.max((machine.theta[k] - end[k]).abs()));
        assert!(off < 2e-3, "{off} rad from its pose");
        let Some(pose) = poses.next() else { break };
        mover.follow(Path::new(end, [0.0; AXES], pose, pace()));
        end = pose;
    }
}
