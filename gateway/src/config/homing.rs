//! Offsets of the encoders from a file of their own, with the date and the drives that they are of.

use flexhex_system::AXES;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Homing {
    /// Written by `flexhex-gateway home`; left out: `drive.offset_counts` hold.
    pub file: Option<PathBuf>,
}

/// The content of that file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Homed {
    pub date: String,
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
    pub fn parse(text: &str) -> Result<Homed, String> {
        let homed: Homed =
            toml::from_str(text).map_err(|why| format!("no homing file ({})", why.message()))?;
        match homed.axis.len() {
            AXES => Ok(homed),
            n => Err(format!("{n} axes, expected {AXES}: home the machine again")),
        }
    }
}

/// Of drives 1001 to 1006, for tests.
#[cfg(test)]
pub(super) fn homed() -> Homed {
    let axis = |k: u32| HomedAxis { serial: 1000 + k, offset_counts: -7 * k as i32 };
    Homed { date: "today".to_owned(), pose_rad: [0.1; AXES], axis: (1..=6).map(axis).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_something_else_is_refused() {
        assert_eq!(Homed::parse(&toml::to_string(&homed()).unwrap()), Ok(homed()));
        let five = Homed { axis: homed().axis[1..].to_vec(), ..homed() };
        assert!(Homed::parse(&toml::to_string(&five).unwrap()).unwrap_err().contains("5 axes"));
        assert!(Homed::parse("time,theta").unwrap_err().contains("no homing file"));
    }
}
