//! Why no run may start from a saved estimate, or none was saved.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::path::PathBuf;

use crate::exit::{Ends, Exit};

#[derive(Debug)]
pub struct EstimateError {
    pub file: PathBuf,
    pub why: Fault,
}

#[derive(Debug)]
pub enum Fault {
    Unreadable(io::Error),
    NotWritten(io::Error),
    NoEstimate(NoEstimate),
    /// An output of a component that no run may start from.
    Unfit {
        component: String,
        output: String,
        value: f64,
        why: Unfit,
    },
}

/// Why a text is no file of an estimate.
#[derive(Debug)]
pub enum NoEstimate {
    NotJson(serde_json::Error),
    /// The format that it says it has, and the one that is read.
    Format(String, &'static str),
    Empty,
    /// The state of this component is no pairs of hexadecimal digits.
    NoDigits(String),
    /// The state of this component is not the one that was written.
    Changed(String),
}

#[derive(Debug)]
pub enum Unfit {
    NotFinite,
    Fault,
    /// Times `scale` from `first`, allowed `range`.
    Far {
        far: f64,
        scale: f64,
        first: f64,
        range: f64,
    },
}

const MEND: &str = "give the -estimate.json of an earlier run";

impl Display for EstimateError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.why)
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Fault::Unreadable(why) => write!(f, "{why}: {MEND}"),
            Fault::NotWritten(why) => write!(f, "{why}: check the folder"),
            Fault::NoEstimate(why) => write!(f, "{why}: {MEND}"),
            Fault::Unfit { component, output, value, why } => {
                write!(f, "{component}.{output} = {value}{why}: start without the saved state")
            }
        }
    }
}

impl Display for NoEstimate {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            NoEstimate::NotJson(why) => write!(f, "no estimate ({why})"),
            NoEstimate::Format(found, wanted) => write!(f, "format {found:?}, expected {wanted:?}"),
            NoEstimate::Empty => f.write_str("it holds no state"),
            NoEstimate::NoDigits(component) => {
                write!(f, "{component}: its state is no pairs of hexadecimal digits")
            }
            NoEstimate::Changed(component) => {
                write!(f, "{component}: its state is not the one that was written (state_hash)")
            }
        }
    }
}

impl Display for Unfit {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Unfit::NotFinite => f.write_str(", must be finite"),
            Unfit::Fault => f.write_str(", must be 0"),
            Unfit::Far { far, scale, first, range } => write!(
                f,
                ", {far:.3} times scale = {scale} from p0 = {first}, allowed {range} (estimate.range)"
            ),
        }
    }
}

impl Ends for EstimateError {
    fn exit(&self) -> Exit {
        match self.why {
            Fault::NotWritten(_) => Exit::Failed,
            _ => Exit::BadInput,
        }
    }
}
