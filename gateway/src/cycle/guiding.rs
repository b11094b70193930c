//! What a task wants, done: the next leg, a push, the controller, the end.

use super::refusal::Refusal;
use super::{ControlLoop, Ending, Phase};
use crate::bus::Reply;
use crate::config::AXES;
use crate::rules::Reason;
use crate::safety::Bounds;
use crate::tasks::{Leg, Seen, Step};
use crate::wire::Link;

impl<L: Link> ControlLoop<'_, L> {
    /// Limits on a leg: those of a lift-off. An axis that seeks its stop may lag behind, and stands there with
    /// constant counts.
    pub(super) fn leg_bounds(&self, leg: &Leg) -> Bounds {
        let bounds = self.moving_bounds(&[leg.from, leg.to], &[0.0; AXES]);
        let mut bounds = bounds.closer(self.config.landing.following_error);
        if let Some((axis, _)) = leg.seeks {
            bounds.following_error[axis] = self.config.limits(axis).following_error;
        }
        bounds.may_stand = leg.seeks.is_some();
        bounds
    }

    /// Asks the task what comes next, and does it.
    pub(super) fn guide(&mut self, reply: &Reply, complete: bool) {
        let Phase::Lifting(mover) = &mut self.phase else { return };
        let (r, left) = (mover.r, mover.left());
        let (theta, tau_meas) = (&reply.theta, &reply.tau);
        let step = self.task.step(&Seen { complete, theta, tau_meas, r: &r, left });
        match step {
            Step::Stay => {}
            Step::Push(axis, torque) => mover.push[axis] = torque,
            Step::Go(leg) => self.go(&leg),
            Step::Begin => {
                self.safety.begin(Bounds::of(self.config, true), self.sent);
                self.inputs = super::inputs::Inputs::default();
                self.phase = Phase::Running;
            }
            Step::Over => self.end(Ending::Done, Reason::Stopped),
            Step::Fail(why) => self.end(Ending::Refused(Refusal::Task(why)), Reason::Stopped),
        }
    }

    fn go(&mut self, leg: &Leg) {
        let (path, bounds) = (leg.path(self.mechanics.pace), self.leg_bounds(leg));
        let Phase::Lifting(mover) = &mut self.phase else { return };
        mover.follow(path);
        mover.most = [self.mechanics.torque; AXES];
        if let Some((axis, torque)) = leg.seeks {
            mover.most[axis] = torque;
        }
        self.safety.enter(bounds);
    }
}
