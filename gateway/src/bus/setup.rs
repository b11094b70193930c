//! From an unknown cable to six configured drives in OP, or the reason why not.

use ethercrab::subdevice_group::{DcConfiguration, HasDc, Op, PreOp};
use ethercrab::{
    Command, DcSync, MainDevice, MainDeviceConfig, PduStorage, RegisterAddress, RetryBehaviour,
    Timeouts,
};
use std::time::Duration;

use super::drives::Drives;
use super::exchange::{Bus, Group, Reply, Running};
use super::identity::{self, Found};
use super::objects;
use crate::config::{Config, AXES};
use crate::realtime::now_ns;
use crate::wire::{Link, Wire};

const FRAMES: usize = 8;
static STORAGE: PduStorage<FRAMES, { PduStorage::element_size(1100) }> = PduStorage::new();

const PATIENCE_NS: u64 = 60_000_000_000;
const STATIC_SYNC_FRAMES: u32 = 5000;
const SYNC_START: Duration = Duration::from_millis(50);
const OP_BIT: u16 = 8;
/// Station address of the first device, as the MainDevice gives them.
const FIRST_ADDRESS: u16 = 0x1000;

/// How the drives are brought up.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    pub cycle: Duration,
    pub lockstep: bool,
    pub reset_faults: bool,
}

/// Bus master on a cable; there is one of it in a process.
fn master<L: Link>(
    config: &Config,
    link: L,
    wish: Wish,
) -> Result<(Wire<L>, &'static MainDevice<'static>), String> {
    let (tx, rx, pdu_loop) =
        STORAGE.try_split().map_err(|()| "the bus was opened twice in one process".to_owned())?;
    let synced = config.bus.distributed_clocks && !wish.lockstep;
    let timeouts = Timeouts {
        state_transition: Duration::from_millis(config.bus.state_timeout_ms.into()),
        // longer than any cycle waits: a cycle is never sent twice, configuration may be
        pdu: Duration::from_millis(u64::from(config.bus.lockstep_timeout_ms.max(50)) * 2),
        mailbox_response: Duration::from_millis(config.bus.state_timeout_ms.into()),
        // a device that answers late is no broken one, however busy this computer is
        eeprom: Duration::from_millis(config.bus.state_timeout_ms.into()),
        mailbox_echo: Duration::from_millis(config.bus.state_timeout_ms.into()),
        ..Timeouts::default()
    };
    let settings = MainDeviceConfig {
        dc_static_sync_iterations: if synced { STATIC_SYNC_FRAMES } else { 0 },
        retry_behaviour: RetryBehaviour::Count(3),
    };
    let main = Box::leak(Box::new(MainDevice::new(pdu_loop, timeouts, settings)));
    Ok((Wire::new(link, tx, rx), main))
}

/// Identity and status of what is on the cable, in its order. Nothing is energised or changed but
/// the EtherCAT state, which ends in PRE-OP.
pub fn inspect<L: Link>(config: &Config, link: L, wish: Wish) -> Result<Vec<Found>, String> {
    let (mut wire, main) = master(config, link, wish)?;
    let work = async {
        let group = find(main).await?;
        identity::look(&group, main).await
    };
    let done = wire.drive(work, now_ns() + PATIENCE_NS);
    done.unwrap_or_else(|| Err("the bus did not answer within a minute".to_owned()))
}

/// The drives in OP, disabled, with their watchdog set. Errors name drive, object and remedy.
pub fn bring_up<L: Link>(
    config: &Config,
    link: L,
    wish: Wish,
    told: &mut dyn FnMut(&[Found]),
) -> Result<Bus<L>, String> {
    let (mut wire, main) = master(config, link, wish)?;
    let drives = Drives::new(config);
    let work = prepare(config, main, wish, drives.bytes(), told);
    let group = wire
        .drive(work, now_ns() + PATIENCE_NS)
        .unwrap_or_else(|| Err("the bus did not answer within a minute".to_owned()))?;
    let mut order = [0; AXES];
    for (place, drive) in order.iter_mut().zip(&config.drive) {
        *place = usize::from(drive.position);
    }
    let mut bus = Bus { wire, main, group, drives, order, reply: Reply::default() };
    reach_op(&mut bus, config, wish)?;
    Ok(bus)
}

