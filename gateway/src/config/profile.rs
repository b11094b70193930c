//! The profile of a drive: identity, mode of operation, process data, scaling.

use serde::Deserialize;

use super::startup::Sdo;

/// A type of drive: its objects in the order of the process data, and their scaling.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    pub name: String,
    pub vendor_id: u32,
    pub product_code: u32,
    /// Left out: any.
    pub revision: Option<u32>,
    /// Mode of operation: 4 torque, 10 cyclic synchronous torque.
    pub mode: i8,
    pub counts_per_revolution: f64,
    pub scale: Scale,
    pub rx: Vec<Pdo>,
    pub tx: Vec<Pdo>,
    /// Objects that are written before power and read back.
    #[serde(default)]
    pub startup: Vec<Sdo>,
    /// Objects that are not compared, although a drive may have them: 0x608F, 0x6091, 0x607E, ...
    #[serde(default)]
    pub unchecked: Vec<u16>,
}

impl Profile {
    /// Objects that the drive gets in every cycle.
    pub fn sent(&self) -> Vec<u16> {
        self.rx.iter().flat_map(|pdo| &pdo.entries).map(|entry| entry.object).collect()
    }
}

/// Physical value of one count of target and actual torque.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Scale {
    #[serde(rename = "current")]
    Current {
        #[serde(rename = "step_mA")]
        step: f64,
        #[serde(rename = "torque_constant_N_m_per_A")]
        torque_constant: f64,
    },
    #[serde(rename = "rated_torque")]
    RatedTorque {
        #[serde(rename = "step_per_mille")]
        step: f64,
        #[serde(rename = "rated_torque_N_m")]
        rated_torque: f64,
    },
}

impl Scale {
    /// Name and value [N m/A or N m] of what a drive and the configuration must agree in.
    pub fn named(&self) -> (&'static str, f64) {
        match self {
            Scale::Current { torque_constant, .. } => {
                ("torque_constant_N_m_per_A", *torque_constant)
            }
            Scale::RatedTorque { rated_torque, .. } => ("rated_torque_N_m", *rated_torque),
        }
    }

    /// Whether a measured value is nearer to that of the configuration than to one that is wrong by the square
    /// root of 2, as peak ampere are against rms ampere: their ratio is below the fourth root of 2.
    pub fn agrees(&self, measured: f64) -> bool {
        let (_, value) = self.named();
        let ratio = measured / value;
        ratio > 0.0 && ratio.max(1.0 / ratio) < 2f64.powf(0.25)
    }

    /// Torque of one count [N m]; the factors in the order of the plant FMU, for equal rounding.
    pub fn tau_step(&self) -> f64 {
        match self {
            Scale::Current { step, torque_constant } => torque_constant * (step / 1000.0),
            Scale::RatedTorque { step, rated_torque } => rated_torque * (step / 1000.0),
        }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pdo {
    pub index: u16,
    pub entries: Vec<Entry>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    pub role: Role,
    /// 0 is a gap.
    #[serde(default)]
    pub object: u16,
    #[serde(default)]
    pub sub: u8,
    pub bits: u8,
}

/// Meaning of an entry of the process data.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    Controlword,
    Mode,
    TargetTorque,
    Statusword,
    ModeDisplay,
    Position,
    ActualTorque,
    ErrorCode,
    Unused,
    Gap,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peak_and_rms_are_told_apart_and_what_motors_vary_by_is_allowed() {
        for scale in [
            Scale::Current { step: 1.0, torque_constant: 3.0 },
            Scale::RatedTorque { step: 1.0, rated_torque: 3.0 },
        ] {
            for ratio in [1.0, 0.85, 1.18] {
                assert!(scale.agrees(3.0 * ratio), "{ratio}");
            }
            for ratio in [0.5f64.sqrt(), 2f64.sqrt(), 0.84, 1.19, 0.0, -1.0, f64::NAN] {
                assert!(!scale.agrees(3.0 * ratio), "{ratio}");
            }
        }
    }
}
