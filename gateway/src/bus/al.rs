//! Application-layer (AL) states of EtherCAT devices [ETG.1000.6].

pub const INIT: u8 = 1;
pub const PRE_OP: u8 = 2;
pub const SAFE_OP: u8 = 4;
pub const OP: u8 = 8;
/// The bits of AL status that hold the state; bit 4 reports an error.
pub const STATE: u8 = 0x0f;
