//! The mistakes of a configuration, all at once.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use crate::exit::{Ends, Exit};

/// Why a configuration cannot be used: every mistake, and the file that has it.
#[derive(Debug)]
pub struct ConfigError {
    pub file: Option<PathBuf>,
    pub mistakes: Vec<Mistake>,
}

/// One mistake, and how to mend it.
#[derive(Debug)]
pub enum Mistake {
    /// The file cannot be read, and what to do instead.
    Unreadable(io::Error, &'static str),
    /// It is not what it should be: no TOML, an unknown key, another type.
    Form(String),
    /// `--set` with this change.
    Change { change: String, why: String },
    /// A number outside its range.
    Range { key: String, value: f64, low: f64, high: f64, mend: String },
    /// A value that does not go with others, or is none of those that there are.
    Value(String),
    /// The homing file is of another drive than the one that is configured.
    OtherDrive { axis: usize, homed: u32, configured: u32 },
}

impl From<Mistake> for ConfigError {
    fn from(mistake: Mistake) -> Self {
        ConfigError { file: None, mistakes: vec![mistake] }
    }
}

impl ConfigError {
    /// The same, of this file.
    pub fn of(self, file: &Path) -> Self {
        ConfigError { file: Some(file.to_owned()), ..self }
    }
}

impl Display for ConfigError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        for (k, mistake) in self.mistakes.iter().enumerate() {
            if k > 0 {
                f.write_str("\n")?;
            }
            if let Some(file) = &self.file {
                write!(f, "{}: ", file.display())?;
            }
            mistake.fmt(f)?;
        }
        Ok(())
    }
}

impl Display for Mistake {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Mistake::Unreadable(why, mend) => write!(f, "{why}: {mend}"),
            Mistake::Form(why) | Mistake::Value(why) => f.write_str(why),
            Mistake::Change { change, why } => write!(f, "--set {change}: {why}"),
            Mistake::Range { key, value, low, high, mend } => {
                write!(f, "{key} = {value}, allowed {low} to {high}: {mend}")
            }
            Mistake::OtherDrive { axis, homed, configured } => write!(
                f,
                "axis {}: homed with the drive of serial number {homed}, drive[{axis}].serial = \
                 {configured}: home the machine again",
                axis + 1
            ),
        }
    }
}

/// Collects the mistakes, so that all are reported at once.
#[derive(Default)]
pub struct Mistakes(Vec<Mistake>);

impl Mistakes {
    pub fn add(&mut self, text: String) {
        self.0.push(Mistake::Value(text));
    }

    /// Add a mistake if a value lies outside its range.
    pub fn check_range(&mut self, key: &str, value: f64, range: RangeInclusive<f64>, mend: &str) {
        if !range.contains(&value) {
            let (low, high) = range.into_inner();
            let (key, mend) = (key.to_owned(), mend.to_owned());
            self.0.push(Mistake::Range { key, value, low, high, mend });
        }
    }

    /// Err with all mistakes, if there is any.
    pub fn into_result(self) -> Result<(), ConfigError> {
        match self.0.is_empty() {
            true => Ok(()),
            false => Err(ConfigError { file: None, mistakes: self.0 }),
        }
    }
}

impl Ends for ConfigError {
    fn exit(&self) -> Exit {
        Exit::BadInput
    }
}
