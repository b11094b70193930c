//! Inputs of the controller in cycles without a measurement: linear interpolation between two
//! replies, linear extrapolation after the newest. A constant angle while the machine moves would be
//! a step in speed for every component that differentiates it.

use crate::bus::Reply;
use crate::config::AXES;

/// Longest extrapolation [cycles]; after it the inputs stay constant.
const FARTHEST: f64 = 8.0;

/// Angles [rad] and torques [N m] by axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    pub theta: [f64; AXES],
    pub tau: [f64; AXES],
}

/// The newest measurement and its slope.
#[derive(Default)]
pub struct Inputs {
    last: Option<Values>,
    /// Change of the angles in one cycle.
    slope: [f64; AXES],
    /// Cycles since the newest measurement.
    age: f64,
}

impl Inputs {
    /// Inputs of this cycle, with `skipped` cycles since the one before.
    pub fn of(&mut self, reply: &Reply, skipped: u64) -> Values {
        self.age += 1.0 + skipped as f64;
        let last = self.last.unwrap_or(Values { theta: reply.theta, tau: reply.tau });
        if !reply.answered {
            let theta = along(&last.theta, &self.slope, self.age.min(FARTHEST));
            return Values { theta, tau: last.tau };
        }
        let now = Values { theta: reply.theta, tau: reply.tau };
        let age = self.age;
        self.slope = std::array::from_fn(|k| (now.theta[k] - last.theta[k]) / age);
        (self.last, self.age) = (Some(now), 0.0);
        now
    }
}

/// Inputs of skipped cycle `k` of `skipped` between `from` and `to`.
pub fn between(from: &Values, to: &Values, k: u64, skipped: u64) -> Values {
    let share = k as f64 / (skipped + 1) as f64;
    let line = |a: &[f64; AXES], b: &[f64; AXES]| {
        along(a, &std::array::from_fn(|axis| b[axis] - a[axis]), share)
    };
    Values { theta: line(&from.theta, &to.theta), tau: line(&from.tau, &to.tau) }
}

fn along(from: &[f64; AXES], slope: &[f64; AXES], far: f64) -> [f64; AXES] {
    std::array::from_fn(|k| from[k] + slope[k] * far)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reply(theta: f64, answered: bool) -> Reply {
        Reply { answered, theta: [theta; AXES], tau: [2.0 * theta; AXES], ..Reply::default() }
    }

    #[test]
    fn a_measurement_is_taken_as_it_is() {
        let mut inputs = Inputs::default();
        for theta in [0.1, -0.0, 0.3] {
            let values = inputs.of(&reply(theta, true), 0);
            assert_eq!(values.theta.map(f64::to_bits), [theta.to_bits(); AXES]);
            assert_eq!(values.tau, [2.0 * theta; AXES]);
        }
    }

    #[test]
    fn without_a_reply_the_line_goes_on_for_a_while() {
        let mut inputs = Inputs::default();
        // the first has no line yet; 1 in 4 cycles afterwards
        assert_eq!(inputs.of(&reply(1.0, false), 0).theta, [1.0; AXES]);
        inputs = Inputs::default();
        inputs.of(&reply(1.0, true), 0);
        inputs.of(&reply(2.0, true), 3);
        let still = reply(2.0, false);
        let seen: Vec<_> = (0..10).map(|_| inputs.of(&still, 0).theta[3]).collect();
        assert_eq!(seen, [2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 3.75, 4.0, 4.0, 4.0]);
        // a reply ends it: the line is then through what was measured
        assert_eq!(inputs.of(&reply(13.0, true), 0).theta, [13.0; AXES]);
        assert_eq!(inputs.of(&still, 0).theta, [14.0; AXES]);
    }

    #[test]
    fn cycles_skipped_lie_on_the_line_between_two_replies() {
        let values = |theta| Values { theta: [theta; AXES], tau: [-theta; AXES] };
        let seen = [1, 2, 3].map(|k| between(&values(1.0), &values(3.0), k, 3));
        assert_eq!(seen, [1.5, 2.0, 2.5].map(values));
    }
}
