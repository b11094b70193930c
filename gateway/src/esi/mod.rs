//! Reads an ESI file (EtherCAT slave information, XML of the maker): identity, process data and start-up list of a
//! drive.

mod template;
#[cfg(test)]
mod tests;
mod xml;

pub use template::{template, Roles};
pub use xml::{devices, Device};
