//! Poses of the platform as a person writes them, and the angles that belong to them.

use flexhex_system::{Error, Inverse, Kinematics, Pose, System};
use std::f64::consts::PI;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use crate::config::{Config, AXES};
use crate::exit::{Ends, Exit};

/// The values of a pose in their order.
const NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
type Units = [(&'static str, f64); 3];
/// As in files of motions; a value without a unit has the first.
const LENGTH: Units = [("m", 1.0), ("mm", 1e-3), ("um", 1e-6)];
const ANGLE: Units = [("rad", 1.0), ("mrad", 1e-3), ("deg", PI / 180.0)];
/// Largest size of a value [m, rad]: more is a unit that was left out, and no input of `pose.fmu`.
const LARGEST: f64 = 10.0;
/// What the pose of the angles may differ by from the one that they were computed for [m, rad]: far above what the
/// kinematics leave, far below what matters.
const SAME: f64 = 1e-6;
/// Parts of the way from the neutral pose on which the last one within reach is looked for.
const PARTS: u32 = 100;

/// Why a pose of the platform has no angles.
#[derive(Clone, Debug, PartialEq)]
pub enum PlatformError {
    NotSix(usize),
    /// A value, by its place, that is no finite number with a unit.
    NoNumber(usize, String),
    /// A value, by its place, above the largest [m, rad].
    Large(usize, f64),
    Unit {
        place: usize,
        text: String,
        unit: String,
    },
    NoFmu,
    NoKinematics,
    /// Axes, from 0, whose arms do not reach it, and the last pose on the way there that all reach.
    Unreachable {
        axes: Vec<usize>,
        last: Pose,
    },
    /// The FMU is of another machine: the pose that its angles lead to.
    Other(PathBuf, Option<Pose>),
    Failed(Error),
}

impl Display for PlatformError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            PlatformError::NotSix(count) => write!(
                f,
                "{count} values: write the six x,y,z,rx,ry,rz, position and rotation vector of the platform"
            ),
            PlatformError::NoNumber(place, text) => {
                write!(f, "{} is {text:?}, no finite number", NAMES[*place])
            }
            PlatformError::Large(place, value) => {
                let [(unit, _), ..] = units(*place);
                write!(
                    f,
                    "{} is {value} {unit}, allowed -{LARGEST} to {LARGEST} {unit}: without a unit it is in {unit}",
                    NAMES[*place]
                )
            }
            PlatformError::Unit { place, text, unit } => {
                let known = units(*place).map(|(name, _)| name).join(", ");
                write!(f, "{} is {text:?}: unit {unit:?}, must be one of {known}", NAMES[*place])
            }
            PlatformError::NoFmu => f.write_str(
                "system.pose_fmu is missing: name the inverse kinematics of the machine there, for example \
                 \"../../out/fmus/pose.fmu\"",
            ),
            PlatformError::NoKinematics => f.write_str(
                "the system has no kinematics of the reference to check the pose with: give angles (--to)",
            ),
            PlatformError::Unreachable { axes, last } => {
                let axes: Vec<_> = axes.iter().map(|axis| (axis + 1).to_string()).collect();
                write!(
                    f,
                    "out of reach of axes {}; the last pose within reach on the straight way there from the \
                     neutral one is {last}: choose a pose before it",
                    axes.join(", ")
                )
            }
            PlatformError::Other(file, pose) => {
                let leads = pose.map_or("no pose".to_owned(), |pose| pose.to_string());
                write!(
                    f,
                    "the angles of {} (system.pose_fmu) lead the machine of system.ssp to {leads}: build both from \
                     one machine file",
                    file.display()
                )
            }
            PlatformError::Failed(why) => why.fmt(f),
        }
    }
}

impl Ends for PlatformError {
    fn exit(&self) -> Exit {
        match self {
            PlatformError::NotSix(_)
            | PlatformError::NoNumber(..)
            | PlatformError::Large(..)
            | PlatformError::Unit { .. }
            | PlatformError::Unreachable { .. } => Exit::Usage,
            _ => Exit::BadInput,
        }
    }
}

/// The inverse kinematics of the configuration, judged by the kinematics of the system.
pub struct Platform {
    inverse: Inverse,
    file: PathBuf,
    kinematics: Kinematics,
    neutral: Pose,
}

impl Platform {
    pub fn open(config: &Config, system: &System) -> Result<Platform, PlatformError> {
        let file = config.system.pose_fmu.clone().ok_or(PlatformError::NoFmu)?;
        let failed = PlatformError::Failed;
        let inverse = Inverse::open(&file).map_err(failed)?;
        let opened = Kinematics::of(system, &config.system.reference, "-platform");
        let mut kinematics = opened.map_err(failed)?.ok_or(PlatformError::NoKinematics)?;
        let neutral = kinematics.pose(&[0.0; AXES]).map_err(failed)?;
        let neutral = neutral.ok_or(PlatformError::NoKinematics)?;
        Ok(Platform { inverse, file, kinematics, neutral })
    }

