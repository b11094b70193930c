//! Brings up the bus: from unknown devices to six configured drives in OP.

use ethercrab::subdevice_group::{DcConfiguration, HasDc, Op};
use ethercrab::{
    Command, DcSync, MainDevice, MainDeviceConfig, PduStorage, RetryBehaviour, Timeouts,
};
use std::cell::Cell;
use std::time::Duration;

use super::al;
use super::clocks::Clocks;
use super::difference::Difference;
use super::drives::Drives;
use super::error::{At, BusError};
use super::exchange::{Bus, Group, Reply, Running, MOST};
use super::identity::{self, DeviceInfo, Groups};
use super::leaving::{self, Ask};
use super::links::{self, Links, Readings};
use super::objects::{self, Site};
use super::operational::{not_reached, reach_op, read_controllers, FIRST_ADDRESS};
use super::options::BringUpOptions;
use crate::config::{Config, AXES};
use crate::realtime::{now_ns, stop};
use crate::wire::{Link, Wire};

const FRAMES: usize = 8;
type Storage = PduStorage<FRAMES, { PduStorage::element_size(1100) }>;

/// Longest time of the bring-up until the drives are in SAFE-OP.
const TIMEOUT_NS: u64 = 60_000_000_000;
/// A frame of the bring-up without a reply is sent again after this time.
const REPEAT: Duration = Duration::from_millis(400);
const STATIC_SYNC_FRAMES: u32 = 5000;
const SYNC_START: Duration = Duration::from_millis(50);

/// The MainDevice on a link. Its storage stays for the rest of the process, which opens one.
pub(super) fn master<L: Link>(
    config: &Config,
    link: L,
    options: BringUpOptions,
) -> Result<(Wire<L>, &'static MainDevice<'static>), BusError> {
    let storage: &'static Storage = Box::leak(Box::new(Storage::new()));
    let (tx, rx, pdu_loop) = storage.try_split().map_err(|()| BusError::InUse)?;
    let synced = options.synced(config);
    let longest_cycle = Duration::from_millis(config.bus.lockstep_timeout_ms.max(200).into());
    let timeouts = Timeouts {
        state_transition: Duration::from_millis(config.bus.state_timeout_ms.into()),
        // longer than any cycle waits: frames of a cycle are never repeated, those of the bring-up may be
        pdu: if options.lockstep && options.cyclic { longest_cycle * 2 } else { REPEAT },
        mailbox_response: Duration::from_millis(config.bus.state_timeout_ms.into()),
        // a late reply is no fault: this computer may be busy
        eeprom: Duration::from_millis(config.bus.state_timeout_ms.into()),
        mailbox_echo: Duration::from_millis(config.bus.state_timeout_ms.into()),
        ..Timeouts::default()
    };
    let settings = MainDeviceConfig {
        dc_static_sync_iterations: if synced { STATIC_SYNC_FRAMES } else { 0 },
        retry_behaviour: RetryBehaviour::Count(3),
    };
    let main = Box::leak(Box::new(MainDevice::new(pdu_loop, timeouts, settings)));
    Ok((Wire::new(link, tx, rx).in_lockstep(options.lockstep), main))
}

/// What `inspect` does with the start-up lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lists {
    Compare,
    /// Write them and store them in the drives.
    Write,
}

/// What `inspect` found, by axis and position.
pub struct Inspected {
    /// Objects of the start-up lists that differ, before they were written.
    pub differences: Vec<At<Difference>>,
    /// Why a value was not compared.
    pub uncompared: Vec<At<String>>,
}

/// Compare drives and configuration in PRE-OP; nothing is enabled.
pub fn inspect<L: Link>(
    config: &Config,
    link: L,
    options: BringUpOptions,
    lists: Lists,
    on_devices: &mut dyn FnMut(&[DeviceInfo], &Links),
) -> Result<Inspected, BusError> {
    let (mut wire, main) = master(config, link, options)?;
    let work = async {
        let groups = find(config, main).await?;
        let devices = identity::scan(&groups, main).await;
        let mut errors = Readings::new();
        for device in &devices {
            errors.push(links::ask(main, FIRST_ADDRESS + device.position as u16).await);
        }
        on_devices(&devices, &Links::since_power_up(&errors, &config.axes_on_bus(devices.len())));
        identity::compare(config, &devices)?;
        identity::refuse_energised(config, &devices, options.reset_faults)?;
        let (cycle, synced) = (options.cycle, config.bus.distributed_clocks);
        let site = Site { config, group: &groups.drives, main, cycle, synced };
        site.compare_values().await?;
        let uncompared = site.uncompared().await?;
        let differences = site.compare_startup().await?;
        if lists == Lists::Write {
            site.write_startup(true).await?;
        }
        Ok(Inspected { differences, uncompared })
    };
    let done = wire.drive(work, now_ns() + TIMEOUT_NS);
    done.unwrap_or(Err(BusError::Silent))
}

