//! Enables the drives: from six disabled drives to cycle 0.

use super::{ControlLoop, Ending, Phase};
use crate::bus::al;
use crate::bus::cia402::{self, State};
use crate::bus::Reply;
use crate::config::AXES;
use crate::realtime::stop;
use crate::rules::Reason;
use crate::wire::Link;

impl<L: Link> ControlLoop<'_, L> {
    /// Whether this reply starts cycle 0: every drive is enabled. Refusals end the run.
    pub(super) fn armed(&mut self, reply: &Reply, tries: u64) -> bool {
        self.phase = Phase::Arming(tries + 1);
        if !reply.answered {
            if self.unanswered >= self.config.safety.lost_frame_limit {
                self.refuse(
                    "the drives stopped replying while they were being enabled: check the cable"
                        .to_owned(),
                );
            }
            return false;
        }
        let complete = reply.working_counter == self.bus.complete();
        if !complete {
            return self.waited_too_long(reply, tries);
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
            self.refuse(format!(
                "axis {}: AL status {al:#04x} while enabling, expected OP",
                axis + 1
            ));
            return false;
        }
        let faulty = states.iter().position(|s| *s == State::Fault);
        if let Some(axis) = faulty.filter(|_| !self.options.reset_faults || tries > 400) {
            let code = reply.error_code[axis];
            self.refuse(format!("axis {}: drive fault {code:#06x} while enabling", axis + 1));
            return false;
        }
        if stop::requested() {
            self.end(Ending::StopRequested, Reason::Stopped);
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
                self.refuse(left_behind(&states, self.config.landing.enable_ms));
                return false;
            }
        }
        self.waited_too_long(reply, tries)
    }

    fn waited_too_long(&mut self, reply: &Reply, tries: u64) -> bool {
        let most = u64::from(self.config.bus.state_timeout_ms) * 4;
        if tries > most {
            let names = reply.statusword.map(|word| cia402::state(word).name());
            self.refuse(format!("not all drives reached operation enabled: {names:?}"));
        }
        false
    }

    /// Why the drives must not be enabled, or not stay so: every complete reply is judged.
    fn not_at_rest(&mut self, reply: &Reply) -> Option<String> {
        let landing = &self.config.landing;
        let rest = landing.rest.filter(|_| self.task.is_homed());
        let speed = landing.rest_speed;
        self.safety.note_rest(&reply.theta);
        let rates = self.safety.history().rates();
        (0..AXES).find_map(|k| {
            let (l, theta) = (self.config.limits(k), reply.theta[k]);
            // it may rest on its end stop, which lies beyond the limits
            let (low, high) =
                (l.position_min - l.following_error, l.position_max + l.following_error);
            if !(theta >= low && theta <= high) {
                return Some(format!(
                    "axis {}: theta = {theta} rad, allowed {low} to {high} rad: move it by hand, or \
                     check drive[{k}].offset_counts and direction", k + 1
                ));
            }
            if rates[k].abs() > speed {
                return Some(format!(
                    "axis {}: it moves with {:.3} rad/s, allowed {speed} rad/s: wait until the machine \
                     rests", k + 1, rates[k]
                ));
            }
            let wanted = rest.map(|rest| rest[k]).filter(|r| (r - theta).abs() > l.following_error)?;
            Some(format!(
                "axis {}: theta = {theta} rad, landing.rest_rad = {wanted} rad, more than {} rad away: \
                 check drive[{k}].offset_counts and that nothing blocks the axis", k + 1, l.following_error
            ))
        })
    }

    fn refuse(&mut self, why: String) {
        self.end(Ending::Refused(why), Reason::Stopped);
    }
}

/// Drives that are not enabled although others are: these must not wait, as they carry no weight.
fn left_behind(states: &[State; AXES], most_ms: u32) -> String {
    let behind = states.iter().enumerate().filter(|(_, s)| **s != State::OperationEnabled);
    let named: Vec<_> = behind.map(|(k, s)| format!("axis {}: {}", k + 1, s.name())).collect();
    format!(
        "{}, but others have been enabled for more than landing.enable_ms = {most_ms}: read the warnings \
         of this drive, or raise enable_ms if it releases a brake",
        named.join(", ")
    )
}
