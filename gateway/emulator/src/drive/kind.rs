//! The two types of drive as data: identity, maps, modes, limits.
use crate::coe::pdo::{Direction, Entry, Limits, Pdo};
use serde::Deserialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Kollmorgen AKD: torque mode 4, target current 0x2071 and current 0x2077 in mA.
    Akd,
    /// Any CiA 402 drive in cyclic synchronous torque mode (10), 0.1 % of the rated torque.
    Cst,
}

/// How an object may be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Writable by SDO and in outputs.
    Output,
    /// Readable by SDO and in inputs.
    Input,
    /// Readable by SDO only.
    Constant,
}

/// One object of the drive profile: index, bits, signed or not, use.
#[derive(Debug, Clone, Copy)]
pub struct Object {
    pub index: u16,
    pub bits: u8,
    pub role: Use,
}

const fn object(index: u16, bits: u8, role: Use) -> Object {
    Object { index, bits, role }
}

pub const CONTROLWORD: u16 = 0x6040;
pub const STATUSWORD: u16 = 0x6041;
pub const MODE: u16 = 0x6060;
pub const MODE_DISPLAY: u16 = 0x6061;
pub const ERROR_CODE: u16 = 0x603F;
pub const POSITION: u16 = 0x6064;
pub const POSITION_INTERNAL: u16 = 0x6063;
pub const VELOCITY: u16 = 0x606C;
pub const TARGET_TORQUE: u16 = 0x6071;
pub const RATED_CURRENT: u16 = 0x6075;
pub const RATED_TORQUE: u16 = 0x6076;
pub const TORQUE: u16 = 0x6077;
pub const SUPPORTED_MODES: u16 = 0x6502;
pub const TARGET_CURRENT: u16 = 0x2071;
pub const CURRENT: u16 = 0x2077;

const COMMON: [Object; 12] = [
    object(CONTROLWORD, 16, Use::Output),
    object(STATUSWORD, 16, Use::Input),
    object(MODE, 8, Use::Output),
    object(MODE_DISPLAY, 8, Use::Input),
    object(ERROR_CODE, 16, Use::Input),
    object(POSITION, 32, Use::Input),
    object(VELOCITY, 32, Use::Input),
    object(TARGET_TORQUE, 16, Use::Output),
    object(TORQUE, 16, Use::Input),
    object(RATED_CURRENT, 32, Use::Constant),
    object(RATED_TORQUE, 32, Use::Constant),
    object(SUPPORTED_MODES, 32, Use::Constant),
];
const AKD_ONLY: [Object; 3] = [
    object(POSITION_INTERNAL, 32, Use::Input),
    object(TARGET_CURRENT, 32, Use::Output),
    object(CURRENT, 32, Use::Input),
];

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Kind::Akd => "AKD EtherCAT Drive (CoE)",
            Kind::Cst => "CiA 402 servo drive (CST)",
        }
    }

    /// Vendor and product.
    pub fn identity(self) -> (u32, u32) {
        match self {
            Kind::Akd => (0x6A, 0x0041_4B44),
            Kind::Cst => (0x0000_0F1E, 0x0402_0010),
        }
    }

    pub fn torque_mode(self) -> i8 {
        match self {
            Kind::Akd => 4,
            Kind::Cst => 10,
        }
    }

    pub fn modes(self) -> &'static [i8] {
        match self {
            Kind::Akd => &[1, 3, 4, 6, 7, 8],
            Kind::Cst => &[8, 9, 10],
        }
    }

    /// Object 0x6502: bit m - 1 for mode m.
    pub fn supported_modes(self) -> u32 {
        self.modes().iter().fold(0, |bits, mode| bits | 1 << (mode - 1))
    }

    pub fn mailbox_bytes(self) -> u16 {
        match self {
            Kind::Akd => 512,
            Kind::Cst => 128,
        }
    }

    pub fn object(self, index: u16) -> Option<Object> {
        let own: &[Object] = if self == Kind::Akd { &AKD_ONLY } else { &[] };
        COMMON.iter().chain(own).find(|object| object.index == index).copied()
    }

    /// Maps of the outputs as at power-up.
    pub fn outputs(self) -> Direction {
        let control = Entry::new(CONTROLWORD, 16);
        let layout = vec![control, Entry::new(MODE, 8), Entry::new(0, 8)];
        match self {
            Kind::Akd => {
                let fixed = vec![Entry::new(TARGET_TORQUE, 16), control];
                Direction::new(akd_maps(0x1600, 0x1701, fixed), vec![0x1701], AKD_LIMITS)
            }
            Kind::Cst => {
                let entries = [layout, vec![Entry::new(TARGET_TORQUE, 16)]].concat();
                let pdo = Pdo { index: 0x1600, entries, fixed: false };
                Direction::new(vec![pdo], vec![0x1600], CST_LIMITS)
            }
        }
    }

    pub fn inputs(self) -> Direction {
        let status = Entry::new(STATUSWORD, 16);
        match self {
            Kind::Akd => {
                let fixed = vec![Entry::new(POSITION_INTERNAL, 32), status];
                Direction::new(akd_maps(0x1A00, 0x1B01, fixed), vec![0x1B01], AKD_LIMITS)
            }
            Kind::Cst => {
                let head = [status, Entry::new(MODE_DISPLAY, 8), Entry::new(0, 8)];
                let tail =
                    [Entry::new(POSITION, 32), Entry::new(TORQUE, 16), Entry::new(ERROR_CODE, 16)];
                let entries = [&head[..], &tail[..]].concat();
                let pdo = Pdo { index: 0x1A00, entries, fixed: false };
                Direction::new(vec![pdo], vec![0x1A00], CST_LIMITS)
            }
        }
    }
}

const AKD_LIMITS: Limits = Limits { pdo_bytes: 8, total_bytes: 32 };
const CST_LIMITS: Limits = Limits { pdo_bytes: 32, total_bytes: 64 };

/// Four free maps and a fixed one, which is the one at power-up (no target current in it).
fn akd_maps(first: u16, fixed: u16, entries: Vec<Entry>) -> Vec<Pdo> {
    let free = |k| Pdo { index: first + k, entries: Vec::new(), fixed: false };
    let fixed = Pdo { index: fixed, entries, fixed: true };
    (0..4).map(free).chain([fixed]).collect()
}
