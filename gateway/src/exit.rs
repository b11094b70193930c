//! The exit codes of every flexhex command.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    Good = 0,
    /// The run tripped, or the drives or the interface were refused.
    Failed = 1,
    Usage = 2,
    BadInput = 3,
}
