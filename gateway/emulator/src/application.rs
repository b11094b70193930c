//! Object dictionary and process data of a drive.
use crate::coe::abort;
use crate::coe::pdo::{Direction, Entry};
use crate::coe::sdo::Objects;
use crate::drive::kind::Use;
use crate::drive::Drive;
use crate::esc::state::State;
use crate::sii::Identity;

/// Settings of a SubDevice.
#[derive(Debug, Clone)]
pub struct DeviceSettings {
    pub identity: Identity,
    pub mailbox_bytes: u16,
    /// Writes to its PDO maps are refused.
    pub maps_fixed: bool,
    /// Input bytes that it requires beyond its maps.
    pub extra_input_bytes: usize,
    /// Control byte of the outputs' sync manager in the EEPROM; bit 6 triggers the watchdog.
    pub output_control: u8,
    /// Bit 6 of that byte cannot be set.
    pub trigger_fixed: bool,
    /// Outputs do not trigger the watchdog although that bit is set.
    pub watchdog_dead: bool,
    /// SAFE-OP needs 0x60C2 to hold the period of SYNC0.
    pub period_checked: bool,
    /// An emergency message comes before the answer to every so many-th SDO request; 0: none.
    pub emergencies: u32,
}

pub struct Application {
    pub drive: Drive,
    pub settings: DeviceSettings,
    pub outputs: Direction,
    pub inputs: Direction,
    pub state: State,
}

impl Application {
    pub fn input_bytes(&self) -> usize {
        self.inputs.bytes() + self.settings.extra_input_bytes
    }

    pub fn take(&mut self, data: &[u8]) {
        let mut rest = data;
        for entry in self.outputs.entries() {
            let Some((bytes, after)) = rest.split_at_checked(entry.bytes()) else {
                break;
            };
            self.drive.set(entry.index, bytes);
            rest = after;
        }
        self.drive.act();
    }

    pub fn give(&self) -> Vec<u8> {
        let mut data = Vec::with_capacity(32);
        for entry in self.inputs.entries() {
            let value = self.drive.value(entry.index).unwrap_or(0).to_le_bytes();
            let end = data.len() + entry.bytes();
            data.extend(&value[..entry.bytes().min(8)]);
            data.resize(end, 0);
        }
        data
    }

    fn direction(&self, index: u16) -> Option<&Direction> {
        match index {
            0x1600..=0x17FF | 0x1C12 => Some(&self.outputs),
            0x1A00..=0x1BFF | 0x1C13 => Some(&self.inputs),
            _ => None,
        }
    }
}

impl Objects for Application {
    fn upload(&self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        if let Some(direction) = self.direction(index) {
            let known = index >= 0x1C00 || direction.pdos.iter().any(|pdo| pdo.index == index);
            return if known { direction.upload(index, sub) } else { Err(abort::NO_OBJECT) };
        }
        let identity = &self.settings.identity;
        let fields = [identity.vendor, identity.product, identity.revision, identity.serial];
        match (index, sub) {
            (0x1000, 0) => Ok(0x0002_0192u32.to_le_bytes().to_vec()),
            (0x1001, 0) => Ok(vec![u8::from(self.drive.machine.error != 0)]),
            (0x1008, 0) => Ok(self.drive.setting.kind.name().as_bytes().to_vec()),
            (0x1018, 0) => Ok(vec![4]),
            (0x1018, 1..=4) => Ok(fields[usize::from(sub) - 1].to_le_bytes().to_vec()),
            (0x1C00, 0) => Ok(vec![4]),
            (0x1C00, 1..=4) => Ok(vec![sub]),
            (0x1000..=0x1FFF, _) if matches!(index, 0x1000 | 0x1001 | 0x1008 | 0x1018 | 0x1C00) => {
                Err(abort::NO_SUBINDEX)
            }
            _ => self.drive.upload(index, sub),
        }
    }

    fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        if self.direction(index).is_none() {
            self.upload(index, sub)?;
            return match index {
                0x1000..=0x1FFF if !self.drive.parameters.has(index) => Err(abort::READ_ONLY),
                _ => self.drive.download(index, sub, data),
            };
        }
        self.upload(index, 0)?;
        if self.state != State::PreOp {
            return Err(abort::DEVICE_STATE);
        }
        if self.settings.maps_fixed {
            return Err(abort::READ_ONLY);
        }
        let outputs = matches!(index, 0x1600..=0x17FF | 0x1C12);
        let kind = self.drive.setting.kind;
        let mappable = move |entry: &Entry| {
            let wanted = if outputs { Use::Output } else { Use::Input };
            let object = kind.object(entry.index);
            let fits = |bits, role| bits == entry.bits && role == wanted && entry.sub == 0;
            object.is_some_and(|object| fits(object.bits, object.role))
        };
        let direction = if outputs { &mut self.outputs } else { &mut self.inputs };
        direction.download(index, sub, data, &mappable)
    }
}
