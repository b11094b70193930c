//! The computer stands still in a run: for less than the watchdog of the drives it goes on, for longer they
//! have stopped.

use super::rig::{config, run_with, Line, Ran};
use super::*;
use crate::rules::{ReactionKind, Reason};
use flexhex_system::Value;

/// Cycle since the drives were enabled: the controller leads the machine.
const AT: u64 = 15_000;
const CYCLES: i64 = 6000;
const TS: f64 = 0.00025;

/// A line whose other end stands still for so many cycles.
fn line(cycles: u64) -> Line {
    Line::open(&format!("[[fault]]\nkind = \"stall\"\ncycle = {AT}\ncount = {cycles}\n"))
}

/// A run with a watchdog of 20 ms, in which a cycle may be as late.
fn stalled(line: &mut Line) -> Ran {
    let mut config = config();
    (config.bus.watchdog_ms, config.safety.overrun_us) = (20, 20_000);
    // the reference moves from the first cycle on
    config.system.parameters.insert("reference.t_start".to_owned(), Value::Number(0.0));
    run_with(&config, line, CYCLES, |_| ())
}

#[test]
fn a_run_goes_on_after_10_ms_without_a_cycle() {
    let mut line = line(40);
    let ran = stalled(&mut line);
    assert_eq!(ran.out.skipped, 40);
    assert!(matches!(ran.out.ending, Ending::Done), "{}", ran.out.cycles);
    assert!(ran.out.good());
    let column = |name: &str| {
        let (phase, place) = (ran.place("phase"), ran.place(name));
        let running = ran.rows.iter().filter(|row| row[phase] == 1.0);
        running.map(|row| row[place]).collect::<Vec<_>>()
    };
    let largest_step = |values: &[f64]| {
        values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
    };
    // the reference keeps pace with time
    let times = column("time");
    assert_eq!(times.len() as i64, CYCLES - 40);
    assert!((largest_step(&times) - 41.0 * TS).abs() < 1e-9);
    // the torque of the last frame acts all the while: what it does is less than the motion itself, and over soon
    line.leave_alone(2.0);
    let (fastest, _) = line.line.extremes();
    for axis in 1..=AXES {
        let error = column(&format!("e[{axis}]"));
        assert!(error[error.len() - 400..].iter().all(|e| e.abs() < 1e-3), "axis {axis}");
    }
    let rates = (1..=AXES).map(|axis| largest_step(&column(&format!("r[{axis}]"))[..3000]) / TS);
    let reference = rates.fold(0.0, f64::max);
    assert!(reference > 0.3 && fastest < 2.0 * reference, "{fastest} rad/s, wanted {reference}");
}

#[test]
fn after_300_ms_the_drives_have_stopped_and_the_first_cycle_trips() {
    let mut line = line(1200);
    let ran = stalled(&mut line);
    let Ending::Tripped(trip, _) = &ran.out.ending else { panic!("it did not trip") };
    assert_eq!((trip.reason, ran.out.reaction), (Reason::AlState, ReactionKind::Zero));
    assert_eq!((ran.out.to_zero, ran.out.unconfirmed()), (1, vec![]));
    line.leave_alone(2.0);
    let (fastest, _) = line.line.extremes();
    assert!(fastest < 1.0, "{fastest}");
}
