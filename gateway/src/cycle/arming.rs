//! Enables the drives: from six disabled drives to cycle 0.

use super::{ControlLoop, Ending, Phase};
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
        if tries == 0 {
            if let Some(why) = self.not_at_rest(reply) {
                self.refuse(why);
                return false;
            }
        }
        let states = reply.statusword.map(cia402::state);
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
        let complete = reply.working_counter == self.bus.complete();
        if complete && states.iter().all(|s| *s == State::OperationEnabled) {
            self.phase = Phase::Running;
            self.skipped_before = self.clock.skipped;
            return true;
        }
        let most = u64::from(self.config.bus.state_timeout_ms) * 4;
        if tries > most {
            let names = states.map(State::name);
            self.refuse(format!("not all drives reached operation enabled: {names:?}"));
        }
        false
    }

    /// Why the drives must not be enabled in this pose.
    fn not_at_rest(&self, reply: &Reply) -> Option<String> {
        (0..AXES).find_map(|k| {
            let (l, theta) = (self.config.limits(k), reply.theta[k]);
            let r = self.controller.bus()[self.signals.r[k]];
            let (low, high) = (l.position_min, l.position_max);
            if !(theta >= low && theta <= high) {
                return Some(format!(
                    "axis {}: theta = {theta} rad, allowed {low} to {high} rad: move it by hand, or \
                     check drive[{k}].offset_counts and direction", k + 1
                ));
            }
            let far = (r - theta).abs() > l.following_error;
            far.then(|| {
                format!(
                    "axis {}: theta = {theta} rad, the reference starts at {r} rad, more than {} rad away: \
                     move the axis there by hand, or check drive[{k}].offset_counts", k + 1, l.following_error
                )
            })
        })
    }

    fn refuse(&mut self, why: String) {
        self.end(Ending::Refused(why), Reason::Stopped);
    }
}
