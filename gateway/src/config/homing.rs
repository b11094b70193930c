//! Offsets of the encoders from a file of their own, with the date and the drives that they are of.

use flexhex_system::AXES;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::PathBuf;

use super::mistakes::{Mistake, Mistakes};

/// The file, and how `home --stops` seeks the end stops.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Homing {
    /// Written by `flexhex-gateway home`; left out: `drive.offset_counts` hold.
    pub file: Option<PathBuf>,
    /// Largest torque towards a stop.
    #[serde(rename = "torque_N_m")]
    pub torque: f64,
    #[serde(rename = "speed_rad_per_s")]
    pub speed: f64,
    /// Farthest way of an axis from its rest pose to its stop.
    #[serde(rename = "within_rad")]
    pub within: f64,
    /// Angles of the stops that are sought; left out: -stroke of the system description on every axis.
    #[serde(rename = "stop_rad")]
    pub stop: Option<[f64; AXES]>,
}

impl Default for Homing {
    fn default() -> Self {
        Homing { file: None, torque: 0.6, speed: 0.05, within: 0.6, stop: None }
    }
}

impl Homing {
    pub(super) fn check(&self, most: f64, mistakes: &mut Mistakes) {
        for (key, value, low, high, mend) in [
            ("torque_N_m", self.torque, 1e-3, most, "at most landing.torque_N_m"),
            ("speed_rad_per_s", self.speed, 1e-3, 1.0, "speed towards an end stop"),
            (
                "within_rad",
                self.within,
                1e-2,
                10.0,
                "farthest way from the rest pose to an end stop",
            ),
        ] {
            mistakes.check_range(&format!("homing.{key}"), value, low..=high, mend);
        }
        let Some(stops) = self.stop else { return };
        for (k, stop) in stops.iter().enumerate() {
            let mend = "angle of the end stop of this axis; all lower ones, or all upper ones";
            let (low, high) = if stops[0] < 0.0 { (-10.0, -1e-3) } else { (1e-3, 10.0) };
            mistakes.check_range(&format!("homing.stop_rad[{k}]"), *stop, low..=high, mend);
        }
    }
}

/// The content of that file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Homed {
    pub date: String,
    /// "pose" or "stops".
    #[serde(default)]
    pub method: String,
    /// Pose in which the machine was held [rad].
    pub pose_rad: [f64; AXES],
    pub axis: Vec<HomedAxis>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HomedAxis {
    pub serial: u32,
    pub offset_counts: i32,
}

impl Homed {
    /// The content of a file.
    pub fn parse(text: &str) -> Result<Homed, Mistake> {
        let form = |why: toml::de::Error| format!("no homing file ({})", why.message());
        let homed: Homed = toml::from_str(text).map_err(|why| Mistake::Form(form(why)))?;
        let again = |why: String| Err(Mistake::Value(format!("{why}: home the machine again")));
        let serials: BTreeSet<_> = homed.axis.iter().map(|axis| axis.serial).collect();
        match (homed.axis.len(), serials.len()) {
            (AXES, AXES) => Ok(homed),
            (AXES, _) => again("two axes have drives of one serial number".to_owned()),
            (n, _) => again(format!("{n} axes, expected {AXES}")),
        }
    }
}

/// Of drives 1001 to 1006, for tests.
#[cfg(test)]
pub(super) fn homed() -> Homed {
    let axis = |k: u32| HomedAxis { serial: 1000 + k, offset_counts: -7 * k as i32 };
    let method = "pose".to_owned();
    Homed {
        date: "today".to_owned(),
        method,
        pose_rad: [0.1; AXES],
        axis: (1..=6).map(axis).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_something_else_is_refused() {
        assert_eq!(Homed::parse(&toml::to_string(&homed()).unwrap()).unwrap(), homed());
        let five = Homed { axis: homed().axis[1..].to_vec(), ..homed() };
        let why = |text: &str| Homed::parse(text).unwrap_err().to_string();
        assert!(why(&toml::to_string(&five).unwrap()).contains("5 axes"));
        let mut double = homed();
        double.axis[2].serial = double.axis[4].serial;
        assert!(why(&toml::to_string(&double).unwrap()).contains("of one serial number"));
        assert!(why("time,theta").contains("no homing file"));
    }
}
