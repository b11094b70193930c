//! The trip rules: the one place that decides whether the run may go on.
//!
//! `Safety::judge` sees everything that a cycle measured before the next frame is sent and returns
//! the first violated rule with its values. It uses no sockets, clocks or FMUs.

mod angles;
mod bounds;
mod history;
mod level;
mod measured;
mod mode;
mod monitors;
mod reaction;
mod shares;
#[cfg(test)]
mod tests;

use crate::bus::al;
use crate::bus::cia402::{self, State};
use crate::config::{Config, AXES};
use crate::rules::{Reason, Trip};
pub use bounds::Bounds;
use history::History;
use level::Failures;
pub use measured::Measured;
use monitors::Monitors;
pub use reaction::{disabled, in_landing, of_motion, Disabling, InLanding};
use shares::Shares;

/// Limits, and the state of the rules from cycle to cycle.
pub struct Safety {
    rules: Rules,
    lost: Failures,
    short: Failures,
    /// Cycles since the last complete reply.
    age: u32,
    last: Option<[f64; AXES]>,
    history: History,
    monitors: Monitors,
    shares: Shares,
    still: [u32; AXES],
    reference_at_change: [f64; AXES],
}

struct Rules {
    config: Config,
    expected: u16,
    base_step: f64,
    bounds: Bounds,
}

impl Safety {
    /// `expected` is the working counter of a complete reply.
    pub fn new(config: &Config, base_step: f64, expected: u16, powered: bool) -> Self {
        let bounds = Bounds::of(config, powered);
        Safety {
            rules: Rules { config: config.clone(), expected, base_step, bounds },
            lost: Failures::default(),
            short: Failures::default(),
            age: 1,
            last: None,
            history: History::new(config.safety.speed_cycles, base_step),
            monitors: Monitors::new(config, base_step),
            shares: Shares::default(),
            still: [0; AXES],
            reference_at_change: [0.0; AXES],
        }
    }

    /// A phase of the run with bounds of its own begins.
    pub fn enter(&mut self, bounds: Bounds) {
        self.rules.bounds = bounds;
        self.still = [0; AXES];
        self.monitors.restart();
    }

    /// The controller begins, after a frame with these torques [N m].
    pub fn begin(&mut self, bounds: Bounds, sent: [f64; AXES]) {
        self.enter(bounds);
        self.monitors.begin_from(sent);
    }

    pub fn bounds(&self) -> &Bounds {
        &self.rules.bounds
    }

    /// Angles [rad] of a cycle before power: only their rate is judged then.
    pub fn note_rest(&mut self, theta: &[f64; AXES]) {
        self.history.note(*theta);
    }

    pub fn history(&self) -> &History {
        &self.history
    }

    /// How near the machine came to the limits of each rule, the nearest first.
    pub fn shares(&self) -> Vec<(Reason, f64)> {
        self.shares.list()
    }

    /// Cycle time [s].
    pub fn base_step(&self) -> f64 {
        self.rules.base_step
    }

    /// The first violated rule of this cycle, in the order from cause to consequence.
    pub fn judge(&mut self, m: &Measured) -> Option<Trip> {
        if m.skipped > 0 {
            // time passed without cycles: a larger change of angle is allowed, and no angle is known
            self.age += m.skipped as u32;
            self.history.skip(m.skipped);
        }
        let shown = (self.rules.bounds.powered, self.complete(m));
        let blind = &self.rules.bounds.blind;
        let torques = self.monitors.judge(m, (&self.rules.config, blind), shown, &self.shares);
        let trip = self
            .replies(m.answered, m.working_counter, m.cycle)
            .or_else(|| m.answered.then(|| self.drives(m).or_else(|| self.modes(m)))?)
            .or_else(|| self.motion(m))
            .or_else(|| self.pose(m))
            .or_else(|| self.singular(m))
            .or(torques)
            .or_else(|| self.controller(m));
        self.remember(m);
        trip
    }

