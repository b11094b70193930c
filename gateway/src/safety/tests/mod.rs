//! Every rule on both sides of its limit.

mod monitors;
mod motion;

use super::{Measured, Safety};
use crate::config::{parse, Config, AXES};
use crate::rules::{Reason, Trip};

const COMPLETE: u16 = 18;
const TS: f64 = 0.00025;

/// Torques may jump: the rules on their changes have tests of their own.
fn config() -> Config {
    let mut config = parse(include_str!("../../../machines/akd.toml")).unwrap();
    let l = &mut config.limits;
    (l.torque_step, l.measured_torque, l.feedback_torque) = (0.0, 0.0, 0.0);
    config
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
    feedback: Option<[f64; AXES]>,
    pose: [f64; 2],
    gain: Option<f64>,
    r: [f64; AXES],
    e: [f64; AXES],
    statusword: [u16; AXES],
    error_code: [u16; AXES],
    al_state: [u8; AXES],
    mode: [Option<i8>; AXES],
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
            feedback: None,
            pose: [0.3, 0.0],
            gain: None,
            r: [0.0; AXES],
            e: [0.0; AXES],
            statusword: [0x1637; AXES],
            error_code: [0; AXES],
            al_state: [8; AXES],
            mode: [Some(4); AXES],
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
            feedback: self.feedback.as_ref(),
            pose: &self.pose,
            gain: self.gain,
            r: &self.r,
            e: &self.e,
            statusword: &self.statusword,
            error_code: &self.error_code,
            al_state: &self.al_state,
            mode: &self.mode,
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
fn replies_that_fail_too_often_trip_and_seldom_ones_do_not() {
    // n of every m cycles fail, for ever; the limits are 8 lost and 3 incomplete
    for (n, m, lost) in [(1, 5, None), (1, 3, Some(true)), (7, 8, Some(true))] {
        for short in [false, true] {
            let mut safety = safety();
            let mut cycle = Cycle::rest();
            let mut trip = None;
            for k in 0..2000 {
                cycle.n = k;
                let fails = k % m < n;
                (cycle.answered, cycle.working_counter) =
                    if short { (true, if fails { 15 } else { 18 }) } else { (!fails, 18) };
                cycle.theta = [1e-9 * k as f64; AXES];
                trip = trip.or(cycle.judged(&mut safety));
            }
            let reason = if short { Reason::WorkingCounter } else { Reason::LostFrames };
            assert_eq!(trip.map(|t| t.reason), lost.map(|_| reason), "{n} of {m}");
        }
    }
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
        let trip = after_rest(|c| c.controller = Some((reason, 3.0)));
        assert_eq!(trip.map(|t| (t.0, t.2)), Some((reason, 3.0)));
    }
    assert_eq!(after_rest(|c| c.overrun_us = 2000.0), None);
    let late = after_rest(|c| c.overrun_us = 2000.1);
    assert_eq!(late, Some((Reason::Overrun, None, 2000.1, 2000.0)));
}

#[test]
fn another_mode_trips_where_it_is_shown() {
    let wanted = Some((Reason::Mode, Some(3), 8.0, 4.0));
    assert_eq!(after_rest(|c| c.mode[3] = Some(8)), wanted);
    assert_eq!(after_rest(|c| c.mode = [None; AXES]), None);
    let mut dry = Safety::new(&config(), TS, COMPLETE, false);
    let cycle = Cycle { mode: [Some(8); AXES], ..Cycle::rest() };
    assert_eq!(cycle.judged(&mut dry), None, "no drive is enabled");
}
