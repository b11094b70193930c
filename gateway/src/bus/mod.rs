//! The six drives on the cable: from nothing to process data, one frame a cycle, and back.

pub mod cia402;
pub mod drives;
mod exchange;
mod identity;
mod objects;
mod setup;

pub use exchange::{Bus, Reply};
pub use identity::{compare, refuse_energised, Found};
pub use setup::{bring_up, inspect, Wish};
