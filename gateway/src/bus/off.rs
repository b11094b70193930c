//! Takes every drive on the bus out of operation, whatever its state.

use ethercrab::{Command, MainDevice};
use std::fmt;
use std::time::Duration;

use super::cia402::{self, State};
use super::error::BusError;
use super::identity::{self, DeviceInfo};
use super::options::BringUpOptions;
use super::setup::{find_any, master};
use super::{al, sdo};
use crate::config::Config;
use crate::exit::{Ends, Exit};
use crate::realtime::{now_ns, sleep_until};
use crate::wire::Link;

const CONTROLWORD: u16 = 0x6040;
const STATUSWORD: u16 = 0x6041;
const REPLY_NS: u64 = 100_000_000;
const POLL_NS: u64 = 5_000_000;
const TIMEOUT_NS: u64 = 60_000_000_000;

/// Why it is not known that no drive has power.
#[derive(Debug)]
pub enum OffError {
    NoReply,
    /// A device stays above this AL state.
    Above(u8),
    /// The drives stopped replying on the way.
    Silent,
    /// Positions of drives that do not obey controlword 0.
    Energised(Vec<usize>),
    /// Positions of devices that did not say whether they are.
    Unread(Vec<usize>),
    /// The devices could not be initialised.
    Bus(BusError),
}

impl fmt::Display for OffError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            OffError::NoReply => {
                f.write_str("no device replies: check the cable and that the drives are on")
            }
            OffError::Above(state) => write!(
                f,
                "a drive does not leave its state for {}: press the emergency stop",
                al::name(*state)
            ),
            OffError::Silent => f.write_str(
                "the drives stopped replying: press the emergency stop, check the cable",
            ),
            OffError::Energised(positions) => {
                let named = named(positions);
                write!(
                    f,
                    "still energised: {named}: press the emergency stop; a drive does not obey controlword 0"
                )
            }
            OffError::Unread(positions) => write!(
                f,
                "not known to be without power: {}: no answer to a read of 0x6041: press the emergency stop",
                named(positions)
            ),
            OffError::Bus(why) => why.fmt(f),
        }
    }
}

fn named(positions: &[usize]) -> String {
    let named: Vec<_> = positions.iter().map(|p| format!("position {p}")).collect();
    named.join(", ")
}

impl Ends for OffError {
    fn exit(&self) -> Exit {
        Exit::Failed
    }
}

/// Take all devices out of OP, then disable each drive that is still energised. Returns what was
/// found afterwards; Err if nothing replies or a drive stays energised.
pub fn off<L: Link>(config: &Config, link: L) -> Result<Vec<DeviceInfo>, OffError> {
    let options = BringUpOptions {
        cycle: Duration::from_millis(1),
        lockstep: true,
        reset_faults: false,
        replayed: false,
        cyclic: false,
    };
    let (mut wire, main) = master(config, link, options).map_err(OffError::Bus)?;
    let until = now_ns() + u64::from(config.bus.state_timeout_ms) * 1_000_000;
    let mut before = None;
    for state in [al::SAFE_OP, al::INIT] {
        loop {
            // an error must be acknowledged, or the drive ignores the request
            let request = Command::bwr(al::CONTROL).ignore_wkc();
            let control = u16::from(state | al::ACKNOWLEDGE);
            wire.drive(request.send(main, control), now_ns() + REPLY_NS);
            let status = wire.drive(status(main), now_ns() + REPLY_NS).flatten();
            before = before.or(status);
            // the states of all devices, ORed by the bus
            if status.is_some_and(|s| s & above(state) == 0) {
                break;
            }
            if now_ns() > until {
                return Err(before.map_or(OffError::NoReply, |_| OffError::Above(state)));
            }
            sleep_until(now_ns() + POLL_NS, Duration::ZERO);
        }
    }
    let work = disable(config, main);
    let devices = wire.drive(work, now_ns() + TIMEOUT_NS).unwrap_or(Err(OffError::Silent))?;
    let request = Command::bwr(al::CONTROL).ignore_wkc();
    wire.drive(request.send(main, u16::from(al::INIT)), now_ns() + REPLY_NS);
    let those = |wanted: fn(&DeviceInfo) -> bool| -> Vec<usize> {
        devices.iter().filter(|d| wanted(d)).map(|d| d.position).collect()
    };
    let energised = those(|d| cia402::state(d.statusword).is_energised());
    let unread = those(|d| d.unread);
    match (&energised[..], &unread[..]) {
        ([], []) => Ok(devices),
        ([], _) => Err(OffError::Unread(unread)),
        _ => Err(OffError::Energised(energised)),
    }
}

/// Bits of the states above this one.
fn above(state: u8) -> u16 {
    match state {
        al::SAFE_OP => al::OP.into(),
        _ => (al::OP | al::SAFE_OP | al::PRE_OP).into(),
    }
}

async fn status(main: &'static MainDevice<'static>) -> Option<u16> {
    // without a device the frame comes back unchanged, or not at all
    let status = Command::brd(al::STATUS).ignore_wkc().receive(main).await.ok()?;
    (status != 0).then_some(status)
}

/// Controlword 0 to every energised drive until it obeys or the time for a change of state is over.
async fn disable(
    config: &Config,
    main: &'static MainDevice<'static>,
) -> Result<Vec<DeviceInfo>, OffError> {
    let groups = find_any(config, main).await.map_err(OffError::Bus)?;
    let until = now_ns() + u64::from(config.bus.state_timeout_ms) * 1_000_000;
    for device in groups.drives.iter(main).chain(groups.others.iter(main)) {
        // a device without a statusword is no drive
        while let Ok(statusword) = sdo::read::<u16>(&device, STATUSWORD, 0).await {
            let state = cia402::state(statusword);
            if !(state.is_energised() || state == State::ReadyToSwitchOn) || now_ns() > until {
                break;
            }
            // the next reading tells whether it took it
            let _ = sdo::write(&device, CONTROLWORD, 0, cia402::DISABLE_VOLTAGE).await;
        }
    }
    Ok(identity::scan(&groups, main).await)
}
