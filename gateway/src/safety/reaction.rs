//! From the trip to disabled drives: torque and controlword of every cycle on the way.

use super::reason::Kind;
use crate::bus::cia402::{self, State};
use crate::config::AXES;

/// Cycles that a drive may take to answer a controlword before the next one is given anyhow.
const PATIENCE: u32 = 400;

/// A reaction under way.
#[derive(Clone, Debug)]
pub struct Reaction {
    kind: Kind,
    from: [f64; AXES],
    ramp: u32,
    done: u32,
}

impl Reaction {
    /// `from`: torque of the last good cycle [N m]; `ramp`: cycles that a ramp takes.
    pub fn new(kind: Kind, from: [f64; AXES], ramp: u32) -> Self {
        Reaction { kind, from, ramp: if kind == Kind::Ramp { ramp } else { 0 }, done: 0 }
    }

    /// Torque [N m] and controlword of the next frame, after these statuswords.
    pub fn next(&mut self, statusword: &[u16; AXES]) -> ([f64; AXES], u16) {
        self.done += 1;
        let enabled = |s: &u16| cia402::state(*s) == State::OperationEnabled;
        if self.done < self.ramp && !statusword.iter().all(enabled) {
            // the controlword of a ramp would lead a drive that has left back to power
            self.done = self.ramp;
            self.kind = Kind::Zero;
        }
        if self.done < self.ramp {
            let share = 1.0 - f64::from(self.done) / f64::from(self.ramp);
            return (self.from.map(|t| t * share), cia402::ENABLE_OPERATION);
        }
        let since = self.done - self.ramp.max(1);
        let word = match self.kind {
            Kind::QuickStop if since < PATIENCE / 2 => cia402::QUICK_STOP,
            Kind::Ramp if since < PATIENCE / 2 => cia402::SHUTDOWN,
            _ => cia402::DISABLE_VOLTAGE,
        };
        ([0.0; AXES], word)
    }

    /// Whether the drives are without power, or have had their time.
    pub fn over(&self, statusword: &[u16; AXES]) -> bool {
        let off = |s: &u16| !cia402::state(*s).is_energised() || cia402::state(*s) == State::Fault;
        let disabled = self.done > self.ramp && statusword.iter().all(off);
        disabled || self.done > self.ramp + PATIENCE
    }
}

#[cfg(test)]
#[path = "reaction_tests.rs"]
mod tests;
