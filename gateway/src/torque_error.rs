//! Why `calibrate torque` finds no torque constant.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use flexhex_system::Error;

use crate::exit::{Ends, Exit};
use crate::file_error::FileError;
use crate::mismatch::Mismatch;

/// Axes are counted from 0.
#[derive(Debug)]
pub enum TorqueError {
    /// `--mass` [kg].
    Mass(f64),
    /// One of `--mass` and `--against` without the other.
    Alone,
    Unreadable(FileError),
    NoRecord(PathBuf, toml::de::Error),
    /// A record of a run with this mass [kg].
    Loaded(PathBuf, f64),
    /// The two runs do not go together.
    OtherDrives,
    /// The mass adds too little torque to an axis [N m].
    Light {
        axis: usize,
        adds: f64,
        needed: f64,
    },
    /// What the mass should add to an axis, and what was measured [N m].
    Impossible {
        axis: usize,
        adds: f64,
        measured: f64,
    },
    /// What was measured is not what the configuration has.
    OtherScale {
        name: &'static str,
        mean: f64,
        scale: f64,
    },
    NoPlant(Error),
    /// The simulated plant failed.
    Plant(Error),
    Mismatch(Mismatch),
}

impl Display for TorqueError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            TorqueError::Mass(mass) => write!(f, "--mass {mass}: allowed 0 to 50 kg"),
            TorqueError::Alone => f.write_str(
                "--mass and --against belong together: first a run without both, with --write",
            ),
            TorqueError::Unreadable(why) => why.fmt(f),
            TorqueError::NoRecord(file, why) => write!(
                f,
                "{}: not written by `calibrate torque` ({}): give what the run without the mass wrote",
                file.display(),
                why.message()
            ),
            TorqueError::Loaded(file, mass) => write!(
                f,
                "{}: a run with {mass} kg, not one without: give that of the run without the mass",
                file.display()
            ),
            TorqueError::OtherDrives => f.write_str(
                "the run without the mass was made with other drives or another scale: repeat it",
            ),
            TorqueError::Light { axis, adds, needed } => write!(
                f,
                "axis {}: the mass adds only {adds:.4} N m, needed {needed}: take a larger one",
                axis + 1
            ),
            TorqueError::Impossible { axis, adds, measured } => write!(
                f,
                "axis {}: the mass should add {adds:.3} N m, measured {measured:.3} N m: sign \
                 (drive.direction), mass or machine file is wrong",
                axis + 1
            ),
            TorqueError::OtherScale { name, mean, scale } => write!(
                f,
                "{name} is {mean:.4}, the configuration has {scale}, wrong by {:.2} (peak and rms ampere differ \
                 by 1.41): set it in profile.scale, and repeat both runs",
                (mean / scale).max(scale / mean)
            ),
            TorqueError::NoPlant(why) => write!(
                f,
                "{why}: `calibrate torque` needs a plant whose payload comes from `reference`"
            ),
            TorqueError::Plant(why) => why.fmt(f),
            TorqueError::Mismatch(why) => why.fmt(f),
        }
    }
}

impl Ends for TorqueError {
    fn exit(&self) -> Exit {
        match self {
            TorqueError::Mass(_) | TorqueError::Alone | TorqueError::Loaded(..) => Exit::Usage,
            TorqueError::Unreadable(_)
            | TorqueError::NoRecord(..)
            | TorqueError::NoPlant(_)
            | TorqueError::Plant(_)
            | TorqueError::Mismatch(_) => Exit::BadInput,
            _ => Exit::Failed,
        }
    }
}
