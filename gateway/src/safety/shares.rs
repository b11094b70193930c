//! How near a run came to its limits.

use std::cell::Cell;

use crate::rules::Reason;

/// Rules with a value and a limit, each with the largest share of its limit so far.
#[derive(Clone, Debug, Default)]
pub struct Shares([Cell<f64>; RULES.len()]);

const RULES: [Reason; 8] = [
    Reason::Torque,
    Reason::TorqueStep,
    Reason::MeasuredTorque,
    Reason::FeedbackTorque,
    Reason::Thermal,
    Reason::Jump,
    Reason::Speed,
    Reason::FollowingError,
];

impl Shares {
    /// A value that was judged by its limit.
    pub fn note(&self, reason: Reason, value: f64, limit: f64) {
        let Some(place) = RULES.iter().position(|rule| *rule == reason) else { return };
        let share = (value / limit).abs();
        // nothing is a share of a limit of 0, which is not judged
        if share.is_finite() && share > self.0[place].get() {
            self.0[place].set(share);
        }
    }

    /// Rule and share, the nearest first; of rules that were judged.
    pub fn list(&self) -> Vec<(Reason, f64)> {
        let mut all: Vec<_> = RULES.into_iter().zip(self.0.iter().map(Cell::get)).collect();
        all.retain(|(_, share)| *share > 0.0);
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_share_of_either_sign_stays_and_the_nearest_is_first() {
        let shares = Shares::default();
        for (value, limit) in [(0.1, 1.0), (-0.6, 2.0), (0.2, 1.0), (f64::NAN, 1.0), (1.0, 0.0)] {
            shares.note(Reason::Speed, value, limit);
        }
        shares.note(Reason::Jump, 4.0, 5.0);
        shares.note(Reason::Panic, 4.0, 5.0);
        assert_eq!(shares.list(), [(Reason::Jump, 0.8), (Reason::Speed, 0.3)]);
    }
}
