//! Every rule on both sides of its limit.

use super::{Measured, Reason, Safety, Trip};
use crate::config::{parse, Config, AXES};

const COMPLETE: u16 = 18;
const TS: f64 = 0.00025;

fn config() -> Config {
    parse(include_str!("../../machines/akd.toml")).unwrap()
}

/// A machine at rest in operation; tests bend one value.
#[derive(Clone)]
struct Cycle {
    n: i64,
    skipped: u64,
    answered: bool,
    working_counter: u16,
    theta: [f64; AXES],
    tau_meas: [f64; AXES],
    tau: [f64; AXES],
    r: [f64; AXES],
    e: [f64; AXES],
    statusword: [u16; AXES],
    error_code: [u16; AXES],
    al_state: [u8; AXES],
    controller: Option<(Reason, f64)>,
    overrun_us: f64,
}

impl Cycle {
    fn rest() -> Cycle {
        Cycle {
            n: 0,
            skipped: 0,
            answered: true,
            working_counter: COMPLETE,
            theta: [0.0; AXES],
            tau_meas: [0.0; AXES],
            tau: [0.0; AXES],
            r: [0.0; AXES],
            e: [0.0; AXES],
            statusword: [0x1637; AXES],
            error_code: [0; AXES],
            al_state: [8; AXES],
            controller: None,
            overrun_us: 0.0,
        }
    }

    fn judged(&self, safety: &mut Safety) -> Option<Trip> {
        safety.judge(&Measured {
            cycle: self.n,
            skipped: self.skipped,
            answered: self.answered,
            working_counter: self.working_counter,
            theta: &self.theta,
            tau_meas: &self.tau_meas,
            tau: &self.tau,
            r: &self.r,
            e: &self.e,
            statusword: &self.statusword,
            error_code: &self.error_code,
            al_state: &self.al_state,
            controller: self.controller,
            overrun_us: self.overrun_us,
        })
    }
}

fn safety() -> Safety {
    Safety::new(&config(), TS, COMPLETE, true)
}

/// What one cycle after a cycle at rest gives.
fn after_rest(bend: impl Fn(&mut Cycle)) -> Option<(Reason, Option<usize>, f64, f64)> {
    let mut safety = safety();
    let mut cycle = Cycle::rest();
    assert_eq!(cycle.judged(&mut safety), None);
    cycle.n = 1;
    bend(&mut cycle);
    let trip = cycle.judged(&mut safety)?;
    assert_eq!(trip.cycle, 1);
    Some((trip.reason, trip.axis, trip.value, trip.limit))
}

fn next_up(x: f64) -> f64 {
    f64::from_bits(x.to_bits() + 1)
}

#[test]
fn a_machine_at_rest_goes_on() {
    assert_eq!(after_rest(|_| ()), None);
}

#[test]
fn torque_trips_just_beyond_its_limit_measured_or_wanted() {
    let over = next_up(27.0);
    let wanted = Some((Reason::Torque, Some(2), over, 27.0));
    assert_eq!(after_rest(|c| c.tau_meas[2] = over), wanted);
    assert_eq!(after_rest(|c| c.tau[2] = over), wanted);
    assert_eq!(after_rest(|c| c.tau_meas[2] = 27.0), None);
    assert_eq!(after_rest(|c| c.tau[2] = -27.0), None);
    let below = Some((Reason::Torque, Some(0), -over, 27.0));
    assert_eq!(after_rest(|c| c.tau[0] = -over), below);
}

#[test]
fn nan_is_beyond_every_limit() {
    for bend in [
        |c: &mut Cycle| c.tau[1] = f64::NAN,
        |c: &mut Cycle| c.tau_meas[1] = f64::NAN,
        |c: &mut Cycle| c.theta[1] = f64::NAN,
        |c: &mut Cycle| c.e[1] = f64::NAN,
    ] {
        assert!(after_rest(bend).is_some_and(|t| t.1 == Some(1)));
    }
}

