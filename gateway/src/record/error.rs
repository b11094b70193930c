//! Why a run was not recorded.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::path::PathBuf;

use crate::exit::{Ends, Exit};
use crate::file_error::FileError;

#[derive(Debug)]
pub enum RecordError {
    /// Before the run: its file cannot be created.
    NotBegun(FileError),
    /// In the run, for example a disk that is full. The run went on; `kept`: the trip file.
    NotWritten {
        why: FileError,
        kept: Option<PathBuf>,
    },
    NoThread(io::Error),
    /// The thread that writes panicked.
    Died,
}

impl From<FileError> for RecordError {
    fn from(why: FileError) -> Self {
        RecordError::NotWritten { why, kept: None }
    }
}

impl Display for RecordError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            RecordError::NotBegun(why) => why.fmt(f),
            RecordError::NotWritten { why, kept } => {
                write!(f, "the recording is incomplete: {why}")?;
                let kept = kept.as_ref().map(|path| path.display());
                kept.map_or(Ok(()), |path| write!(f, "\nthe time around the trip is in {path}"))
            }
            RecordError::NoThread(why) => {
                write!(f, "no thread for the recording ({why}): raise `ulimit -u`")
            }
            RecordError::Died => f.write_str(
                "the recording is incomplete: its thread ended unexpectedly: report this as a bug",
            ),
        }
    }
}

impl Ends for RecordError {
    fn exit(&self) -> Exit {
        match self {
            RecordError::NotBegun(_) => Exit::BadInput,
            _ => Exit::Failed,
        }
    }
}
