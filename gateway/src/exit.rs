//! The exit codes of every flexhex command, and what ends a command without its work.

use std::fmt::{self, Display, Formatter};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    Good = 0,
    /// The run tripped, or the drives or the interface were refused.
    Failed = 1,
    Usage = 2,
    BadInput = 3,
}

/// An error that ends a command.
pub trait Ends: Display {
    fn exit(&self) -> Exit;
}

/// Why a command ends without its work, with its exit code.
pub struct Refusal {
    pub exit: Exit,
    why: Box<dyn Display>,
}

impl<E: Ends + 'static> From<E> for Refusal {
    fn from(why: E) -> Self {
        Refusal { exit: why.exit(), why: Box::new(why) }
    }
}

impl Display for Refusal {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        self.why.fmt(f)
    }
}

impl Ends for flexhex_system::Error {
    fn exit(&self) -> Exit {
        Exit::BadInput
    }
}
