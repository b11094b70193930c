//! A run that moves from pose to pose by the feedback of the lift-off, without the controller.

use super::{ControlLoop, Ending, Phase, Stood};
use crate::config::AXES;
use crate::motion::{Pace, Path};
use crate::rules::Reason;
use crate::wire::Link;

impl<L: Link> ControlLoop<'_, L> {
    /// Where the lift-off leads, if not to the start of the reference.
    pub(super) fn first_pose(&self) -> Option<[f64; AXES]> {
        self.options.poses.first().copied()
    }

    /// Times of the motions of this phase.
    pub(super) fn pace(&self) -> Pace {
        let pace = self.mechanics.pace;
        match self.options.poses.is_empty() {
            true => pace,
            false => Pace { pause: self.options.hold, ..pace },
        }
    }

    /// A path is over: on to the next pose, or to the end. False where the controller is to begin.
    pub(super) fn next_pose(&mut self) -> bool {
        let Some(now) = self.options.poses.get(self.pose).copied() else { return false };
        self.pose += 1;
        let (next, pace) = (self.options.poses.get(self.pose).copied(), self.pace());
        let Phase::Lifting(mover) = &mut self.phase else { return true };
        match next {
            Some(next) => {
                mover.follow(Path::new(now, [0.0; AXES], next, pace));
                let bounds = self.moving_bounds(&[now, next], &[0.0; AXES]);
                let bounds = self.lifting_bounds(bounds);
                self.safety.enter(bounds);
            }
            None => self.end(Ending::Done, Reason::Stopped),
        }
        true
    }

    /// Adds a cycle to the means of the pose that is held.
    pub(super) fn note_stood(&mut self, left: u32, theta: &[f64; AXES], tau: &[f64; AXES]) {
        let Some(pose) = self.options.poses.get(self.pose) else { return };
        let half = self.options.hold / 2.0 / self.safety.base_step();
        if f64::from(left) > half {
            return;
        }
        if self.out.stood.len() <= self.pose {
            // its memory was taken before the run
            self.out.stood.push(Stood { pose: *pose, ..Stood::default() });
        }
        let Some(stood) = self.out.stood.last_mut() else { return };
        stood.cycles += 1;
        let share = 1.0 / f64::from(stood.cycles);
        for k in 0..AXES {
            stood.theta[k] += share * (theta[k] - stood.theta[k]);
            stood.tau_meas[k] += share * (tau[k] - stood.tau_meas[k]);
        }
    }
}
