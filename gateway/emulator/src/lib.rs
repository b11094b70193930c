//! Emulates six servo drives on EtherCAT: SubDevices on a raw socket, CiA 402 drives, and the FMU of
//! the machine that they move. Shares no code with any MainDevice.
mod application;
mod args;
mod assembly;
#[cfg(test)]
mod bench;
mod coe;
mod drive;
mod drive_options;
mod error;
mod esc;
mod event;
mod faults;
mod loopback;
mod machine;
mod options;
mod places;
mod plant;
mod replies;
mod run;
mod segment;
mod sii;
mod socket;
mod subdevice;
mod trajectory;

pub use args::{Args, EXAMPLES};
pub use error::Error;
pub use loopback::Loopback;
pub use options::Options;
pub use run::run;
