//! Why a run was not recorded.

use std::fmt::{self, Display, Formatter};
use std::io;

use crate::exit::{Ends, Exit};
use crate::file_error::FileError;

#[derive(Debug)]
pub enum RecordError {
    /// Before the run: its file cannot be created.
    NotBegun(FileError),
    /// In the run, for example a disk that is full. The run went on.
    NotWritten(FileError),
    NoThread(io::Error),
    /// The thread that writes panicked.
    Died,
}

impl From<FileError> for RecordError {
    fn from(why: FileError) -> Self {
        RecordError::NotWritten(why)
    }
}

impl Display for RecordError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            RecordError::NotBegun(why) => why.fmt(f),
            RecordError::NotWritten(why) => write!(f, "the recording is incomplete: {why}"),
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
