//! Every cycle on disk without holding the cycle up.
//!
//! The cycle pushes a row of numbers into a ring that was laid out before; a thread takes rows out,
//! keeps the newest for the moment before a trip, and writes them as CSV when asked to.

mod columns;
mod ring;
#[cfg(test)]
mod tests;
mod writer;

pub use columns::{time_of, Columns};
pub use ring::{ring, Sink};
pub use writer::{Plan, Writer, Written};
