//! Encoder counts of drives without power, by SDO in PRE-OP.

use std::time::Duration;

use super::error::{BusError, DriveError};
use super::identity::{self, DeviceInfo};
use super::objects::Site;
use super::operational::FIRST_ADDRESS;
use super::options::BringUpOptions;
use super::sdo;
use super::setup::{find, master};
use crate::config::{Config, Kind, Role, AXES};
use crate::realtime::now_ns;
use crate::wire::Link;

const TIMEOUT_NS: u64 = 60_000_000_000;

/// What the drive of an axis says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Encoder {
    pub serial: u32,
    /// Counts at every reading; those of all axes take turns.
    pub counts: Vec<i32>,
}

/// Reads every encoder so many times. Identity and encoder scale are compared before; nothing is enabled.
pub fn positions<L: Link>(
    config: &Config,
    link: L,
    readings: usize,
    on_devices: &mut dyn FnMut(&[DeviceInfo]),
) -> Result<[Encoder; AXES], BusError> {
    let cycle = Duration::from_millis(1);
    let options = BringUpOptions {
        cycle,
        lockstep: true,
        reset_faults: true,
        replayed: false,
        cyclic: false,
    };
    let (mut wire, main) = master(config, link, options)?;
    let entries = config.profile.tx.iter().flat_map(|pdo| &pdo.entries);
    let entry = entries.clone().find(|entry| entry.role == Role::Position);
    let entry = entry.ok_or(BusError::NoPosition)?;
    let kind = match entry.bits {
        8 => Kind::I8,
        16 => Kind::I16,
        _ => Kind::I32,
    };
    let work = async {
        let groups = find(config, main).await?;
        let devices = identity::scan(&groups, main).await;
        on_devices(&devices);
        identity::compare(config, &devices)?;
        identity::refuse_energised(config, &devices, true)?;
        let site = Site { config, group: &groups.drives, main, cycle, synced: false };
        site.compare_values().await?;
        let mut encoders: [Encoder; AXES] = Default::default();
        for _ in 0..readings {
            for device in groups.drives.iter(main) {
                let position = device.configured_address() - FIRST_ADDRESS;
                let axis = config.drive.iter().position(|drive| drive.position == position);
                let Some(axis) = axis else { continue };
                let failed = |why: DriveError| BusError::Drive((axis, position, why));
                let read = sdo::read_integer(&device, (entry.object, entry.sub), kind).await;
                let counts = read.map_err(|why| failed(why.into()))?;
                let counts = counts.ok_or_else(|| failed(DriveError::NoObject(entry.object)))?;
                encoders[axis].serial = device.identity().serial;
                encoders[axis].counts.push(counts as i32);
            }
        }
        Ok(encoders)
    };
    let done = wire.drive(work, now_ns() + TIMEOUT_NS);
    done.unwrap_or(Err(BusError::Silent))
}
