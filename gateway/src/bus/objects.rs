//! Configures the drives: mode of operation, start-up list, process data, watchdog.

use ethercrab::error::Error;
use ethercrab::subdevice_group::{PreOp, PreOpPdi};
use ethercrab::MainDevice;
use std::time::Duration;

use super::difference::Difference;
use super::error::{At, BusError, DriveError};
use super::exchange::Group;
use super::sdo::{read, write, Device, SdoError};
use super::{readback, startup, watchdog};
use crate::config::{Config, Pdo, Role};

const MODE: u16 = 0x6060;
const RX_ASSIGNED: u16 = 0x1c12;
const TX_ASSIGNED: u16 = 0x1c13;

type Found = Vec<At<Difference>>;

/// The group of drives and how it is run.
#[derive(Clone, Copy)]
pub struct Site<'a> {
    pub config: &'a Config,
    pub group: &'a Group<PreOp>,
    pub main: &'static MainDevice<'static>,
    pub cycle: Duration,
    /// SYNC0 of distributed clocks is used.
    pub synced: bool,
}

impl<'a> Site<'a> {
    /// Axis, position and device of every drive.
    fn drives(self) -> Result<Vec<At<Device<'a>>>, BusError> {
        let one = |(axis, drive): (usize, &crate::config::Drive)| {
            let device = self.group.subdevice(self.main, self.config.place_on_bus(axis));
            Ok((axis, drive.position, device.map_err(gone(axis, drive.position))?))
        };
        self.config.drive.iter().enumerate().map(one).collect()
    }

    /// Err with all values that contradict the profile, of all drives. Reads only.
    pub async fn compare_values(self) -> Result<(), BusError> {
        let mut differences = Found::new();
        for (axis, position, device) in self.drives()? {
            let here = readback::differences(self.config, &device).await;
            let here = here.map_err(failed(axis, position))?;
            differences.extend(here.into_iter().map(|d| (axis, position, d)));
        }
        BusError::of(differences)
    }

    /// Why a value is not compared, by axis and position. Reads only.
    pub async fn uncompared(self) -> Result<Vec<At<String>>, BusError> {
        let mut all = Vec::new();
        for (axis, position, device) in self.drives()? {
            let here = readback::uncompared(self.config, &device).await;
            let here = here.map_err(failed(axis, position))?;
            all.extend(here.map(|why| (axis, position, why)));
        }
        Ok(all)
    }

    /// Objects of the start-up lists that differ. Reads only.
    pub async fn compare_startup(self) -> Result<Found, BusError> {
        let mut differences = Found::new();
        for (axis, position, device) in self.drives()? {
            let list = startup::list(self.config, axis, self.cycle, self.synced);
            let here = startup::differences(&device, &list).await;
            let here = here.map_err(failed(axis, position))?;
            differences.extend(here.into_iter().map(|d| (axis, position, d)));
        }
        Ok(differences)
    }

    /// Write the start-up lists; Err with all that did not take. `store`: in the drives' memory.
    pub async fn write_startup(self, store: bool) -> Result<(), BusError> {
        let mut differences = Found::new();
        for (axis, position, device) in self.drives()? {
            let list = startup::list(self.config, axis, self.cycle, self.synced);
            let here = startup::apply(&device, &list).await;
            let here = here.map_err(failed(axis, position))?;
            differences.extend(here.into_iter().map(|d| (axis, position, d)));
        }
        BusError::of(differences)?;
        if store {
            for (axis, position, device) in self.drives()? {
                let done = startup::store(&device).await;
                done.map_err(failed(axis, position))?;
            }
        }
        Ok(())
    }

    /// Configure every drive in PRE-OP; errors name axis, position and object.
    pub async fn configure(self) -> Result<(), BusError> {
        self.compare_values().await?;
        let mut differences = Found::new();
        for (axis, position, device) in self.drives()? {
            let here = configure(self.config, &device).await;
            let here = here.map_err(failed(axis, position))?;
            let period = watchdog::set_period(&device, self.config.bus.watchdog_ms).await;
            let period = period.map_err(failed(axis, position))?;
            differences.extend(here.into_iter().chain(period).map(|d| (axis, position, d)));
        }
        BusError::of(differences)?;
        self.write_startup(false).await
    }
}

/// What went wrong with the drive of an axis.
fn failed<T: Into<DriveError>>(axis: usize, position: u16) -> impl FnOnce(T) -> BusError {
    move |why| BusError::Drive((axis, position, why.into()))
}

fn gone(axis: usize, position: u16) -> impl FnOnce(Error) -> BusError {
    move |why| BusError::Drive((axis, position, DriveError::Gone(why)))
}

/// The watchdog trigger of every drive is on. Its sync managers are configured.
pub async fn set_triggers(
    config: &Config,
    group: &Group<PreOpPdi>,
    main: &'static MainDevice<'static>,
) -> Result<(), BusError> {
    let mut differences = Found::new();
    for (axis, drive) in config.drive.iter().enumerate() {
        let position = drive.position;
        let device = group.subdevice(main, config.place_on_bus(axis));
        let device = device.map_err(gone(axis, position))?;
        let here = watchdog::set_trigger(&device).await.map_err(failed(axis, position))?;
        differences.extend(here.map(|d| (axis, position, d)));
    }
    BusError::of(differences)
}

/// Compares the process data of every drive with the bytes out and in of the configuration.
pub fn check_mapping(
    group: &Group<PreOpPdi>,
    main: &'static MainDevice<'static>,
    bytes: (usize, usize),
) -> Result<(), BusError> {
    for device in group.iter(main) {
        let mapped = (device.outputs_raw().len(), device.inputs_raw().len());
        if mapped != bytes {
            return Err(BusError::OtherSize {
                name: device.name().to_owned(),
                address: device.configured_address(),
                mapped,
                wanted: bytes,
            });
        }
    }
    Ok(())
}

/// Set mode of operation and process data of a drive.
async fn configure(config: &Config, device: &Device<'_>) -> Result<Option<Difference>, SdoError> {
    let p = &config.profile;
    write(device, MODE, 0, p.mode).await?;
    let mode: i8 = read(device, MODE, 0).await?;
    let mend = "the drive does not take profile.mode: set a torque mode that it has";
    let differs = mode != p.mode;
    map(device, RX_ASSIGNED, &p.rx).await?;
    map(device, TX_ASSIGNED, &p.tx).await?;
    Ok(differs.then(|| Difference::new("mode of operation 0x6060", mode, p.mode, mend)))
}

/// Map and assign PDOs entry by entry: not every drive supports complete access.
async fn map(device: &Device<'_>, assigned: u16, pdos: &[Pdo]) -> Result<(), SdoError> {
    write(device, assigned, 0, 0u8).await?;
    for pdo in pdos {
        write(device, pdo.index, 0, 0u8).await?;
        for (k, e) in (1u8..).zip(&pdo.entries) {
            let object = if e.role == Role::Gap { 0 } else { e.object };
            let value = u32::from(object) << 16 | u32::from(e.sub) << 8 | u32::from(e.bits);
            write(device, pdo.index, k, value).await?;
        }
        write(device, pdo.index, 0, pdo.entries.len() as u8).await?;
    }
    for (k, pdo) in (1u8..).zip(pdos) {
        write(device, assigned, k, pdo.index).await?;
    }
    write(device, assigned, 0, pdos.len() as u8).await
}
