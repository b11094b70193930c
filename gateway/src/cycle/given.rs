//! What the machine was given of late, and what it did meanwhile.

use flexhex_system::Motion;

use super::inputs::Values;
use crate::config::AXES;
use crate::motion::Pace;

/// Means over the time of braking, the newest cycles count most (a first-order lag).
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// Measured torques [N m].
    pub tau: [f64; AXES],
    theta: [f64; AXES],
}

impl Given {
    /// Of a machine that rests there without torque.
    pub fn at(theta: &[f64; AXES]) -> Given {
        Given { tau: [0.0; AXES], theta: *theta }
    }

    pub fn note(&mut self, values: &Values, pace: Pace) {
        let share = (pace.base_step / pace.brake).min(1.0);
        for k in 0..AXES {
            self.tau[k] += share * (values.tau[k] - self.tau[k]);
            self.theta[k] += share * (values.theta[k] - self.theta[k]);
        }
    }

    /// The mean motion, of a machine that is at `theta` with `rate` now. By the lag of `time`, a mean of rates is the
    /// difference of an angle and its own mean over `time`.
    pub fn motion(&self, theta: &[f64; AXES], rate: &[f64; AXES], time: f64) -> Motion {
        let thetad: [f64; AXES] = std::array::from_fn(|k| (theta[k] - self.theta[k]) / time);
        let thetadd = std::array::from_fn(|k| (rate[k] - thetad[k]) / time);
        Motion { theta: self.theta, thetad, thetadd }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A torque of 3 N m and 20 rad/s2 for long.
    #[test]
    fn means_of_a_uniform_acceleration_are_those_of_a_lag() {
        let pace = Pace { speed: 0.25, brake: 0.1, pause: 0.3, base_step: 2.5e-4 };
        let mut given = Given::at(&[0.0; AXES]);
        let (mut theta, mut rate) = (0.0, 0.0);
        for k in 0..4000 {
            let time = f64::from(k) * pace.base_step;
            (theta, rate) = (10.0 * time * time, 20.0 * time);
            given.note(&Values { theta: [theta; AXES], tau: [3.0; AXES] }, pace);
        }
        let mean = given.motion(&[theta; AXES], &[rate; AXES], pace.brake);
        // the lag is discrete, shorter by a cycle of 400: so is the way, and by rate / (400 time) the acceleration
        let near = |value: f64, wanted: f64| (value / wanted - 1.0).abs() < 5e-3;
        let shorter = rate / (400.0 * pace.brake);
        assert!(near(given.tau[0], 3.0));
        assert!(near(mean.thetad[0], rate - 20.0 * pace.brake), "{mean:?}");
        assert!(near(mean.thetadd[0], 20.0 + shorter), "{mean:?}");
        assert!(near(mean.theta[0], theta - rate * pace.brake + 20.0 * pace.brake.powi(2)));
    }
}
