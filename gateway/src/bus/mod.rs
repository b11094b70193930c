//! The six drives on the bus: bring-up, cyclic process data, shutdown.

pub mod al;
mod asking;
pub mod cia402;
mod clocks;
mod difference;
pub mod drives;
mod error;
mod exchange;
mod identity;
mod leaving;
mod links;
mod objects;
mod off;
mod operational;
mod options;
mod positions;
mod readback;
mod sdo;
mod setup;
mod startup;
mod watchdog;

pub use clocks::{largest, Clocks};
pub use difference::Difference;
pub use exchange::{Bus, Reply};
pub use identity::{serials, DeviceInfo};
pub use leaving::{Ask, Left};
pub use links::{Count, Links, PortErrors, KINDS};
pub use off::off;
pub use options::BringUpOptions;
pub use positions::{positions, Encoder};
pub use setup::{bring_up, inspect, Lists};
