//! Who is on the cable, and whether that is who the configuration wants there.

use ethercrab::subdevice_group::PreOp;
use ethercrab::MainDevice;

use super::cia402::{self, State};
use super::exchange::Group;
use crate::config::{Config, AXES};

const STATUSWORD: u16 = 0x6041;
const ERROR_CODE: u16 = 0x603f;

/// One device on the cable.
#[derive(Clone, Debug)]
pub struct Found {
    pub position: usize,
    pub name: String,
    pub vendor_id: u32,
    pub product_code: u32,
    pub revision: u32,
    pub serial: u32,
    pub statusword: u16,
    pub error_code: u16,
}

/// Identity of every device, and its state where it has one.
pub async fn look(
    group: &Group<PreOp>,
    main: &'static MainDevice<'static>,
) -> Result<Vec<Found>, String> {
    let mut found = Vec::new();
    for (position, device) in group.iter(main).enumerate() {
        let id = device.identity();
        // a device without these objects is none of the drives: the comparison says so
        let statusword = device.sdo_read(STATUSWORD, 0).await.unwrap_or(0);
        let error_code = device.sdo_read(ERROR_CODE, 0).await.unwrap_or(0);
        found.push(Found {
            position,
            name: device.name().to_owned(),
            vendor_id: id.vendor_id,
            product_code: id.product_id,
            revision: id.revision,
            serial: id.serial,
            statusword,
            error_code,
        });
    }
    Ok(found)
}

/// Err with every difference between the cable and the configuration.
pub fn compare(config: &Config, found: &[Found]) -> Result<(), String> {
    let mut wrong = Vec::new();
    if found.len() != AXES {
        wrong.push(format!(
            "{} devices on the cable, wanted {AXES}: is one switched off, or a cable out?",
            found.len()
        ));
    }
    for (axis, drive) in config.drive.iter().enumerate() {
        let Some(f) = found.get(usize::from(drive.position)) else {
            wrong.push(format!("axis {}: nothing at position {}", axis + 1, drive.position));
            continue;
        };
        let p = &config.profile;
        let mut want = |what: &str, real: u32, wanted: Option<u32>, mend: &str| {
            if wanted.is_some_and(|w| w != real) {
                wrong.push(format!(
                    "axis {}, position {}: {what} {real:#x}, wanted {:#x}: {mend}",
                    axis + 1,
                    f.position,
                    wanted.unwrap_or(0)
                ));
            }
        };
        let other = "another device; choose its configuration or change the drive";
        want("vendor", f.vendor_id, Some(p.vendor_id), other);
        want("product", f.product_code, Some(p.product_code), other);
        want(
            "revision",
            f.revision,
            p.revision,
            "other firmware; try it, then set profile.revision",
        );
        want(
            "serial",
            f.serial,
            drive.serial,
            "drives are swapped or one was replaced; follow the cable, then set drive.serial",
        );
    }
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(wrong.join("\n"))
    }
}

/// Err when a drive has power already, or a fault that nobody asked to reset.
pub fn refuse_energised(config: &Config, found: &[Found], reset: bool) -> Result<(), String> {
    let mut wrong = Vec::new();
    for (axis, drive) in config.drive.iter().enumerate() {
        let f = &found[usize::from(drive.position)];
        let state = cia402::state(f.statusword);
        let at = format!("axis {}, position {}", axis + 1, f.position);
        if state.is_energised() {
            wrong.push(format!(
                "{at}: has power already ({}): disable it first; who enabled it?",
                state.words()
            ));
        }
        if state == State::Fault && !reset {
            wrong.push(format!(
                "{at}: fault {:#06x}: mend its cause, then run with --reset-faults",
                f.error_code
            ));
        }
    }
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(wrong.join("\n"))
    }
}
