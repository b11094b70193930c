//! Enables the drives: from six disabled drives to cycle 0.

use super::refusal::Refusal;
use super::{ControlLoop, Ending, Phase};
use crate::bus::al;
use crate::bus::cia402::{self, State};
use crate::bus::Reply;
use crate::config::{Homed, AXES};
use crate::realtime::stop;
use crate::rules::Reason;
use crate::wire::Link;

/// Angle [rad] up to which an axis may rest on the side from which its weight should have pulled it.
const ABOVE: f64 = 0.05;
/// Angle [rad] up to which an axis may rest elsewhere than when the machine was homed. After a landing it rests within
/// 3 mrad of where it did, after it was pressed against its stops or fell within 60 mrad, as friction holds it.
const HOMED: f64 = 0.1;

impl<L: Link> ControlLoop<'_, L> {
    /// Whether this reply starts cycle 0: every drive is enabled. Refusals end the run.
    pub(super) fn armed(&mut self, reply: &Reply, tries: u64) -> bool {
        self.phase = Phase::Arming(tries + 1);
        // whatever the reply is: an incomplete one says nothing against it
        if stop::requested() {
            self.end(Ending::StopRequested, Reason::Stopped);
            return false;
        }
        let counter = reply.working_counter;
        if let Some(trip) = self.safety.replies(reply.answered, counter, tries as i64) {
            self.refuse(Refusal::Replies(trip));
            return false;
        }
        if !reply.answered || counter != self.bus.complete() {
            return false;
        }
        if !self.zeroed {
            self.zeroed = true;
            self.out.offsets = self.bus.zero();
            return false;
        }
        if let Some(why) = self.not_at_rest(reply) {
            self.refuse(why);
            return false;
        }
        let states = reply.statusword.map(cia402::state);
        if let Some(axis) = reply.al_state.iter().position(|al| al & al::STATE != al::OP) {
            let al = reply.al_state[axis];
            self.refuse(Refusal::AlState { axis, al, code: None });
            return false;
        }
        let faulty = states.iter().position(|s| *s == State::Fault);
        if let Some(axis) = faulty.filter(|_| !self.options.reset_faults || tries > 400) {
            let code = reply.error_code[axis];
            self.refuse(Refusal::DriveFault { axis, code });
            return false;
        }
        if states.iter().all(|s| *s == State::OperationEnabled) {
            self.skipped_before = self.clock.skipped;
            self.previous.theta = reply.theta;
            let there = self.lift_off(&reply.theta);
            if there {
                self.phase = Phase::Running;
            }
            return there;
        }
        if states.contains(&State::OperationEnabled) {
            self.partly_enabled += 1;
            let most = f64::from(self.config.landing.enable_ms) * 1e-3;
            if f64::from(self.partly_enabled) * self.safety.base_step() > most {
                let most_ms = self.config.landing.enable_ms;
                self.refuse(Refusal::LeftBehind { states, most_ms });
                return false;
            }
        }
        self.waited_too_long(reply, tries)
    }

    fn waited_too_long(&mut self, reply: &Reply, tries: u64) -> bool {
        let most = u64::from(self.config.bus.state_timeout_ms) * 4;
        if tries > most {
            let states = reply.statusword.map(cia402::state);
            self.refuse(Refusal::NotEnabled { states });
        }
        false
    }

    /// Why the drives must not be enabled, or not stay so: every complete reply is judged.
    fn not_at_rest(&mut self, reply: &Reply) -> Option<Refusal> {
        let landing = &self.config.landing;
        let homed = self.task.is_homed();
        let (rest, at_homing) = (
            landing.rest.filter(|_| homed),
            self.config.homed.as_ref().and_then(Homed::rest).filter(|_| homed),
        );
        let speed = landing.rest_speed;
        self.safety.note_rest(&reply.theta);
        let rates = self.safety.history().rates();
        (0..AXES).find_map(|axis| {
            let (l, theta) = (self.config.limits(axis), reply.theta[axis]);
            // it may rest on its end stop, which lies beyond the limits
            let (low, high) =
                (l.position_min - l.following_error, l.position_max + l.following_error);
            if !(theta >= low && theta <= high) {
                return Some(Refusal::Angle { axis, theta, low, high });
            }
            let (rate, limit) = (rates[axis], speed);
            if rate.abs() > limit {
                return Some(Refusal::Moving { axis, rate, limit });
            }
            let limit = l.following_error;
            if let Some(wanted) = at_homing.map(|rest| rest[axis]) {
                if (wanted - theta).abs() > HOMED {
                    return Some(Refusal::NotAsHomed { axis, theta, wanted, limit: HOMED });
                }
            }
            match rest.map(|rest| rest[axis]) {
                Some(wanted) if (wanted - theta).abs() > limit => {
                    Some(Refusal::NotAtRestPose { axis, theta, wanted, limit })
                }
                Some(_) => None,
                None => {
                    let weight = self.mechanics.weight[axis];
                    let above = theta * weight.signum() > ABOVE && weight != 0.0;
                    above.then_some(Refusal::AgainstWeight { axis, theta, weight })
                }
            }
        })
    }

    fn refuse(&mut self, why: Refusal) {
        self.end(Ending::Refused(why), Reason::Stopped);
    }
}