/// The drives in OP, disabled, with their watchdog set. `on_devices` gets the devices as soon as
/// they are known. Errors name drive, object and remedy.
pub fn bring_up<L: Link>(
    config: &Config,
    link: L,
    options: BringUpOptions,
    on_devices: &mut dyn FnMut(&[DeviceInfo]),
) -> Result<Bus<L>, BusError> {
    let (mut wire, main) = master(config, link, options)?;
    wire.heeds_stop = true;
    let drives = Drives::new(config);
    let (mut axes, mut followers) = (Vec::new(), [None; AXES]);
    let mut see = |devices: &[DeviceInfo]| {
        axes = config.axes_on_bus(devices.len());
        if options.synced(config) {
            followers = identity::followers(config, devices);
        }
        on_devices(devices);
    };
    let ours = Cell::new(false);
    let work = prepare(config, main, options, (drives.bytes(), &ours), &mut see);
    let silent = || if stop::requested() { BusError::Stopped } else { BusError::Silent };
    let prepared = wire.drive(work, now_ns() + TIMEOUT_NS).unwrap_or_else(|| Err(silent()));
    wire.heeds_stop = false;
    let group = match prepared {
        Ok(group) => group,
        Err(why) => {
            // what another program leads is not touched
            if ours.get() {
                leaving::to_init(&mut wire, main);
            }
            return Err(why);
        }
    };
    wire.heeds_stop = true;
    let mut order = [0; AXES];
    for (axis, place) in order.iter_mut().enumerate() {
        *place = config.place_on_bus(axis);
    }
    let clocks = Clocks { bound_ns: config.bus.clock_bound_ns(options.cycle), ..Clocks::default() };
    let (links, reply) = (Readings::new(), Reply::default());
    let mut bus = Bus { wire, main, group, drives, order, axes, links, followers, clocks, reply };
    let reached = reach_op(&mut bus, config, options);
    let reached = reached.and_then(|()| read_controllers(&mut bus, config, options));
    bus.wire.heeds_stop = false;
    let reached = if stop::requested() { Err(BusError::Stopped) } else { reached };
    match reached {
        Ok(()) => Ok(bus),
        Err(why) => {
            // back to INIT, so that no watchdog expires
            bus.leave(Ask::default(), &[true; AXES]);
            Err(why)
        }
    }
}

/// The devices in PRE-OP; refused where one is in OP.
pub(super) async fn find(
    config: &Config,
    main: &'static MainDevice<'static>,
) -> Result<Groups, BusError> {
    refuse_op(main).await?;
    find_any(config, main).await
}

/// Another program may lead a device that is in OP.
async fn refuse_op(main: &'static MainDevice<'static>) -> Result<(), BusError> {
    let status = Command::brd(al::STATUS).ignore_wkc().receive::<u16>(main).await;
    match status.map_err(BusError::NoDevice)? & u16::from(al::OP) {
        0 => Ok(()),
        _ => Err(BusError::AlreadyInOp),
    }
}

/// The devices in PRE-OP, whatever their state was.
pub(super) async fn find_any(
    config: &Config,
    main: &'static MainDevice<'static>,
) -> Result<Groups, BusError> {
    main.init::<MOST, _>(now_ns, Groups::default(), |groups, device| {
        let position = device.configured_address() - FIRST_ADDRESS;
        Ok(if config.is_drive(position) { &groups.drives } else { &groups.others })
    })
    .await
    .map_err(BusError::NotInitialised)
}

/// From unknown devices to a request of OP, with all drives configured. `ours` becomes true before their states are
/// changed.
async fn prepare(
    config: &Config,
    main: &'static MainDevice<'static>,
    options: BringUpOptions,
    (bytes, ours): ((usize, usize), &Cell<bool>),
    on_devices: &mut dyn FnMut(&[DeviceInfo]),
) -> Result<Running, BusError> {
    refuse_op(main).await?;
    ours.set(true);
    let groups = find_any(config, main).await?;
    let devices = identity::scan(&groups, main).await;
    on_devices(&devices);
    identity::compare(config, &devices)?;
    identity::refuse_energised(config, &devices, options.reset_faults)?;
    let (cycle, synced) = (options.cycle, options.synced(config));
    Site { config, group: &groups.drives, main, cycle, synced }.configure().await?;
    let mut group = groups.drives;
    let mut clocks = 0;
    for mut device in group.iter_mut(main) {
        if synced && device.dc_support().any() {
            device.set_dc_sync(DcSync::Sync0);
            clocks += 1;
        }
    }
    let group = group.into_pre_op_pdi(main).await.map_err(BusError::NotMapped)?;
    objects::check_mapping(&group, main, bytes)?;
    objects::set_triggers(config, &group, main).await?;
    if clocks > 0 {
        let plan = DcConfiguration {
            start_delay: SYNC_START,
            sync0_period: options.cycle,
            sync0_shift: Duration::from_micros(config.bus.sync0_shift_us.into()),
        };
        let group = group.configure_dc_sync(main, plan).await;
        let group = group.map_err(BusError::Clocks)?;
        let group: Result<Group<Op, HasDc>, _> = group.request_into_op(main).await;
        return match group {
            Ok(group) => Ok(Running::Synced(group)),
            Err(why) => Err(not_reached(config, main, why).await),
        };
    }
    let group: Result<Group<Op>, _> = group.request_into_op(main).await;
    match group {
        Ok(group) => Ok(Running::Plain(group)),
        Err(why) => Err(not_reached(config, main, why).await),
    }
}
