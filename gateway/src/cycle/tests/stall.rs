//! The computer stands still in a run: for less than the watchdog of the drives it goes on, for longer they
//! have stopped.

use std::cell::Cell;

use super::rig::{config, run_with, Line, Ran, COMMAND, LRW};
use super::*;
use crate::rules::{ReactionKind, Reason};
use flexhex_system::Value;

/// Cycles since the drives were found: the machine has lifted off and is led by the controller.
const AT: u64 = 16_000;
const CYCLES: i64 = 6000;
const TS: f64 = 0.00025;

/// A line that moves on without frames for a time [s].
struct Stalling<'a> {
    line: &'a mut Line,
    stall: &'a Cell<f64>,
}

impl Link for Stalling<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        if frame[COMMAND] == LRW {
            self.line.leave_alone(self.stall.take());
        }
        self.line.send(frame)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.line.receive(buffer)
    }

    fn wait(&mut self, _: u64) {}
}

/// A run whose computer stands still for so many cycles, with a watchdog of 20 ms.
fn stalled(line: &mut Line, cycles: u64) -> Ran {
    let mut config = config();
    config.bus.watchdog_ms = 20;
    // the reference moves from the first cycle on
    config.system.parameters.insert("reference.t_start".to_owned(), Value::Number(0.0));
    let stall = Cell::new(0.0);
    run_with(&config, Stalling { line, stall: &stall }, CYCLES, |control| {
        for _ in 0..AT {
            assert!(!control.guarded_cycle());
        }
        assert!(matches!(control.phase, Phase::Running));
        stall.set(cycles as f64 * control.safety.base_step());
        control.clock.skipped += cycles;
    })
}

#[test]
fn a_run_goes_on_after_10_ms_without_a_cycle() {
    let mut line = Line::open("");
    let ran = stalled(&mut line, 40);
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
    let mut line = Line::open("");
    let ran = stalled(&mut line, 1200);
    let Ending::Tripped(trip, _) = &ran.out.ending else { panic!("it did not trip") };
    assert_eq!((trip.reason, ran.out.reaction), (Reason::AlState, ReactionKind::Zero));
    assert_eq!((ran.out.to_zero, ran.out.unconfirmed()), (1, vec![]));
    line.leave_alone(2.0);
    let (fastest, _) = line.line.extremes();
    assert!(fastest < 1.0, "{fastest}");
}
