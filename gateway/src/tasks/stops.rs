//! A referencing run: each axis is led to its end stop at low torque, twice, while the others are held.

use super::failure::Failure;
use super::step::{Axes, Leg, Seen, Step};
use crate::config::AXES;

/// An axis stands when it comes less than this share of the way of its reference, in a window of at least this time [s]
/// and this way [rad].
const WINDOW_S: f64 = 0.03;
const FOLLOWS: f64 = 0.05;
const WAY: f64 = 5e-4;
/// Way from the rest pose before it is sought [rad]: an axis that does not move is not taken for one at its stop.
const AWAY: f64 = 0.03;
/// Largest difference of the two passes [rad].
const REPEATS: f64 = 1e-3;
/// An axis that stands before it has come this far [rad] is blocked, or its encoder is dead.
const CLEAR: f64 = 1e-3;
/// So is one whose counts are constant for this time [s] before it has come so far.
const DEAD_S: f64 = 0.025;

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
    /// Angle where the search began.
    first: f64,
    /// Cycles of the search, and angle and reference at the begin of this window.
    cycle: u32,
    window: (f64, f64),
    /// The newest angle, and cycles for which it has not changed.
    newest: f64,
    constant: u32,
    /// Angles of the stops by pass [rad].
    angles: [Axes; 2],
}

impl Stops {
    pub fn new(search: Search) -> Stops {
        Stops {
            search,
            rest: [0.0; AXES],
            axis: 0,
            pass: 0,
            part: Part::Away,
            first: 0.0,
            cycle: 0,
            window: (0.0, 0.0),
            newest: 0.0,
            constant: 0,
            angles: [[0.0; AXES]; 2],
        }
    }

    /// Mean angle of each stop [rad], where the machine stood when the run began as 0.
    pub fn angles(&self) -> Axes {
        std::array::from_fn(|k| 0.5 * (self.angles[0][k] + self.angles[1][k]))
    }

    /// Difference of the two passes [rad].
    pub fn spread(&self) -> Axes {
        std::array::from_fn(|k| (self.angles[0][k] - self.angles[1][k]).abs())
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
                (self.part, self.cycle) = (Part::Seek, 0);
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
        let now = (seen.theta[k], seen.r[k]);
        if self.cycle == 0 {
            (self.first, self.window, self.constant) = (now.0, now, 0);
        }
        self.constant = if now.0 == self.newest { self.constant + 1 } else { 0 };
        self.newest = now.0;
        let clear = (now.0 - self.first).abs() >= CLEAR;
        if !clear && f64::from(self.constant) * s.base_step >= DEAD_S {
            return Step::Fail(Failure::Dead(k));
        }
        self.cycle += 1;
        let (came, went) = ((now.0 - self.window.0).abs(), (now.1 - self.window.1).abs());
        if f64::from(self.cycle) * s.base_step >= WINDOW_S && went >= WAY {
            if came < FOLLOWS * went {
                return self.stands(seen.theta);
            }
            (self.cycle, self.window) = (1, now);
        }
        if seen.left == 0 {
            return Step::Fail(Failure::NoStop { axis: k, within: s.within });
        }
        Step::Stay
    }

    /// The axis stands.
    fn stands(&mut self, theta: &Axes) -> Step {
        let k = self.axis;
        if (theta[k] - self.first).abs() < CLEAR {
            return Step::Fail(Failure::Dead(k));
        }
        self.angles[self.pass][k] = theta[k];
        let mut from = self.rest;
        from[k] = theta[k];
        if self.pass == 0 {
            self.pass = 1;
            return Step::Go(self.away(from));
        }
        if self.spread()[k] > REPEATS {
            let angles = self.angles.map(|pass| pass[k]);
            return Step::Fail(Failure::NotRepeated { axis: k, angles, allowed: REPEATS });
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
