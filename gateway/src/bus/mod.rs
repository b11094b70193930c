//! The six drives on the bus: bring-up, cyclic process data, shutdown.

pub mod al;
pub mod cia402;
pub mod drives;
mod exchange;
mod identity;
mod objects;
mod setup;

pub use exchange::{Bus, Reply};
pub use identity::{compare, refuse_energised, DeviceInfo};
pub use setup::{bring_up, inspect, BringUpOptions};