    /// Cycles without a complete reply, in a row or too often. Also judged before all drives are enabled.
    pub fn replies(&mut self, answered: bool, working_counter: u16, cycle: i64) -> Option<Trip> {
        let s = &self.rules.config.safety;
        if let Some(lost) = self.lost.note(!answered, s.lost_frame_limit) {
            let (n, most) = (f64::from(lost), f64::from(s.lost_frame_limit));
            return Some(Trip::of(Reason::LostFrames, None, n, most, cycle));
        }
        if !answered {
            return None;
        }
        let short = working_counter != self.rules.expected;
        if self.short.note(short, s.working_counter_limit).is_some() {
            let (n, most) = (f64::from(working_counter), f64::from(self.rules.expected));
            return Some(Trip::of(Reason::WorkingCounter, None, n, most, cycle));
        }
        None
    }

    /// States and faults that the drives report.
    fn drives(&self, m: &Measured) -> Option<Trip> {
        for k in 0..AXES {
            let (status, al) = (m.statusword[k], m.al_state[k]);
            let trip = |reason, value: u16, expected: u16| {
                Some(Trip::of(reason, Some(k), value.into(), expected.into(), m.cycle))
            };
            // an absent device shows AL status 0: the working counter rule covers it
            if al != 0 && al & al::STATE != al::OP {
                return trip(Reason::AlState, al.into(), al::OP.into());
            }
            if self.rules.bounds.blind[k] {
                continue;
            }
            if al != 0 && status & cia402::FAULT_BIT != 0 {
                return trip(Reason::DriveFault, m.error_code[k], 0);
            }
            let enabled = cia402::state(status) == State::OperationEnabled;
            if al != 0 && self.rules.bounds.powered && !enabled {
                let shown = status & cia402::STATE_BITS;
                return trip(Reason::DriveState, shown, cia402::OPERATION_ENABLED);
            }
        }
        None
    }

    /// Torque, angle and speed of the axes. Missing or incomplete replies are not judged as motion.
    fn motion(&self, m: &Measured) -> Option<Trip> {
        for k in 0..AXES {
            let l = self.rules.config.limits(k);
            let over = |reason, value: f64, limit: f64| {
                self.shares.note(reason, value, limit);
                let beyond = value.is_nan() || value.abs() > limit;
                beyond.then(|| Trip::of(reason, Some(k), value, limit, m.cycle))
            };
            let (fresh, bounds) = (self.complete(m), &self.rules.bounds);
            let torque = over(Reason::Torque, m.tau[k], l.torque)
                .or_else(|| over(Reason::Torque, m.tau_meas[k], l.torque));
            if torque.is_some() {
                return torque;
            }
            if bounds.blind[k] {
                continue;
            }
            let trip = None
                .or_else(|| {
                    let last = self.last.filter(|_| fresh)?;
                    over(Reason::Jump, m.theta[k] - last[k], l.jump * f64::from(self.age))
                })
                .or_else(|| self.frozen(k, m))
                .or_else(|| {
                    over(Reason::Speed, self.history.mean_speed(k, m.theta[k])?, bounds.speed[k])
                })
                .or_else(|| self.position(k, m))
                .or_else(|| {
                    bounds
                        .powered
                        .then(|| over(Reason::FollowingError, m.e[k], bounds.following_error[k]))?
                });
            if trip.is_some() {
                return trip;
            }
        }
        None
    }

    fn controller(&self, m: &Measured) -> Option<Trip> {
        let limit = f64::from(self.rules.config.safety.overrun_us);
        m.controller.map(|(reason, value)| Trip::of(reason, None, value, 0.0, m.cycle)).or_else(
            || {
                let late = m.overrun_us > limit;
                late.then(|| Trip::of(Reason::Overrun, None, m.overrun_us, limit, m.cycle))
            },
        )
    }

    fn complete(&self, m: &Measured) -> bool {
        m.answered && m.working_counter == self.rules.expected
    }

    fn remember(&mut self, m: &Measured) {
        let complete = self.complete(m);
        for k in 0..AXES {
            let same = self.last.is_some_and(|last| last[k] == m.theta[k]);
            if complete && !same {
                self.still[k] = 0;
                self.reference_at_change[k] = m.r[k];
            } else if complete {
                self.still[k] += 1;
            }
        }
        self.history.note(if complete { *m.theta } else { [f64::NAN; AXES] });
        self.age = if complete { 1 } else { self.age + 1 };
        if complete {
            self.last = Some(*m.theta);
        }
    }
}
