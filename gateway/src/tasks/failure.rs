//! What a task did not find. Axes are counted from 0.

use std::fmt::{self, Display, Formatter};

/// Why a task cannot go on.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// It stands still while it should move.
    Dead(usize),
    /// No end stop within so far of the rest pose [rad].
    NoStop { axis: usize, within: f64 },
    /// Angles of the stop in two passes, and the largest difference [rad].
    NotRepeated { axis: usize, angles: [f64; 2], allowed: f64 },
    /// It moves so far by itself that nothing can be told of a push [rad].
    Swings { off: f64, allowed: f64 },
}

impl Display for Failure {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Failure::Dead(axis) => write!(
                f,
                "axis {}: its encoder stands still while it should move: it is blocked, or its encoder is dead",
                axis + 1
            ),
            Failure::NoStop { axis, within } => write!(
                f,
                "axis {}: no end stop within {within} rad of the rest pose: raise homing.within_rad, or move \
                 by hand and use --at",
                axis + 1
            ),
            Failure::Swings { off, allowed } => write!(
                f,
                "the machine still swings: {off:.5} rad without a push, allowed {allowed} rad: wait until it rests"
            ),
            Failure::NotRepeated { axis, angles: [first, second], allowed } => write!(
                f,
                "axis {}: the end stop was met at {first:.5} and at {second:.5} rad, allowed {allowed} rad \
                 apart: something else stopped it, or the torque (homing.torque_N_m) is too low",
                axis + 1
            ),
        }
    }
}

/// What is wrong with an axis that was pushed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wrong {
    /// This axis moved more, by so much [rad].
    Exchanged(usize, f64),
    Still,
    Against,
}

impl Display for Wrong {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Wrong::Exchanged(axis, far) => write!(
                f,
                "axis {} moved more, by {far:.5} rad: drives or encoders are exchanged",
                axis + 1
            ),
            Wrong::Still => f.write_str(
                "it hardly moved: it is blocked, rests on a stop, or needs more torque (--torque)",
            ),
            Wrong::Against => f.write_str(
                "it moved against its torque: encoder or motor phases of this drive count the other way; \
                 `direction` turns both and does not mend it",
            ),
        }
    }
}
