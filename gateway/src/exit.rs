//! The exit codes of every flexhex command.

use std::fmt::Display;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    Good = 0,
    /// The run tripped, or the drives or the interface were refused.
    Failed = 1,
    Usage = 2,
    BadInput = 3,
}

/// Exit code and message of a command that ends without its work.
pub type Refusal = (Exit, String);

/// The drives or the interface are refused.
pub fn failed(why: impl Display) -> Refusal {
    (Exit::Failed, why.to_string())
}

/// Configuration, system or FMUs are wrong.
pub fn bad(why: impl Display) -> Refusal {
    (Exit::BadInput, why.to_string())
}
