//! From a trip to disabled drives: torque and controlword of every cycle.

use crate::bus::cia402::{self, State};
use crate::config::AXES;
use crate::rules::ReactionKind;

/// Cycles that a drive may take to follow a controlword before the next one is sent regardless.
const RESPONSE_LIMIT: u32 = 400;

/// A reaction in progress.
#[derive(Clone, Debug)]
pub struct Reaction {
    kind: ReactionKind,
    from: [f64; AXES],
    ramp: u32,
    done: u32,
}

impl Reaction {
    /// `from`: torque of the last good cycle [N m]; `ramp`: cycles that a ramp takes.
    pub fn new(kind: ReactionKind, from: [f64; AXES], ramp: u32) -> Self {
        Reaction { kind, from, ramp: if kind == ReactionKind::Ramp { ramp } else { 0 }, done: 0 }
    }

    /// Torque [N m] and controlword of the next frame, after these statuswords.
    pub fn next(&mut self, statusword: &[u16; AXES]) -> ([f64; AXES], u16) {
        self.done += 1;
        let enabled = |s: &u16| cia402::state(*s) == State::OperationEnabled;
        if self.done < self.ramp && !statusword.iter().all(enabled) {
            // the controlword of a ramp would enable a drive again that has left operation enabled
            self.done = self.ramp;
            self.kind = ReactionKind::Zero;
        }
        if self.done < self.ramp {
            let share = 1.0 - f64::from(self.done) / f64::from(self.ramp);
            return (self.from.map(|t| t * share), cia402::ENABLE_OPERATION);
        }
        let since = self.done - self.ramp.max(1);
        let word = match self.kind {
            ReactionKind::QuickStop if since < RESPONSE_LIMIT / 2 => cia402::QUICK_STOP,
            ReactionKind::Ramp if since < RESPONSE_LIMIT / 2 => cia402::SHUTDOWN,
            _ => cia402::DISABLE_VOLTAGE,
        };
        ([0.0; AXES], word)
    }

    /// All drives are without power, or the time limit has passed.
    pub fn over(&self, statusword: &[u16; AXES]) -> bool {
        let off = |s: &u16| !cia402::state(*s).is_energised() || cia402::state(*s) == State::Fault;
        let disabled = self.done > self.ramp && statusword.iter().all(off);
        disabled || self.done > self.ramp + RESPONSE_LIMIT
    }
}

#[cfg(test)]
#[path = "reaction_tests.rs"]
mod tests;
