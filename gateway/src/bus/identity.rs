//! Identity of the devices on the bus, compared with the configuration.

use ethercrab::subdevice_group::PreOp;
use ethercrab::MainDevice;

use super::cia402::{self, State};
use super::exchange::Group;
use super::operational::FIRST_ADDRESS;
use crate::config::{Config, AXES};

const STATUSWORD: u16 = 0x6041;
const ERROR_CODE: u16 = 0x603f;

/// All devices: the drives of the configuration, and others, which stay in PRE-OP.
#[derive(Default)]
pub struct Groups {
    pub drives: Group<PreOp>,
    pub others: Group<PreOp>,
}

/// One device on the bus.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    pub position: usize,
    pub name: String,
    pub vendor_id: u32,
    pub product_code: u32,
    pub revision: u32,
    pub serial: u32,
    pub statusword: u16,
    pub error_code: u16,
}

/// Identity of every device in bus order, and its CiA 402 state if it has one.
pub async fn scan(groups: &Groups, main: &'static MainDevice<'static>) -> Vec<DeviceInfo> {
    let mut devices = Vec::new();
    for device in groups.drives.iter(main).chain(groups.others.iter(main)) {
        let id = device.identity();
        // a device without these objects is no drive
        let statusword = device.sdo_read(STATUSWORD, 0).await.unwrap_or(0);
        let error_code = device.sdo_read(ERROR_CODE, 0).await.unwrap_or(0);
        devices.push(DeviceInfo {
            position: usize::from(device.configured_address() - FIRST_ADDRESS),
            name: device.name().to_owned(),
            vendor_id: id.vendor_id,
            product_code: id.product_id,
            revision: id.revision,
            serial: id.serial,
            statusword,
            error_code,
        });
    }
    devices.sort_by_key(|device| device.position);
    devices
}

/// Serial number of the drive of each axis; 0 where there is none.
pub fn serials(config: &Config, devices: &[DeviceInfo]) -> [u32; AXES] {
    let at = |axis: usize| devices.get(usize::from(config.drive[axis].position));
    std::array::from_fn(|axis| at(axis).map_or(0, |device| device.serial))
}

/// Err with every difference between bus and configuration, one a line.
pub fn compare(config: &Config, devices: &[DeviceInfo]) -> Result<(), String> {
    let mut wrong = Vec::new();
    if devices.len() < AXES {
        wrong.push(format!(
            "{} devices on the bus, expected {AXES} drives: check that all are on and all cables plugged \
             in",
            devices.len()
        ));
    }
    for (axis, drive) in config.drive.iter().enumerate() {
        let Some(f) = devices.get(usize::from(drive.position)) else {
            wrong.push(format!("axis {}: no device at position {}", axis + 1, drive.position));
            continue;
        };
        let p = &config.profile;
        let mut check = |what: &str, actual: u32, expected: Option<u32>, mend: &str| {
            if expected.is_some_and(|value| value != actual) {
                wrong.push(format!(
                    "axis {}, position {}: {what} {actual:#x}, expected {:#x}: {mend}",
                    axis + 1,
                    f.position,
                    expected.unwrap_or(0)
                ));
            }
        };
        let other = "another type of drive; use its configuration or change the drive";
        check("vendor", f.vendor_id, Some(p.vendor_id), other);
        check("product", f.product_code, Some(p.product_code), other);
        check(
            "revision",
            f.revision,
            p.revision,
            "another firmware; test it, then set profile.revision",
        );
        check(
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

/// Err if a drive is energised, or has a fault that is not to be reset.
pub fn refuse_energised(
    config: &Config,
    devices: &[DeviceInfo],
    reset: bool,
) -> Result<(), String> {
    let mut wrong = Vec::new();
    for f in devices {
        let state = cia402::state(f.statusword);
        let axis = config.drive.iter().position(|d| usize::from(d.position) == f.position);
        let at = match axis {
            Some(axis) => format!("axis {}, position {}", axis + 1, f.position),
            None => format!("position {}, no drive of the configuration", f.position),
        };
        if state.is_energised() {
            wrong.push(format!(
                "{at}: already energised ({}): find out what enabled it and disable it first",
                state.name()
            ));
        }
        if state == State::Fault && !reset && axis.is_some() {
            wrong.push(format!(
                "{at}: fault {:#06x}: remove its cause, then run with --reset-faults",
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
