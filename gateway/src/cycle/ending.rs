//! From the end of a run to disabled drives: which reaction, and what the drives say.

use std::panic::{catch_unwind, AssertUnwindSafe};

use super::{ControlLoop, Ending, Phase, UNANSWERED_LIMIT};
use crate::bus::Reply;
use crate::config::AXES;
use crate::realtime::stop;
use crate::rules::{ReactionKind, Reason, Trip};
use crate::safety::{disabled, of_motion};
use crate::wire::Link;

impl<L: Link> ControlLoop<'_, L> {
    /// A cycle; a panic in it lands the machine, a second one ends the run.
    pub(super) fn guarded_cycle(&mut self) -> bool {
        if let Ok(over) = catch_unwind(AssertUnwindSafe(|| self.cycle())) {
            return over;
        }
        let trip = Trip::of(Reason::Panic, None, 0.0, 0.0, self.controller.now());
        if std::mem::replace(&mut self.panicked, true) {
            return true;
        }
        self.end(Ending::Tripped(trip, String::new()), Reason::Panic);
        false
    }

    /// Begin the reaction; later events do not change the reason.
    pub(super) fn end(&mut self, ending: Ending, reason: Reason) {
        let powered = match self.phase {
            Phase::Running => !self.options.dry_run,
            // without feedback there is nothing that could land it, and it rests
            Phase::Lifting(_) => self.task.feeds_back(),
            Phase::Landing(_) => true,
            _ => false,
        };
        let mut kind = if powered { self.config.reactions.to(reason) } else { ReactionKind::Zero };
        if let (Phase::Lifting(_), Ending::Tripped(trip, _)) = (&self.phase, &ending) {
            kind = of_motion(trip, &self.config.reactions);
        }
        if stop::at_once() {
            kind = ReactionKind::Zero;
        }
        let mut blind = [false; AXES];
        if let (ReactionKind::Damp, Ending::Tripped(Trip { axis: Some(axis), .. }, _)) =
            (kind, &ending)
        {
            blind[*axis] = true;
        }
        (self.out.ending, self.out.reaction) = (ending, kind);
        if kind.lands() {
            self.land(blind);
        } else {
            self.take_power(kind);
        }
    }

    /// Zero torque until every drive is confirmed as disabled; true when the run is over.
    pub(super) fn disabling(&mut self, reply: &Reply) -> bool {
        let now =
            disabled(&reply.statusword, &reply.al_state, (reply.answered, reply.working_counter));
        let Phase::Disabling(disabling) = &self.phase else { return true };
        let over = disabling.over(&now);
        self.out.disabled = now;
        let n = self.after_end();
        if now == [true; AXES] {
            self.out.to_disabled.get_or_insert(self.stopped_for);
        }
        self.fill(n, reply, 0, 0);
        self.push(0);
        over || self.unanswered >= UNANSWERED_LIMIT
    }

    /// Number of a cycle after the end of the run; counts it.
    pub(super) fn after_end(&mut self) -> i64 {
        self.stopped_for += 1;
        let zero = self.sent.iter().all(|t| *t == 0.0);
        self.out.to_zero = match self.out.to_zero {
            _ if !zero => 0,
            0 => self.stopped_for,
            since => since,
        };
        self.controller.now() - 1 + i64::from(self.stopped_for)
    }
}
