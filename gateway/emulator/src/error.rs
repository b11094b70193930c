//! Errors of the emulator: one text with what, where and how to mend it.
use std::fmt;

#[derive(Debug, Clone, PartialEq)]
pub struct Error(String);

impl Error {
    pub fn new(text: impl Into<String>) -> Error {
        Error(text.into())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

impl From<flexhex_system::Error> for Error {
    fn from(error: flexhex_system::Error) -> Error {
        Error(error.to_string())
    }
}
