//! Lift-off and landing of a machine that has weight.

use flexhex_system::AXES;
use serde::Deserialize;

use super::mistakes::Mistakes;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Landing {
    /// Component with the gains kp, t_i, t_d, t_f, and the weight as start values of `tau_ff`.
    pub feedback: String,
    /// Highest speed of the planned path.
    #[serde(rename = "speed_rad_per_s")]
    pub speed: f64,
    /// Limit of the rule `speed` in lift-off and landing.
    #[serde(rename = "speed_limit_rad_per_s")]
    pub speed_limit: f64,
    /// Largest following error in a lift-off.
    #[serde(rename = "following_error_rad", default = "following_error")]
    pub following_error: f64,
    /// The drives are enabled only below this speed.
    #[serde(rename = "rest_speed_rad_per_s")]
    pub rest_speed: f64,
    /// Longest time from the first enabled drive to the last.
    #[serde(default = "enable_ms")]
    pub enable_ms: u32,
    pub brake_ms: u32,
    pub hold_ms: u32,
    /// Largest torque in lift-off and landing.
    #[serde(rename = "torque_N_m")]
    pub torque: f64,
    /// Largest motion of the platform for an angle of an axis, over that in the neutral pose.
    #[serde(default = "platform_gain")]
    pub platform_gain: f64,
    /// Where the machine rests without torque. Left out: wherever it rests when it is enabled.
    #[serde(rename = "rest_rad")]
    pub rest: Option<[f64; AXES]>,
}

fn following_error() -> f64 {
    0.01
}

fn enable_ms() -> u32 {
    20
}

/// By virtual work the torque that carries a load grows with the gain, and within some 0.04 rad it goes from twice that of
/// the neutral pose to no bound at all. `tests/gateway/test_singular.py` shows a landing from there.
fn platform_gain() -> f64 {
    2.0
}

impl Landing {
    #[rustfmt::skip]
    pub(super) fn check(&self, mistakes: &mut Mistakes) {
        for (key, value, low, high, mend) in [
            ("speed_rad_per_s", self.speed, 1e-3, 10.0, "highest speed of lift-off and landing"),
            ("speed_limit_rad_per_s", self.speed_limit, self.speed, 100.0, "above speed_rad_per_s"),
            ("following_error_rad", self.following_error, 1e-6, 10.0, "largest error in a lift-off"),
            ("rest_speed_rad_per_s", self.rest_speed, 1e-4, self.speed_limit, "at most speed_limit_rad_per_s"),
            ("enable_ms", self.enable_ms.into(), 1.0, 10_000.0, "from the first enabled drive to the last"),
            ("brake_ms", self.brake_ms.into(), 1.0, 10_000.0, "time of braking before a landing"),
            ("hold_ms", self.hold_ms.into(), 0.0, 60_000.0, "time of standing still before and after a move"),
            ("platform_gain", self.platform_gain, 1.0, 1e3, "largest motion of the platform, over that at neutral"),
            ("torque_N_m", self.torque, 1e-3, 1e4, "largest torque of lift-off and landing"),
        ] {
            mistakes.check_range(&format!("landing.{key}"), value, low..=high, mend);
        }
        // what is no number would be near every pose
        for (k, rest) in self.rest.iter().flatten().enumerate() {
            let mend = "angle at which this axis rests without torque";
            mistakes.check_range(&format!("landing.rest_rad[{k}]"), *rest, -10.0..=10.0, mend);
        }
    }
}
