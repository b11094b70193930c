//! From pose to pose; each is held, and what it takes is measured.

use super::arrivals::Arrivals;
use super::step::{Axes, Leg, Seen, Step};
use crate::config::AXES;

/// What was measured while a pose was held: means over the second half of that time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stood {
    pub pose: Axes,
    pub theta: Axes,
    pub tau_meas: Axes,
    pub cycles: u32,
}

pub struct Poses {
    list: Vec<Axes>,
    /// Time for which each is held [s].
    hold: f64,
    /// The second half of it in cycles.
    half: f64,
    /// Pose that is moved to or held.
    now: usize,
    pub stood: Vec<Stood>,
    arrivals: Arrivals,
}

impl Poses {
    pub fn new(list: Vec<Axes>, hold: f64, base_step: f64, arrivals: Arrivals) -> Poses {
        // its memory is taken before the run
        let stood = Vec::with_capacity(list.len());
        Poses { list, hold, half: hold / 2.0 / base_step, now: 0, stood, arrivals }
    }

    pub fn begin(&mut self, rest: &Axes) -> Option<Leg> {
        Some(Leg::new(*rest, *self.list.first()?).holding(self.hold))
    }

    pub fn step(&mut self, seen: &Seen) -> Step {
        let Some(now) = self.list.get(self.now).copied() else { return Step::Over };
        // the way is over, and the pause begins
        if f64::from(seen.left) <= 2.0 * self.half {
            self.arrivals.tell(&now, seen);
        }
        if seen.complete && f64::from(seen.left) <= self.half {
            self.note(now, seen);
        }
        if seen.left > 0 {
            return Step::Stay;
        }
        self.now += 1;
        self.arrivals.leave();
        match self.list.get(self.now) {
            Some(next) => Step::Go(Leg::new(now, *next).holding(self.hold)),
            None => Step::Over,
        }
    }

    /// Adds a cycle to the means of the pose that is held.
    fn note(&mut self, pose: Axes, seen: &Seen) {
        if self.stood.len() <= self.now {
            self.stood.push(Stood { pose, ..Stood::default() });
        }
        let Some(stood) = self.stood.last_mut() else { return };
        stood.cycles += 1;
        let share = 1.0 / f64::from(stood.cycles);
        for k in 0..AXES {
            stood.theta[k] += share * (seen.theta[k] - stood.theta[k]);
            stood.tau_meas[k] += share * (seen.tau_meas[k] - stood.tau_meas[k]);
        }
    }
}
