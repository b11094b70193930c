//! A referencing run: each axis is led to its end stop at low torque, twice, while the others are held.

use super::{Axes, Leg, Seen, Step};
use crate::config::AXES;

/// It stands at its stop when the torque has been at its limit for this time [s] without more motion than this
/// [rad].
const STILL_S: f64 = 0.03;
const STILL: f64 = 5e-4;
/// Way from the rest pose before it is sought [rad]: an axis that does not move is not taken for one at its stop.
const AWAY: f64 = 0.03;
/// Largest difference of the two passes [rad].
const REPEATS: f64 = 1e-3;
/// Before it has come this far [rad], constant counts for this time [s] are those of a dead encoder, not of a stop.
const CLEAR: f64 = 1e-3;
const DEAD_S: f64 = 0.025;
/// Share of the limit from which on the torque counts as limited.
const LIMITED: f64 = 0.999;

/// How the stops are sought.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Torque [N m], speed [rad/s], farthest way from the rest pose [rad].
    pub torque: f64,
    pub speed: f64,
    pub within: f64,
    /// -1: the lower stops, 1: the upper ones.
    pub side: f64,
    pub base_step: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    Away,
    Seek,
    Return,
}

pub struct Stops {
    search: Search,
    rest: Axes,
    axis: usize,
    pass: usize,
    part: Part,
    /// Cycles for which the torque has been limited, and the angle when that began.
    limited: u32,
    began: f64,
    /// Angle where the search began, the newest one, and cycles for which that has not changed.
    first: Option<f64>,
    newest: f64,
    constant: u32,
    /// Angles of the stops by pass [rad].
    found: [Axes; 2],
}

impl Stops {
    pub fn new(search: Search) -> Stops {
        Stops {
            search,
            rest: [0.0; AXES],
            axis: 0,
            pass: 0,
            part: Part::Away,
            limited: 0,
            began: 0.0,
            first: None,
            newest: 0.0,
            constant: 0,
            found: [[0.0; AXES]; 2],
        }
    }

    /// Mean angle of each stop [rad], where the machine stood when the run began as 0.
    pub fn found(&self) -> Axes {
        std::array::from_fn(|k| 0.5 * (self.found[0][k] + self.found[1][k]))
    }

    /// Difference of the two passes [rad].
    pub fn spread(&self) -> Axes {
        std::array::from_fn(|k| (self.found[0][k] - self.found[1][k]).abs())
    }

    pub fn begin(&mut self, rest: &Axes) -> Leg {
        self.rest = *rest;
        self.away(*rest)
    }

    pub fn step(&mut self, seen: &Seen) -> Step {
        match self.part {
            Part::Seek => self.seek(seen),
            _ if seen.left > 0 => Step::Stay,
            Part::Away => {
                (self.part, self.limited) = (Part::Seek, 0);
                (self.first, self.constant) = (None, 0);
                let from = self.shifted(-self.search.side * AWAY);
                let to = self.shifted(self.search.side * self.search.within);
                let (speed, seeks) =
                    (Some(self.search.speed), Some((self.axis, self.search.torque)));
                Step::Go(Leg { speed, seeks, ..Leg::new(from, to) })
            }
            Part::Return if self.axis + 1 == AXES => Step::Over,
            Part::Return => {
                (self.axis, self.pass) = (self.axis + 1, 0);
                Step::Go(self.away(self.rest))
            }
        }
    }

    fn seek(&mut self, seen: &Seen) -> Step {
        let (k, s) = (self.axis, self.search);
        if !seen.complete {
            return Step::Stay;
        }
        if let Some(why) = self.dead(seen.theta[k]) {
            return Step::Fail(why);
        }
        let limited = seen.tau[k] * s.side >= LIMITED * s.torque;
        if !limited || self.limited == 0 || (seen.theta[k] - self.began).abs() > STILL {
            (self.limited, self.began) = (u32::from(limited), seen.theta[k]);
        } else {
            self.limited += 1;
        }
        if f64::from(self.limited) * s.base_step >= STILL_S {
            return self.stands(seen.theta);
        }
        if seen.left == 0 {
            return Step::Fail(format!(
                "axis {}: no end stop within {} rad of the rest pose: raise homing.within_rad, or move by \
                 hand and use --at",
                k + 1,
                s.within
            ));
        }
        Step::Stay
    }

    /// Why the encoder is not believed.
    fn dead(&mut self, theta: f64) -> Option<String> {
        let first = *self.first.get_or_insert(theta);
        self.constant = if theta == self.newest { self.constant + 1 } else { 0 };
        self.newest = theta;
        let still = f64::from(self.constant) * self.search.base_step >= DEAD_S;
        let clear = (theta - first).abs() > CLEAR;
        (still && !clear).then(|| {
            format!("axis {}: its encoder stands still while it should move", self.axis + 1)
        })
    }

    /// The axis stands at its stop.
    fn stands(&mut self, theta: &Axes) -> Step {
        let k = self.axis;
        self.found[self.pass][k] = theta[k];
        let mut from = self.rest;
        from[k] = theta[k];
        if self.pass == 0 {
            self.pass = 1;
            return Step::Go(self.away(from));
        }
        if self.spread()[k] > REPEATS {
            return Step::Fail(format!(
                "axis {}: the end stop was met at {:.5} and at {:.5} rad, allowed {REPEATS} rad apart: \
                 something else stopped it, or the torque (homing.torque_N_m) is too low",
                k + 1,
                self.found[0][k],
                self.found[1][k]
            ));
        }
        self.part = Part::Return;
        Step::Go(Leg::new(from, self.rest))
    }

    fn away(&mut self, from: Axes) -> Leg {
        self.part = Part::Away;
        Leg::new(from, self.shifted(-self.search.side * AWAY))
    }

    /// The rest pose with this axis elsewhere.
    fn shifted(&self, by: f64) -> Axes {
        let mut pose = self.rest;
        pose[self.axis] += by;
        pose
    }
}

#[cfg(test)]
#[path = "stops_tests.rs"]
mod tests;