async fn find(main: &'static MainDevice<'static>) -> Result<Group<PreOp>, String> {
    let status: u16 = Command::brd(RegisterAddress::AlStatus.into())
        .ignore_wkc()
        .receive(main)
        .await
        .map_err(|why| {
            format!("nothing answers on the cable ({why:?}): is it plugged in, are the drives on?")
        })?;
    if status & OP_BIT != 0 {
        return Err(
            "a device is in OP already: another master runs on this cable, or one ended a moment \
             ago: end it, wait for the watchdog, try again"
                .to_owned(),
        );
    }
    main.init_single_group(now_ns)
        .await
        .map_err(|why| format!("the devices cannot be initialised: {why:?}"))
}

async fn prepare(
    config: &Config,
    main: &'static MainDevice<'static>,
    wish: Wish,
    bytes: (usize, usize),
    told: &mut dyn FnMut(&[Found]),
) -> Result<Running, String> {
    let mut group = find(main).await?;
    let found = identity::look(&group, main).await?;
    told(&found);
    identity::compare(config, &found)?;
    identity::refuse_energised(config, &found, wish.reset_faults)?;
    for drive in &config.drive {
        let device = group
            .subdevice(main, usize::from(drive.position))
            .map_err(|why| format!("drive at position {}: {why:?}", drive.position))?;
        objects::configure(config, &device)
            .await
            .map_err(|why| format!("drive at position {}: {why}", drive.position))?;
    }
    let synced = config.bus.distributed_clocks && !wish.lockstep;
    let mut clocks = 0;
    for mut device in group.iter_mut(main) {
        if synced && device.dc_support().any() {
            device.set_dc_sync(DcSync::Sync0);
            clocks += 1;
        }
    }
    let group = group
        .into_pre_op_pdi(main)
        .await
        .map_err(|why| format!("process data cannot be mapped: {why:?}"))?;
    for device in group.iter(main) {
        let real = (device.outputs_raw().len(), device.inputs_raw().len());
        if real != bytes {
            return Err(format!(
                "{} at address {:#06x} maps {} bytes out and {} in, the configuration wants {} and {}: \
                 compare profile.rx and profile.tx with its objects 0x1C12 and 0x1C13",
                device.name(), device.configured_address(), real.0, real.1, bytes.0, bytes.1
            ));
        }
    }
    if clocks > 0 {
        let plan = DcConfiguration {
            start_delay: SYNC_START,
            sync0_period: wish.cycle,
            sync0_shift: Duration::from_micros(config.bus.sync0_shift_us.into()),
        };
        let group = group.configure_dc_sync(main, plan).await;
        let group = group.map_err(|why| format!("distributed clocks: {why:?}"))?;
        let group: Result<Group<Op, HasDc>, _> = group.request_into_op(main).await;
        return match group {
            Ok(group) => Ok(Running::Synced(group)),
            Err(why) => Err(stuck(main, &why).await),
        };
    }
    let group: Result<Group<Op>, _> = group.request_into_op(main).await;
    match group {
        Ok(group) => Ok(Running::Plain(group)),
        Err(why) => Err(stuck(main, &why).await),
    }
}

/// What the drives say when they do not follow into SAFE-OP or OP.
async fn stuck(main: &'static MainDevice<'static>, why: &ethercrab::error::Error) -> String {
    let mut said = format!("the drives do not reach SAFE-OP or OP ({why:?})");
    for position in 0..AXES as u16 {
        let register = u16::from(RegisterAddress::AlStatusCode);
        let asked = Command::fprd(FIRST_ADDRESS + position, register);
        match asked.ignore_wkc().receive::<u16>(main).await {
            Ok(0) | Err(_) => {}
            Ok(code) => said += &format!("\nposition {position}: AL status code {code:#06x}"),
        }
    }
    said
}

/// Cycle zero torque until every drive says OP.
fn reach_op<L: Link>(bus: &mut Bus<L>, config: &Config, wish: Wish) -> Result<(), String> {
    let cycle = wish.cycle.as_nanos() as u64;
    let tries = u64::from(config.bus.state_timeout_ms) * 1_000_000 / cycle;
    bus.write(&[0.0; AXES], &[0; AXES]);
    for _ in 0..tries {
        let begin = now_ns();
        let reply = bus.exchange(begin + 50_000_000);
        if reply.answered && reply.al_state.iter().all(|s| *s == 8) {
            return Ok(());
        }
        if !wish.lockstep {
            crate::realtime::sleep_until(begin + cycle, Duration::ZERO);
        }
    }
    let states = bus.reply().al_state;
    Err(format!(
        "not every drive reached OP within {} ms: AL states {states:?} (8 is OP)",
        config.bus.state_timeout_ms
    ))
}
