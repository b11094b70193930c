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
