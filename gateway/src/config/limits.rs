//! Limits of an axis.

use serde::Deserialize;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    #[serde(rename = "torque_N_m")]
    pub torque: f64,
    #[serde(rename = "speed_rad_per_s")]
    pub speed: f64,
    #[serde(rename = "position_min_rad")]
    pub position_min: f64,
    #[serde(rename = "position_max_rad")]
    pub position_max: f64,
    #[serde(rename = "following_error_rad")]
    pub following_error: f64,
    /// Largest change of an angle in one cycle.
    #[serde(rename = "jump_rad")]
    pub jump: f64,
    /// Largest change of the wanted torque in one cycle; 0: not judged, as the two below.
    #[serde(rename = "torque_step_N_m", default = "torque_step")]
    pub torque_step: f64,
    /// Largest mean difference of the measured torque from the commanded one.
    #[serde(rename = "measured_torque_N_m", default = "measured_torque")]
    pub measured_torque: f64,
    /// Largest mean torque that the feedback adds to the model.
    #[serde(rename = "feedback_torque_N_m", default = "feedback_torque")]
    pub feedback_torque: f64,
    /// Largest root mean square of the measured torque over `safety.thermal_s`: that which the motor bears for
    /// ever.
    #[serde(rename = "rated_torque_N_m", default)]
    pub rated_torque: f64,
}

/// Limits of a signal of the system, judged in the run: of the platform's pose as `kinematics` publishes it.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct PoseLimit {
    pub signal: String,
    pub min: f64,
    pub max: f64,
}

impl Limits {
    /// Smallest and largest angle [rad].
    pub fn position(&self) -> (f64, f64) {
        (self.position_min, self.position_max)
    }
}

impl PoseLimit {
    pub fn allows(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value)
    }
}

fn torque_step() -> f64 {
    2.0
}

fn measured_torque() -> f64 {
    1.0
}

fn feedback_torque() -> f64 {
    0.6
}
