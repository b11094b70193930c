//! Angles and poses outside their limits, and encoders that stand still.

use super::measured::Measured;
use super::Safety;
use crate::rules::{Reason, Trip};

impl Safety {
    /// Poses of the platform outside their limits.
    pub(super) fn pose(&self, m: &Measured) -> Option<Trip> {
        let mut all = self.rules.config.pose.iter().zip(m.pose);
        all.find(|(limit, value)| !limit.allows(**value)).map(|(limit, value)| {
            let bound = if *value < limit.min { limit.min } else { limit.max };
            Trip::of(Reason::Pose, None, *value, bound, m.cycle)
        })
    }

    /// A pose in which the motors hardly hold the platform.
    pub(super) fn singular(&self, m: &Measured) -> Option<Trip> {
        let (gain, most) = (m.gain?, self.rules.config.landing.platform_gain);
        // also of what is no number
        let regular = gain <= most;
        let judged = self.rules.bounds.powered && !regular;
        judged.then(|| Trip::of(Reason::Singular, None, gain, most, m.cycle))
    }

    pub(super) fn position(&self, k: usize, m: &Measured) -> Option<Trip> {
        let (low, high) = (self.rules.bounds.low[k], self.rules.bounds.high[k]);
        let limit = if m.theta[k] < low { low } else { high };
        let beyond = !(low..=high).contains(&m.theta[k]);
        beyond.then(|| Trip::of(Reason::Position, Some(k), m.theta[k], limit, m.cycle))
    }

    /// Constant encoder counts over many cycles while the reference moved, or over very many: counts as
    /// fine as these never stand still under control.
    pub(super) fn frozen(&self, k: usize, m: &Measured) -> Option<Trip> {
        let s = &self.rules.config.safety;
        let same = self.last.is_some_and(|last| last[k] == m.theta[k]);
        let moved = (m.r[k] - self.reference_at_change[k]).abs();
        let still = self.still[k] + 1;
        let (moving, always) = (s.frozen_cycles, s.frozen_still_cycles);
        let frozen = self.rules.bounds.powered
            && !self.rules.bounds.may_stand
            && self.complete(m)
            && same
            && (still >= moving && moved > s.frozen_motion_rad || always > 0 && still >= always);
        frozen
            .then(|| Trip::of(Reason::FrozenEncoder, Some(k), moved, s.frozen_motion_rad, m.cycle))
    }
}
