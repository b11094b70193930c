//! Identity of the devices on the bus, compared with the configuration.

use ethercrab::subdevice_group::PreOp;
use ethercrab::MainDevice;

use super::cia402::{self, State};
use super::difference::Difference;
use super::error::{BusError, Energised, Stranger};
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
    /// A drive of the configuration that did not say its statusword.
    pub unread: bool,
    pub error_code: u16,
    /// It has a distributed clock.
    pub clock: bool,
}

/// Identity of every device in bus order, and its CiA 402 state if it has one.
pub async fn scan(groups: &Groups, main: &'static MainDevice<'static>) -> Vec<DeviceInfo> {
    let mut devices = Vec::new();
    let drives = groups.drives.iter(main).map(|device| (device, true));
    for (device, drive) in drives.chain(groups.others.iter(main).map(|device| (device, false))) {
        let id = device.identity();
        // a device without these objects is no drive
        let statusword = device.sdo_read(STATUSWORD, 0).await;
        let error_code = device.sdo_read(ERROR_CODE, 0).await.unwrap_or(0);
        devices.push(DeviceInfo {
            position: usize::from(device.configured_address() - FIRST_ADDRESS),
            name: device.name().to_owned(),
            vendor_id: id.vendor_id,
            product_code: id.product_id,
            revision: id.revision,
            serial: id.serial,
            unread: drive && statusword.is_err(),
            statusword: statusword.unwrap_or(0),
            error_code,
            clock: device.dc_support().any(),
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

/// Station address of each drive whose clock follows that of the first device that has one.
pub fn followers(config: &Config, devices: &[DeviceInfo]) -> [Option<u16>; AXES] {
    let mut addresses = [None; AXES];
    for device in devices.iter().filter(|device| device.clock).skip(1) {
        let axis = config.drive.iter().position(|d| usize::from(d.position) == device.position);
        if let Some(axis) = axis {
            addresses[axis] = Some(FIRST_ADDRESS + device.position as u16);
        }
    }
    addresses
}

/// Err with every difference between bus and configuration.
pub fn compare(config: &Config, devices: &[DeviceInfo]) -> Result<(), BusError> {
    let mut wrong = Vec::new();
    if devices.len() < AXES {
        wrong.push(Stranger::Few(devices.len(), AXES));
    }
    let p = &config.profile;
    for (axis, drive) in config.drive.iter().enumerate() {
        let Some(f) = devices.get(usize::from(drive.position)) else {
            wrong.push(Stranger::Missing(axis, drive.position));
            continue;
        };
        let another = "another type of drive; use its configuration or change the drive";
        let firmware = "another firmware; test it, then set profile.revision";
        let swapped =
            "drives are swapped or one was replaced; follow the cable, then set drive.serial";
        for (what, actual, expected, mend) in [
            ("vendor", f.vendor_id, Some(p.vendor_id), another),
            ("product", f.product_code, Some(p.product_code), another),
            ("revision", f.revision, p.revision, firmware),
            ("serial", f.serial, drive.serial, swapped),
        ] {
            if let Some(expected) = expected.filter(|expected| *expected != actual) {
                let [actual, expected] = [actual, expected].map(|id| format!("{id:#x}"));
                let difference = Difference::new(what, actual, expected, mend);
                wrong.push(Stranger::Other((axis, drive.position, difference)));
            }
        }
    }
    match wrong.is_empty() {
        true => Ok(()),
        false => Err(BusError::Identity(wrong)),
    }
}

/// Err if a drive is energised, or has a fault that is not to be reset.
pub fn refuse_energised(
    config: &Config,
    devices: &[DeviceInfo],
    reset: bool,
) -> Result<(), BusError> {
    let one = |f: &DeviceInfo| {
        let axis = config.drive.iter().position(|d| usize::from(d.position) == f.position);
        let (position, error_code) = (f.position, f.error_code);
        Energised { position, axis, state: cia402::state(f.statusword), error_code }
    };
    let refused = |d: &Energised| match d.state {
        State::Fault => !reset && d.axis.is_some(),
        state => state.is_energised(),
    };
    let wrong: Vec<_> = devices.iter().map(one).filter(refused).collect();
    match wrong.is_empty() {
        true => Ok(()),
        false => Err(BusError::Energised(wrong)),
    }
}
