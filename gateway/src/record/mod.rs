//! Recording of every cycle without delaying it.
//!
//! The control loop pushes a row of numbers into a preallocated ring; a thread takes the rows out,
//! keeps the newest for a trip file, and writes all of them as CSV with --record.

mod columns;
mod error;
mod file;
mod provenance;
mod ring;
#[cfg(test)]
mod tests;
mod writer;

pub use columns::{time_of, Columns};
pub use file::{vacant, Plan};
pub use provenance::{now, provenance};
pub use ring::{ring, Sink};
pub use writer::{Closer, Writer, Written};
