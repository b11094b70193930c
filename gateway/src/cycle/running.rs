//! A cycle of the controller with everything that is judged and recorded of it.

use std::sync::atomic::Ordering;

use flexhex_system::Trip as Failure;

use super::inputs::{between, Values};
use super::{signals, Ending, Machine};
use crate::bus::Reply;
use crate::config::AXES;
use crate::realtime::{now_ns, stop};
use crate::safety::{Measured, Reason};
use crate::wire::Link;

/// Cycles that are made up for after a gap of the clock, some 10 us each: the drives wait 5 ms.
const MOST_MADE_UP: u64 = 400;

impl<L: Link> Machine<'_, L> {
    /// A cycle of the controller: judge what was measured, compute what comes next.
    pub(super) fn running(&mut self, reply: &Reply, late_ns: u64, round_trip_ns: u64) {
        let skipped = self.clock.skipped - self.skipped_before;
        self.skipped_before = self.clock.skipped;
        let values = self.inputs.of(reply, skipped);
        let begin = now_ns();
        let mut failure = self.make_up(&values, skipped).err();
        let made_up = now_ns() - begin;
        let n = self.controller.now();
        let (r, e) = (self.pick(self.signals.r), self.pick(self.signals.e));
        self.fill(n, reply, late_ns, round_trip_ns);
        let begin = now_ns();
        if failure.is_none() {
            failure = self.controller.cycle(&values.theta, &values.tau).err();
        }
        self.taken = values;
        let compute = made_up + now_ns() - begin;
        self.out.timing.compute.add(compute);
        let controller = match &failure {
            Some(failure) => Some(signals::reason(failure)),
            None => self.untold_fault(),
        };
        let counters = (reply.answered, reply.working_counter == self.bus.complete());
        self.out.lost += u64::from(!counters.0);
        self.out.short += u64::from(counters.0 && !counters.1);
        let trip = self.safety.judge(&Measured {
            cycle: n,
            skipped,
            answered: reply.answered,
            working_counter: reply.working_counter,
            theta: &reply.theta,
            tau_meas: &reply.tau,
            tau: self.controller.command(),
            r: &r,
            e: &e,
            statusword: &reply.statusword,
            error_code: &reply.error_code,
            al_state: &reply.al_state,
            controller,
            overrun_us: if self.wanted.lockstep { 0.0 } else { late_ns as f64 / 1e3 },
        });
        self.push(compute);
        self.tell(n, &e);
        if let Some(trip) = trip {
            let said = failure.map(|f| f.message).unwrap_or_default();
            let reason = trip.reason;
            self.end(Ending::Tripped(trip, said), reason);
        } else if stop::asked() {
            self.end(Ending::Asked, Reason::Stopped);
        } else if n + 1 >= self.wanted.cycles {
            self.end(Ending::Done, Reason::Stopped);
        }
    }

    /// The cycles that the clock left out, so that the reference keeps to the time in which the
    /// machine moved on. Their torques are never sent.
    fn make_up(&mut self, to: &Values, skipped: u64) -> Result<(), Failure> {
        let count = skipped.min(MOST_MADE_UP);
        self.missed += skipped - count;
        for k in 1..=count {
            let values = between(&self.taken, to, k, count);
            self.controller.cycle(&values.theta, &values.tau)?;
        }
        Ok(())
    }

    /// The first fault output that does not only tell.
    fn untold_fault(&self) -> Option<(Reason, f64)> {
        let told = &self.config.safety.told_faults;
        let untold = |(name, value): &(&str, f64)| {
            !told.get(*name).is_some_and(|values| values.contains(value))
        };
        let first = self.controller.faults().find(untold)?;
        (!self.wanted.dry_run).then_some((Reason::FmuFault, first.1))
    }

    fn pick(&self, slots: [usize; AXES]) -> [f64; AXES] {
        slots.map(|slot| self.controller.bus()[slot])
    }

    fn tell(&mut self, n: i64, e: &[f64; AXES]) {
        let mut most: f64 = 0.0;
        for (seen, e) in self.out.most_error.iter_mut().zip(e) {
            *seen = seen.max(e.abs());
            most = most.max(e.abs());
        }
        self.pulse.cycle.store(n, Ordering::Relaxed);
        self.pulse.lost.store(self.out.lost, Ordering::Relaxed);
        self.pulse.error_nrad.store((most * 1e9) as u64, Ordering::Relaxed);
    }
}
