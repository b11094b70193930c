//! Runs the control FMUs of a `.ssp` against six servo drives on EtherCAT.
mod bus;
mod config;
mod realtime;
mod safety;
mod wire;
fn main() {}
