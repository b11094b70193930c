//! The process-data watchdog of a drive: period, trigger, and whether it runs.

use ethercrab::{Command, MainDevice, SubDevice, SubDeviceRef};
use std::ops::Deref;

use super::difference::Difference;
use super::error::DriveError;

const DIVIDER: u16 = 0x0400;
const TICKS: u16 = 0x0420;
pub const STATUS: u16 = 0x0440;
const DIVIDER_100_US: u16 = 2498; // 40 ns (2498 + 2)
const SYNC_MANAGERS: u16 = 0x0800;
/// Bits of a sync manager's control byte: the watchdog trigger; operation mode and direction.
const TRIGGER: u8 = 0x40;
const KIND: u8 = 0x0f;
/// Three buffers, written by the master.
const OUTPUTS: u8 = 0x04;

/// Set the period and read both registers back.
pub async fn set_period<S>(
    device: &SubDeviceRef<'_, S>,
    watchdog_ms: u32,
) -> Result<Vec<Difference>, DriveError>
where
    S: Deref<Target = SubDevice>,
{
    let mut differences = Vec::new();
    let ticks = watchdog_ms as u16 * 10;
    for (register, value) in [(DIVIDER, DIVIDER_100_US), (TICKS, ticks)] {
        let failed = |why| DriveError::Register(register, why);
        device.register_write(register, value).await.map_err(failed)?;
        let actual: u16 = device.register_read(register).await.map_err(failed)?;
        if actual != value {
            let what = format!("watchdog register {register:#06x}");
            let mend = "the drive does not take this watchdog: raise bus.watchdog_ms, or replace \
                        the drive";
            differences.push(Difference::new(what, actual, value, mend));
        }
    }
    Ok(differences)
}

/// Set the bit by which outputs trigger the watchdog, where the EEPROM of the drive leaves it out,
/// and read it back. The sync managers are configured and the drive is in PRE-OP.
pub async fn set_trigger<S>(device: &SubDeviceRef<'_, S>) -> Result<Option<Difference>, DriveError>
where
    S: Deref<Target = SubDevice>,
{
    for index in 2..8 {
        let at = SYNC_MANAGERS + 8 * index;
        let failed = |why| DriveError::Register(at, why);
        let bytes: [u8; 8] = device.register_read(at).await.map_err(failed)?;
        let (control, active) = (bytes[4], bytes[6] & 1 == 1);
        if !active || control & KIND != OUTPUTS {
            continue;
        }
        if control & TRIGGER != 0 {
            return Ok(None);
        }
        // the control byte is writable only while the sync manager is off
        for (register, value) in [(at + 6, 0u8), (at + 4, control | TRIGGER), (at + 6, bytes[6])] {
            device.register_write(register, value).await.map_err(failed)?;
        }
        let actual: u8 = device.register_read(at + 4).await.map_err(failed)?;
        if actual & TRIGGER != 0 {
            return Ok(None);
        }
        return Ok(Some(Difference::new(
            format!("watchdog trigger (bit 6 of register {:#06x})", at + 4),
            format!("0 ({actual:#04x})"),
            format!("1 ({:#04x})", control | TRIGGER),
            "the drive would keep its last torque if this computer dies: correct its EEPROM with \
             the manufacturer's tool, or replace the drive",
        )));
    }
    Err(DriveError::NoOutputs)
}

/// Whether the watchdog of the device at this station address runs; None without a reply.
pub async fn is_running(main: &'static MainDevice<'static>, address: u16) -> Option<bool> {
    let read = Command::fprd(address, STATUS).receive::<u16>(main).await;
    read.ok().map(|status| status & 1 == 1)
}

/// The refusal for a watchdog that does not run in OP, or of which that is not known.
pub fn not_running(runs: Option<bool>) -> Difference {
    let what = format!("watchdog status (bit 0 of register {STATUS:#06x})");
    let mend =
        "the outputs of a frame do not trigger the watchdog, so the drive would keep its last \
                torque if this computer dies: correct its EEPROM, or replace the drive";
    let actual = runs.map_or("not read".to_owned(), |runs| u8::from(runs).to_string());
    Difference::new(what, actual, 1, mend)
}
