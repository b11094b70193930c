//! One cycle of the controller: compute, judge, record.

use flexhex_system::{Component, Trip as Failure};

use super::inputs::{between, Values};
use super::{signals, ControlLoop, Ending, Phase};
use crate::bus::Reply;
use crate::config::AXES;
use crate::realtime::{now_ns, stop};
use crate::rules::Reason;
use crate::safety::Measured;
use crate::wire::Link;

/// Longest run of skipped cycles that is computed afterwards: some 10 us each, within the 5 ms of
/// the drives' watchdog.
const MOST_CAUGHT_UP: u64 = 400;

impl<L: Link> ControlLoop<'_, L> {
    /// A cycle of the controller: judge what was measured, compute what comes next.
    pub(super) fn running(&mut self, reply: &Reply, late_ns: u64, round_trip_ns: u64) {
        let skipped = self.newly_skipped();
        let values = self.inputs.of(reply, skipped);
        let begin = now_ns();
        let mut failure = self.catch_up(&values, skipped).err();
        let caught_up = now_ns() - begin;
        let n = self.controller.now();
        let (r, e) = (self.pick(self.signals.r), self.pick(self.signals.e));
        self.fill(n, reply, late_ns, round_trip_ns);
        let begin = now_ns();
        if failure.is_none() {
            failure = self.controller.cycle(&values.theta, &values.tau).err();
        }
        let gain = self.platform_gain(&values.theta, reply.answered);
        self.previous = values;
        self.given.note(&values, self.mechanics.pace);
        let compute = caught_up + now_ns() - begin;
        self.out.timing.compute.add(compute);
        let controller = match &failure {
            Some(failure) => Some(signals::reason(failure)),
            None => self.trip_fault().map(|(_, fault)| (Reason::FmuFault, fault)),
        };
        self.count(reply);
        let feedback = self.feedback();
        for (value, slot) in self.pose.iter_mut().zip(&self.signals.pose) {
            *value = self.controller.bus()[*slot];
        }
        let trip = self.safety.judge(&Measured {
            cycle: n,
            skipped,
            answered: reply.answered,
            working_counter: reply.working_counter,
            theta: &reply.theta,
            tau_meas: &reply.tau,
            tau: self.controller.command(),
            feedback: Some(&feedback),
            pose: &self.pose,
            gain,
            r: &r,
            e: &e,
            statusword: &reply.statusword,
            error_code: &reply.error_code,
            al_state: &reply.al_state,
            mode: &reply.mode,
            controller,
            overrun_us: late_ns as f64 / 1e3,
        });
        self.push(compute);
        self.note_errors(&e);
        if let Some(trip) = trip {
            let reason = trip.reason;
            let detail = match failure {
                Some(failure) => failure.message,
                None => self.fault_text(reason),
            };
            self.end(Ending::Tripped(trip, detail), reason);
        } else if stop::requested() {
            self.end(Ending::StopRequested, Reason::Stopped);
        } else if n + 1 >= self.options.cycles {
            self.end(Ending::Done, Reason::Stopped);
        }
    }

    /// Computes the cycles that the clock skipped, so that the reference keeps pace with time. Their
    /// torques are never sent.
    fn catch_up(&mut self, to: &Values, skipped: u64) -> Result<(), Failure> {
        let count = skipped.min(MOST_CAUGHT_UP);
        self.missed += skipped - count;
        for k in 1..=count {
            let values = between(&self.previous, to, k, count);
            self.controller.cycle(&values.theta, &values.tau)?;
        }
        Ok(())
    }

    /// How near to a singular pose the platform comes if it stops now; None in cycles in which that is not known. In a
    /// landing: where it is.
    pub(super) fn platform_gain(&mut self, theta: &[f64; AXES], measured: bool) -> Option<f64> {
        let workspace = self.workspace.as_mut().filter(|_| measured)?;
        if matches!(self.phase, Phase::Landing(_)) {
            return workspace.watch(theta);
        }
        let rates = self.safety.history().rates();
        workspace.watch(&workspace.stop(theta, &rates))
    }

    /// The first fault output whose value is not listed in `safety.non_trip_faults`.
    fn trip_fault(&self) -> Option<(&Component, f64)> {
        let listed = &self.config.safety.non_trip_faults;
        let trips = |(component, value): &(&Component, f64)| {
            !listed.get(component.name()).is_some_and(|values| values.contains(value))
        };
        let first = self.controller.faults().find(trips)?;
        (!self.options.dry_run).then_some(first)
    }

    /// Which component reports which fault, or which signal left its limits, where that is the reason of the trip.
    fn fault_text(&self, reason: Reason) -> String {
        if reason == Reason::Pose {
            let mut limits = self.config.pose.iter().zip(&self.pose);
            let first = limits.find(|(limit, value)| !limit.allows(**value));
            return first.map(|(limit, _)| limit.signal.clone()).unwrap_or_default();
        }
        let first = self.trip_fault().filter(|_| reason == Reason::FmuFault);
        first.map(|(component, fault)| component.fault_text(fault)).unwrap_or_default()
    }

    /// Cycles that the clock skipped since the last call.
    pub(super) fn newly_skipped(&mut self) -> u64 {
        let skipped = self.clock.skipped - self.skipped_before;
        self.skipped_before = self.clock.skipped;
        skipped
    }

    /// Count missing and incomplete replies.
    fn count(&mut self, reply: &Reply) {
        let complete = reply.working_counter == self.bus.complete();
        self.out.lost += u64::from(!reply.answered);
        self.out.short += u64::from(reply.answered && !complete);
    }

    pub(super) fn pick(&self, slots: [usize; AXES]) -> [f64; AXES] {
        slots.map(|slot| self.controller.bus()[slot])
    }

    /// What the next torques are beyond those of the model [N m].
    fn feedback(&self) -> [f64; AXES] {
        let (tau, model) = (self.controller.command(), self.pick(self.signals.tau_ff));
        std::array::from_fn(|k| tau[k] - model[k])
    }

    /// How near the run came to its limits.
    pub(super) fn shares(&self) -> Vec<(&'static str, f64)> {
        let rules = self.safety.shares().into_iter().map(|(reason, share)| (reason.key(), share));
        let [range, innovation] = self.controller.nearest();
        rules.chain([("estimate.range", range), ("estimate.innovation", innovation)]).collect()
    }

    fn note_errors(&mut self, e: &[f64; AXES]) {
        for (most, e) in self.out.most_error.iter_mut().zip(e) {
            *most = most.max(e.abs());
        }
    }
}
