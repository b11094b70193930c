//! Addresses of the SubDevice controller's registers [ETG.1000.4; ET1100 data sheet, section II].
use std::ops::Range;

pub const STATION_ADDRESS: u16 = 0x0010;
pub const STATION_ALIAS: u16 = 0x0012;
pub const DL_CONTROL: u16 = 0x0100;
pub const DL_STATUS: u16 = 0x0110;
pub const AL_CONTROL: u16 = 0x0120;
pub const AL_STATUS: u16 = 0x0130;
pub const AL_STATUS_CODE: u16 = 0x0134;
/// Error counters, one byte each: of port p at INVALID_FRAMES + 2 p, RECEIVE_ERRORS + 2 p, and + p for the others.
pub const INVALID_FRAMES: u16 = 0x0300;
pub const RECEIVE_ERRORS: u16 = 0x0301;
pub const FORWARDED_ERRORS: u16 = 0x0308;
pub const LOST_LINK: u16 = 0x0310;
pub const WATCHDOG_DIVIDER: u16 = 0x0400;
pub const WATCHDOG_PDI: u16 = 0x0410;
pub const WATCHDOG_PROCESS: u16 = 0x0420;
pub const WATCHDOG_STATUS: u16 = 0x0440;
pub const WATCHDOG_COUNTER: u16 = 0x0442;
pub const EEPROM_CONTROL: u16 = 0x0502;
pub const FMMU: u16 = 0x0600;
pub const FMMUS: usize = 8;
pub const SM: u16 = 0x0800;
pub const SMS: usize = 8;
pub const RECEIVE_TIME: u16 = 0x0900;
pub const SYSTEM_TIME: u16 = 0x0910;
pub const RECEIVE_TIME_ECAT: u16 = 0x0918;
pub const TIME_OFFSET: u16 = 0x0920;
pub const TIME_DELAY: u16 = 0x0928;
pub const TIME_DIFFERENCE: u16 = 0x092C;
pub const SPEED_START: u16 = 0x0930;
pub const FILTER_DEPTHS: u16 = 0x0934;
pub const SYNC_ACTIVATION: u16 = 0x0981;
pub const SYNC0_START: u16 = 0x0990;
pub const SYNC0_CYCLE: u16 = 0x09A0;
pub const RAM: Range<u16> = 0x1000..0x3000;

/// What the MainDevice may write among the registers; everything else is read only.
const WRITABLE: [Range<u16>; 17] = [
    0x0010..0x0012,
    0x0100..0x0104,
    0x0120..0x0122,
    0x0200..0x0202,
    0x0300..0x0314,
    0x0400..0x0402,
    0x0410..0x0412,
    0x0420..0x0422,
    0x0442..0x0444,
    0x0500..0x0510,
    0x0600..0x0680,
    0x0800..0x0840,
    0x0900..0x0904,
    0x0910..0x0918,
    0x0920..0x092C,
    0x0930..0x0936,
    0x0980..0x09AA,
];

pub fn writable(address: u16) -> bool {
    if (SM..SM + 8 * SMS as u16).contains(&address) {
        // status and the application's control byte belong to the SubDevice
        return !matches!(address % 8, 5 | 7);
    }
    RAM.contains(&address) || WRITABLE.iter().any(|range| range.contains(&address))
}

/// ET1100-like: 8 FMMUs, 8 SMs, 8 kB, two MII ports, 64-bit distributed clocks, bitwise FMMUs.
pub const INFORMATION: [u8; 10] = [0x11, 0, 2, 0, 8, 8, 8, 0x0F, 0x0C, 0];
