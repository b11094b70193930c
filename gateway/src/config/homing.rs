//! Offsets of the encoders from a file of their own, with the date and the drives that they are of.

use flexhex_system::AXES;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::PathBuf;

use super::hash::hash;
use super::mistakes::{Mistake, Mistakes};

/// `Homed::method` of a run against the end stops.
pub const STOPS: &str = "stops";

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
    /// Pose in which the machine was held; with "stops", in which it rested without power [rad].
    pub pose_rad: [f64; AXES],
    /// Where it rested when it was let go after a pose, `home --rest`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_rad: Option<[f64; AXES]>,
    /// Sum of all other values, against a wrong digit; left out in older files: not compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sum: Option<String>,
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
        let sum = homed.sum();
        match (homed.axis.len(), serials.len()) {
            (AXES, AXES) if homed.sum.as_ref().is_some_and(|written| *written != sum) => {
                let written = homed.sum.unwrap_or_default();
                again(format!(
                    "sum = {written}, its values give {sum}: a digit was changed after it was written"
                ))
            }
            (AXES, AXES) => Ok(homed),
            (AXES, _) => again("two axes have drives of one serial number".to_owned()),
            (n, _) => again(format!("{n} axes, expected {AXES}")),
        }
    }

    /// The same with its sum.
    pub fn summed(&self) -> Homed {
        Homed { sum: Some(self.sum()), ..self.clone() }
    }

    fn sum(&self) -> String {
        let axes = self.axis.iter().map(|a| (a.serial, a.offset_counts)).collect::<Vec<_>>();
        let mut values = format!("{:?}", (&self.date, &self.method, self.pose_rad, axes));
        // without it the sum is that of older files
        if let Some(rest) = self.rest_rad {
            values += &format!("{rest:?}");
        }
        format!("{:016x}", hash(&values))
    }

    /// Where the machine rests without power, if that is known [rad].
    pub fn rest(&self) -> Option<[f64; AXES]> {
        self.rest_rad.or((self.method == STOPS).then_some(self.pose_rad))
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
        rest_rad: None,
        sum: None,
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

    #[test]
    fn one_wrong_digit_anywhere_is_refused() {
        let text = toml::to_string(&homed().summed()).unwrap();
        assert_eq!(Homed::parse(&text).unwrap(), homed().summed());
        let mut seen = 0;
        for (place, digit) in text.char_indices().filter(|(_, c)| c.is_ascii_digit()) {
            let other = if digit == '7' { "8" } else { "7" };
            let mut wrong = text.clone();
            wrong.replace_range(place..=place, other);
            let why = Homed::parse(&wrong).unwrap_err().to_string();
            assert!(why.contains("a digit was changed") || why.contains("serial"), "{why}");
            seen += 1;
        }
        assert!(seen > 50, "offsets, serial numbers, pose and sum");
    }

    #[test]
    fn a_pose_alone_does_not_say_where_the_machine_rests() {
        assert_eq!(homed().rest(), None);
        assert_eq!(Homed { method: STOPS.to_owned(), ..homed() }.rest(), Some([0.1; AXES]));
        let let_go = Homed { rest_rad: Some([-0.3; AXES]), ..homed() };
        assert_eq!(let_go.rest(), Some([-0.3; AXES]));
        let text = toml::to_string(&let_go.summed()).unwrap();
        assert_eq!(Homed::parse(&text).unwrap(), let_go.summed());
        let wrong = text.replace("-0.3", "-0.2");
        assert!(Homed::parse(&wrong).unwrap_err().to_string().contains("a digit was changed"));
    }
}