#[test]
fn a_jump_is_told_by_its_size_and_not_as_speed() {
    let over = next_up(0.001);
    assert_eq!(after_rest(|c| c.theta[5] = -over), Some((Reason::Jump, Some(5), -over, 0.001)));
    assert_eq!(after_rest(|c| c.theta[5] = 0.001), None);
}

#[test]
fn a_jump_may_be_larger_after_cycles_without_a_reply() {
    for (moved, wanted) in [(0.0029, None), (0.0031, Some(Reason::Jump))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        cycle.judged(&mut safety);
        cycle.answered = false;
        assert_eq!(cycle.judged(&mut safety), None);
        assert_eq!(cycle.judged(&mut safety), None);
        cycle.answered = true;
        cycle.theta[0] = moved;
        assert_eq!(cycle.judged(&mut safety).map(|t| t.reason), wanted, "{moved}");
    }
}

#[test]
fn cycles_that_were_left_out_allow_more_motion_once() {
    for (moved, wanted) in [(0.0049, None), (0.0051, Some(Reason::Jump))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        for _ in 0..20 {
            assert_eq!(cycle.judged(&mut safety), None);
        }
        cycle.skipped = 4;
        cycle.theta[0] = moved;
        assert_eq!(cycle.judged(&mut safety).map(|t| t.reason), wanted, "{moved}");
        cycle.skipped = 0;
        cycle.theta[0] += 0.0011;
        assert_eq!(cycle.judged(&mut safety).map(|t| t.reason), Some(Reason::Jump));
    }
}

/// 16 cycles left out, then one without a reply: its angle is that of before the gap.
#[test]
fn an_angle_from_before_a_gap_makes_no_speed() {
    for (speed, wanted) in [(1.0, None), (3.01, Some((Reason::Speed, 38)))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        let mut found = None;
        for n in 0..60 {
            let time = n + if n < 29 { 0 } else { 16 };
            cycle.n = n;
            (cycle.skipped, cycle.answered) = (if n == 29 { 16 } else { 0 }, n != 29);
            if cycle.answered {
                // slow until the gap: what is found is found after it
                let after = (time - 46).max(0) as f64;
                cycle.theta[3] = TS * (time.min(46) as f64 + speed * after);
            }
            found = found.or(cycle.judged(&mut safety));
        }
        assert_eq!(found.map(|t| (t.reason, t.cycle)), wanted, "{speed}");
    }
}

#[test]
fn speed_is_the_mean_over_its_cycles() {
    for (speed, wanted) in [(2.99, None), (3.01, Some((Reason::Speed, 8)))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        let mut found = None;
        for n in 0..40 {
            cycle.n = n;
            cycle.theta[3] = speed * TS * n as f64;
            found = found.or(cycle.judged(&mut safety));
        }
        assert_eq!(found.map(|t| (t.reason, t.cycle)), wanted, "{speed}");
    }
}

#[test]
fn position_trips_at_either_end() {
    for (theta, limit) in [(0.55, None), (-0.55, None), (0.551, Some(0.55)), (-0.551, Some(-0.55))]
    {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        cycle.theta[0] = theta;
        let found = cycle.judged(&mut safety);
        assert_eq!(found.map(|t| t.limit), limit, "{theta}");
        assert!(found.is_none_or(|t| t.reason == Reason::Position));
    }
}

#[test]
fn following_error_trips_only_with_power() {
    let over = next_up(0.05);
    assert_eq!(after_rest(|c| c.e[4] = 0.05), None);
    assert_eq!(after_rest(|c| c.e[4] = over), Some((Reason::FollowingError, Some(4), over, 0.05)));
    let mut safety = Safety::new(&config(), TS, COMPLETE, false);
    let mut cycle = Cycle::rest();
    cycle.e[4] = 1.0;
    cycle.statusword = [0x0250; AXES];
    assert_eq!(cycle.judged(&mut safety), None);
}

