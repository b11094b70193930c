//! SDO abort codes [CiA 301, table 22; ETG.1000.6, table 41].
pub const TOGGLE: u32 = 0x0503_0000;
pub const COMMAND: u32 = 0x0504_0001;
pub const UNSUPPORTED_ACCESS: u32 = 0x0601_0000;
pub const READ_ONLY: u32 = 0x0601_0002;
pub const NO_OBJECT: u32 = 0x0602_0000;
pub const NOT_MAPPABLE: u32 = 0x0604_0041;
pub const PDO_TOO_LONG: u32 = 0x0604_0042;
pub const LENGTH: u32 = 0x0607_0010;
pub const TOO_LONG: u32 = 0x0607_0012;
pub const NO_SUBINDEX: u32 = 0x0609_0011;
pub const VALUE_RANGE: u32 = 0x0609_0030;
pub const DEVICE_STATE: u32 = 0x0800_0022;
