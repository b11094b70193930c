//! A panic in the control loop lands the machine.

use super::rig::{run, Line, COMMAND, LRW};
use super::*;
use crate::rules::{ReactionKind, Reason};

/// Frame of process data in which the link panics: the lift-off takes some 12 000.
const PANIC_AT: u64 = 16_000;

struct Panics<'a> {
    line: &'a mut Line,
    frames: u64,
}

impl Link for Panics<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.frames += u64::from(frame[COMMAND] == LRW);
        if self.frames == PANIC_AT {
            self.frames += 1;
            panic!("on purpose");
        }
        self.line.send(frame)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.line.receive(buffer)
    }

    fn wait(&mut self, _: u64) {}
}

#[test]
fn a_panic_in_a_cycle_lands_the_machine() {
    let mut line = Line::open("");
    let ran = run(Panics { line: &mut line, frames: 0 }, 1_000_000);
    let out = &ran.out;
    let Ending::Tripped(trip, _) = &out.ending else { panic!("it did not trip") };
    assert_eq!((trip.reason, out.reaction), (Reason::Panic, ReactionKind::Land));
    assert!(trip.cycle > 1000, "in the run: {}", trip.cycle);
    assert_eq!((out.unconfirmed(), out.landing_trip), (vec![], None));
    // braking, two pauses and the way back: nothing is let fall
    assert!(out.to_zero > 8000, "{}", out.to_zero);
    assert_eq!(ran.phases(), [3.0, 1.0, 4.0, 2.0], "lift-off, run, landing, disabling");
    let theta = ran.place("theta[1]");
    let (first, last) = (&ran.rows[0], &ran.rows[ran.rows.len() - 1]);
    for k in theta..theta + AXES {
        assert!(first[k] < -0.2 && (last[k] - first[k]).abs() < 0.02, "{} {}", first[k], last[k]);
    }
    line.leave_alone(2.0);
    assert!(line.line.extremes().0 < 1.0, "{:?}", line.line.extremes());
}
