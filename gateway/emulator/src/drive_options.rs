//! Options of a single drive.
use crate::drive::parameters::Parameter;
use serde::Deserialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Initial {
    Ready,
    ReadyToSwitchOn,
    Enabled,
    Fault,
}

/// Settings of one drive that differ from `[drives]`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveOptions {
    pub position: usize,
    pub vendor: Option<u32>,
    pub product: Option<u32>,
    pub revision: Option<u32>,
    pub serial: Option<u32>,
    pub alias: Option<u16>,
    pub direction: Option<i64>,
    pub offset: Option<i64>,
    /// State at power-up: ready ("switch on disabled"), ready_to_switch_on, enabled (energised
    /// already) or fault.
    pub initial: Option<Initial>,
    /// Writes to its maps are refused.
    #[serde(default)]
    pub maps_fixed: bool,
    /// Input bytes that it requires beyond its maps.
    #[serde(default)]
    pub extra_input_bytes: usize,
    pub counts_per_rev: Option<f64>,
    /// Objects that differ from the defaults.
    #[serde(default)]
    pub objects: Vec<Parameter>,
    /// Control byte of the outputs' sync manager in its EEPROM, 0x64 by default.
    pub output_control: Option<u8>,
    /// The watchdog trigger of that sync manager stays off.
    #[serde(default)]
    pub trigger_fixed: bool,
    /// Outputs do not trigger its watchdog although that bit is set.
    #[serde(default)]
    pub watchdog_dead: bool,
    /// SAFE-OP needs 0x60C2 to hold the period of SYNC0.
    #[serde(default)]
    pub period_checked: bool,
    /// It sends an emergency message before the answer to every so many-th SDO request; 0: none.
    #[serde(default)]
    pub emergencies: u32,
    /// It stays switched on when it is to be enabled.
    #[serde(default)]
    pub never_enabled: bool,
    /// It changes its state in every frame of so many.
    #[serde(default)]
    pub slow: u32,
    /// Its encoder counts against its axis.
    #[serde(default)]
    pub encoder_reversed: bool,
    /// It shows and uses this mode whatever is set.
    pub forced_mode: Option<i8>,
    /// Bytes of its controller at power-up: address, value.
    #[serde(default)]
    pub registers: Vec<(u16, u8)>,
    /// Relative error of its clock, in the place of a drawn one.
    pub drift_ppm: Option<f64>,
    /// Its clock does not follow the one of the first drive.
    #[serde(default)]
    pub clock_free: bool,
}