    /// The angles of a pose.
    pub fn angles(&mut self, wanted: &Pose) -> Result<[f64; AXES], PlatformError> {
        match self.inverse.angles(wanted).map_err(PlatformError::Failed)? {
            Ok(angles) => Ok(angles),
            Err(axes) => Err(self.unreachable(wanted, axes)?),
        }
    }

    /// Whether angles within the limits lead to the pose that they were computed for.
    pub fn judge(&mut self, angles: &[f64; AXES], wanted: &Pose) -> Result<(), PlatformError> {
        let is = self.kinematics.pose(angles).map_err(PlatformError::Failed)?;
        let same = is.is_some_and(|is| is.off(wanted) <= SAME);
        same.then_some(()).ok_or_else(|| PlatformError::Other(self.file.clone(), is))
    }

    fn unreachable(
        &mut self,
        wanted: &Pose,
        axes: Vec<usize>,
    ) -> Result<PlatformError, PlatformError> {
        let mut last = self.neutral;
        for part in 1..PARTS {
            let next = self.neutral.towards(wanted, f64::from(part) / f64::from(PARTS));
            if self.inverse.angles(&next).map_err(PlatformError::Failed)?.is_err() {
                break;
            }
            last = next;
        }
        Ok(PlatformError::Unreachable { axes, last })
    }
}

/// The pose in a text: six values, each with a unit or in m and rad.
pub fn pose(text: &str) -> Result<Pose, PlatformError> {
    let texts: Vec<_> = text.split(',').map(str::trim).collect();
    let mut values = [0.0; 6];
    if texts.len() != values.len() {
        return Err(PlatformError::NotSix(texts.len()));
    }
    for (place, text) in texts.iter().enumerate() {
        values[place] = value(place, text)?;
    }
    let [x, y, z, rotation @ ..] = values;
    Ok(Pose { position: [x, y, z], rotation })
}

fn value(place: usize, text: &str) -> Result<f64, PlatformError> {
    // the longest beginning that is a number: an exponent is no unit
    let ends = (0..=text.len()).rev().filter(|end| text.is_char_boundary(*end));
    let split = ends.map(|end| text.split_at(end));
    let mut read = split.filter_map(|(number, unit)| Some((number.parse().ok()?, unit.trim())));
    let finite = read.next().filter(|(number, _): &(f64, _)| number.is_finite());
    let (number, unit) = finite.ok_or_else(|| PlatformError::NoNumber(place, text.to_owned()))?;
    let known = units(place);
    let scale = known.iter().find(|(name, _)| *name == unit || unit.is_empty());
    let (_, scale) = scale.ok_or_else(|| {
        let (text, unit) = (text.to_owned(), unit.to_owned());
        PlatformError::Unit { place, text, unit }
    })?;
    let value = number * scale;
    if value.abs() > LARGEST {
        return Err(PlatformError::Large(place, value));
    }
    Ok(value)
}

fn units(place: usize) -> Units {
    if place < 3 {
        LENGTH
    } else {
        ANGLE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_has_units_or_is_in_metres_and_radians() {
        let pose = pose("1mm, -2e3um,3.1e-1 ,10deg,-20mrad,3e-2rad").unwrap();
        assert_eq!(pose.position, [1e-3, -2e3 * 1e-6, 0.31]);
        assert_eq!(pose.rotation, [10.0 * (PI / 180.0), -20.0 * 1e-3, 0.03]);
    }

    #[test]
    fn what_is_no_pose_is_told() {
        let refusal = |text: &str| pose(text).unwrap_err().to_string();
        for (text, why) in [
            ("0,0,0.3", "3 values: write the six x,y,z,rx,ry,rz"),
            ("0,0,0.3,0,0,0,0", "7 values"),
            ("0,0,NaN,0,0,0", "z is \"NaN\", no finite number"),
            ("0,0,infmm,0,0,0", "z is \"infmm\", no finite number"),
            ("0,0,,0,0,0", "z is \"\", no finite number"),
            ("0,mm,0.3,0,0,0", "y is \"mm\", no finite number"),
            ("0,0,310,0,0,0", "z is 310 m, allowed -10 to 10 m: without a unit it is in m"),
            ("0,0,30cm,0,0,0", "z is \"30cm\": unit \"cm\", must be one of m, mm, um"),
            ("0,0,0.3,0,5mm,0", "ry is \"5mm\": unit \"mm\", must be one of rad, mrad, deg"),
            ("0,0,0.3°,0,0,0", "unit \"°\""),
        ] {
            assert!(refusal(text).contains(why), "{text}: {}", refusal(text));
        }
    }
}
