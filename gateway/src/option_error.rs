//! Options of a run that cannot be.

use std::fmt::{self, Display, Formatter};

use crate::exit::{Ends, Exit};

#[derive(Debug)]
pub enum OptionError {
    NoMode,
    Duration(f64),
    /// `--lockstep` on a hardware port.
    Lockstep(String),
    /// `--meta` with this text.
    Meta(String),
    /// `--largest` with this angle [rad].
    Largest(f64),
}

impl Display for OptionError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            OptionError::NoMode => f.write_str(
                "no mode given: --enable enables the drives (`run --dry-run` only reads them)",
            ),
            OptionError::Duration(time) => {
                write!(f, "--duration {time}: allowed above 0 and below 1e7 s")
            }
            OptionError::Lockstep(name) => write!(
                f,
                "--lockstep: {name} is a hardware port and real drives run by their own clock: leave \
                 --lockstep out"
            ),
            OptionError::Meta(text) => write!(f, "--meta {text}: write it as KEY=VALUE"),
            OptionError::Largest(angle) => {
                write!(f, "--largest {angle}: allowed above 0 and at most 1 rad")
            }
        }
    }
}

impl Ends for OptionError {
    fn exit(&self) -> Exit {
        Exit::Usage
    }
}