#[test]
fn a_frozen_encoder_needs_time_and_motion() {
    // 40 cycles with the same counts, and more than 0.002 rad of reference
    for (motion, wanted) in [(0.0019, None), (0.0021, Some(40)), (0.1, Some(40))] {
        let mut safety = safety();
        let mut cycle = Cycle::rest();
        let mut found = None;
        for n in 0..60 {
            cycle.n = n;
            cycle.r[1] = motion * (n as f64 / 10.0).min(1.0);
            found = found.or(cycle.judged(&mut safety));
        }
        assert_eq!(found.map(|t| t.cycle), wanted, "{motion}");
        assert!(found.is_none_or(|t| t.reason == Reason::FrozenEncoder && t.axis == Some(1)));
    }
}

#[test]
fn an_encoder_that_moves_now_and_then_is_not_frozen() {
    let mut safety = safety();
    let mut cycle = Cycle::rest();
    for n in 0..400 {
        cycle.n = n;
        cycle.r[1] = 1e-4 * n as f64;
        cycle.theta[1] = 1e-9 * (n / 39) as f64;
        assert_eq!(cycle.judged(&mut safety), None, "{n}");
    }
}

#[test]
fn what_the_drives_say_is_told_in_the_order_from_cause_to_consequence() {
    let fault = |c: &mut Cycle| {
        c.statusword[2] = 0x0218;
        c.error_code[2] = 0x8611;
        c.e[0] = 1.0;
    };
    let code = f64::from(0x8611);
    assert_eq!(after_rest(fault), Some((Reason::DriveFault, Some(2), code, 0.0)));
    let left = |c: &mut Cycle| {
        fault(c);
        c.al_state[2] = 0x14;
    };
    assert_eq!(after_rest(left), Some((Reason::AlState, Some(2), f64::from(0x14), 8.0)));
    let off = |c: &mut Cycle| c.statusword[0] = 0x0250;
    let wanted = Some((Reason::DriveState, Some(0), f64::from(0x40), f64::from(0x27)));
    assert_eq!(after_rest(off), wanted);
}

#[test]
fn a_short_working_counter_trips_at_the_third_in_a_row() {
    let mut safety = safety();
    let mut cycle = Cycle::rest();
    let mut short = |n, counter| {
        cycle.n = n;
        cycle.working_counter = counter;
        // the missing drive answers nothing
        cycle.al_state[5] = if counter == COMPLETE { 8 } else { 0 };
        cycle.judged(&mut safety).map(|t| (t.reason, t.cycle, t.value))
    };
    let row = [15, 15, COMPLETE, 15, 15].map(|c| short(0, c));
    assert_eq!(row, [None; 5]);
    assert_eq!(short(9, 15), Some((Reason::WorkingCounter, 9, 15.0)));
}

#[test]
fn lost_frames_trip_at_the_eighth_in_a_row() {
    let mut safety = safety();
    let mut cycle = Cycle::rest();
    for n in 0..15 {
        cycle.n = n;
        cycle.answered = n == 7;
        assert_eq!(cycle.judged(&mut safety), None, "{n}");
    }
    cycle.n = 15;
    let trip = cycle.judged(&mut safety).unwrap();
    assert_eq!((trip.reason, trip.cycle, trip.value), (Reason::LostFrames, 15, 8.0));
}

#[test]
fn failures_of_the_controller_and_late_cycles_are_reasons() {
    for reason in [Reason::NotFinite, Reason::FmuError, Reason::FmuFault, Reason::LateThread] {
        let found = after_rest(|c| c.controller = Some((reason, 3.0)));
        assert_eq!(found.map(|t| (t.0, t.2)), Some((reason, 3.0)));
    }
    assert_eq!(after_rest(|c| c.overrun_us = 2000.0), None);
    let late = after_rest(|c| c.overrun_us = 2000.1);
    assert_eq!(late, Some((Reason::Overrun, None, 2000.1, 2000.0)));
}
