//! Taking the power away: controlword of every cycle, and whether it is confirmed by statuswords.

use crate::bus::cia402::{self, State};
use crate::config::AXES;
use crate::rules::{ReactionKind, Reactions, Reason, Trip};

/// Cycles that a drive may take to follow a controlword before the next one is sent regardless.
const RESPONSE_LIMIT: u32 = 400;

/// Drives that lose their power, under zero torque.
#[derive(Clone, Debug)]
pub struct Disabling {
    kind: ReactionKind,
    done: u32,
}

impl Disabling {
    pub fn new(kind: ReactionKind) -> Self {
        Disabling { kind, done: 0 }
    }

    /// Controlword of the next frame.
    pub fn next(&mut self) -> u16 {
        self.done += 1;
        match self.kind {
            ReactionKind::QuickStop if self.done <= RESPONSE_LIMIT / 2 => cia402::QUICK_STOP,
            ReactionKind::Land if self.done <= RESPONSE_LIMIT / 2 => cia402::SHUTDOWN,
            _ => cia402::DISABLE_VOLTAGE,
        }
    }

    /// Every drive is confirmed as disabled, or the time limit has passed.
    pub fn over(&self, disabled: &[bool; AXES]) -> bool {
        self.done > 0 && disabled.iter().all(|d| *d) || self.done > RESPONSE_LIMIT
    }
}

/// The stop that follows on a trip in a motion of the gateway itself. An axis that its feedback does not keep on
/// a slow path is not landed by the same feedback: its encoder or its drive is wrong.
pub fn of_motion(trip: &Trip, reactions: &Reactions) -> ReactionKind {
    let lost = matches!(trip.reason, Reason::Speed | Reason::FollowingError | Reason::Position);
    match (reactions.to(trip.reason), trip.axis) {
        (ReactionKind::Land, Some(_)) if lost => reactions.frozen_encoder,
        (kind, _) => kind,
    }
}

/// What follows when a rule trips during a landing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InLanding {
    /// It is told, and the landing goes on: drives and encoders are sound.
    GoOn,
    /// The landing goes on by the other axes, while the drive of this one brakes it.
    Blind(usize),
    TakePower(ReactionKind),
}

/// `kind`: the configured reaction to this reason; `blind`: axes that are braked by their drives already.
pub fn in_landing(trip: &Trip, kind: ReactionKind, blind: &[bool; AXES]) -> InLanding {
    match (trip.reason, trip.axis) {
        // a fall is worse than a late cycle, a warm motor or a pose on the way that is near a singular one; where the
        // drives do not bear it, they or the axes say so
        (Reason::Overrun | Reason::Thermal | Reason::Singular, _) if kind.lands() => {
            InLanding::GoOn
        }
        (_, Some(axis)) if kind == ReactionKind::Damp && !blind.contains(&true) => {
            InLanding::Blind(axis)
        }
        _ if kind.lands() => InLanding::TakePower(ReactionKind::Zero),
        _ => InLanding::TakePower(kind),
    }
}

/// Axes whose statusword in this reply says that they have no power. An incomplete reply says it of the
/// devices that answered; where the counter does not tell which these are, of none.
pub fn disabled(
    statusword: &[u16; AXES],
    al_state: &[u8; AXES],
    (answered, working_counter): (bool, u16),
) -> [bool; AXES] {
    let present = al_state.iter().filter(|al| **al != 0).count();
    let complete = answered && usize::from(working_counter) == 3 * present;
    std::array::from_fn(|k| {
        let state = cia402::state(statusword[k]);
        complete && al_state[k] != 0 && (!state.is_energised() || state == State::Fault)
    })
}

#[cfg(test)]
#[path = "reaction_tests.rs"]
mod tests;
