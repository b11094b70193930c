//! Reads an ESI file (EtherCAT slave information, XML of the maker): identity, process data and start-up list of a
//! drive.

mod error;
mod template;
#[cfg(test)]
mod tests;
mod xml;

pub use error::EsiError;
pub use template::{template, Roles};
pub use xml::{devices, Device};
