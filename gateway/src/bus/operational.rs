//! From configured drives to drives in OP, in the wanted mode and with their watchdog running.

use ethercrab::error::Error;
use ethercrab::{Command, MainDevice};
use std::time::Duration;

use super::error::{At, BusError};
use super::exchange::Bus;
use super::options::BringUpOptions;
use super::{al, watchdog, Difference};
use crate::config::{Config, AXES};
use crate::realtime::{now_ns, sleep_until, stop};
use crate::wire::Link;

/// Station address of the first device, as ethercrab assigns them.
pub const FIRST_ADDRESS: u16 = 0x1000;
/// Longest wait for a reply while the drives change to OP.
const REPLY_NS: u64 = 50_000_000;
/// Tries to ask whether a watchdog runs, and for a frame afterwards: a lost reply does not say that it does not.
const TRIES: u32 = 40;

/// Error with the AL status codes of the drives that did not reach SAFE-OP or OP.
pub async fn not_reached(
    config: &Config,
    main: &'static MainDevice<'static>,
    why: Error,
) -> BusError {
    let mut codes = Vec::new();
    for (axis, drive) in config.drive.iter().enumerate() {
        let read = Command::fprd(FIRST_ADDRESS + drive.position, al::STATUS_CODE);
        let code = read.receive::<u16>(main).await.ok().filter(|code| *code != 0);
        codes.extend(code.map(|code| (axis, drive.position, code)));
    }
    BusError::Refused(why, codes)
}

/// Send zero torque cyclically until every drive reports OP and the mode of the configuration.
pub fn reach_op<L: Link>(
    bus: &mut Bus<L>,
    config: &Config,
    options: BringUpOptions,
) -> Result<(), BusError> {
    let cycle = options.cycle.as_nanos() as u64;
    let tries = u64::from(config.bus.state_timeout_ms) * 1_000_000 / cycle;
    bus.write(&[0.0; AXES], &[0; AXES]);
    for _ in 0..tries {
        if stop::requested() {
            return Err(BusError::Stopped);
        }
        let begin = now_ns();
        let answered = exchange(bus, config, options);
        let states = bus.reply().al_state;
        let ready = answered && states.iter().all(|s| *s == al::OP);
        if ready && wrong_modes(bus, config).is_empty() {
            return running_watchdogs(bus, config, options);
        }
        if !options.lockstep {
            sleep_until(begin + cycle, Duration::ZERO);
        }
    }
    let wrong = wrong_modes(bus, config);
    let states = bus.reply().al_state;
    if states.iter().all(|s| *s == al::OP) && !wrong.is_empty() {
        return Err(BusError::Differences(wrong));
    }
    Err(not_in_op(bus, config))
}

/// One frame without torque. A lost reply is not waited for longer than the watchdogs wait.
fn exchange<L: Link>(bus: &mut Bus<L>, config: &Config, options: BringUpOptions) -> bool {
    bus.exchange(now_ns() + reply_ns(config, options.lockstep)).answered
}

fn reply_ns(config: &Config, lockstep: bool) -> u64 {
    let half = u64::from(config.bus.watchdog_ms) * 500_000;
    if lockstep {
        REPLY_NS
    } else {
        REPLY_NS.min(half)
    }
}

/// States and AL status codes of the drives that are not in OP.
fn not_in_op<L: Link>(bus: &mut Bus<L>, config: &Config) -> BusError {
    let states = bus.reply().al_state;
    let mut late = Vec::new();
    for (axis, status) in states.into_iter().enumerate().filter(|(_, s)| *s != al::OP) {
        late.push((axis, config.drive[axis].position, (status, bus.al_status_code(axis))));
    }
    BusError::Late(config.bus.state_timeout_ms, late)
}

/// Drives that show another mode of operation (0x6061) than the configured one.
fn wrong_modes<L: Link>(bus: &Bus<L>, config: &Config) -> Vec<At<Difference>> {
    let wanted = config.profile.mode;
    let shown = bus.reply().mode.into_iter().enumerate();
    let wrong = shown.filter_map(|(axis, mode)| Some((axis, mode.filter(|m| *m != wanted)?)));
    let difference = |(axis, mode): (usize, i8)| {
        let mend = "the drive does not change to profile.mode: read its warnings, and compare \
                    profile.mode with its manual";
        let d = Difference::new("mode of operation display 0x6061", mode, wanted, mend);
        (axis, config.drive[axis].position, d)
    };
    wrong.map(difference).collect()
}

/// The error counters before power, and clocks that have settled. Each question stands between two frames, as the
/// watchdogs run; where nothing replies, nothing is known and nothing refused.
pub fn read_controllers<L: Link>(
    bus: &mut Bus<L>,
    config: &Config,
    options: BringUpOptions,
) -> Result<(), BusError> {
    let cycle = options.cycle.as_nanos() as u64;
    // two tries fit between two frames
    let wait = reply_ns(config, options.lockstep && !options.replayed) / 2;
    let next = |bus: &mut Bus<L>| {
        let begin = now_ns();
        exchange(bus, config, options);
        if !options.lockstep {
            sleep_until(begin + cycle, Duration::ZERO);
        }
    };
    bus.links = bus.read_links(wait, next);
    let rounds = u64::from(config.bus.state_timeout_ms) * 1_000_000 / (cycle * AXES as u64);
    bus.settle_clocks(config, (wait, rounds), next)
}

/// The watchdog of every drive runs, as the drives themselves report it in OP.
fn running_watchdogs<L: Link>(
    bus: &mut Bus<L>,
    config: &Config,
    options: BringUpOptions,
) -> Result<(), BusError> {
    let wait = reply_ns(config, options.lockstep);
    let mut wrong = Vec::new();
    for (axis, drive) in config.drive.iter().enumerate() {
        let runs = (0..TRIES).find_map(|_| {
            // a frame between the questions, as the watchdogs run
            exchange(bus, config, options);
            let ask = watchdog::is_running(bus.main, FIRST_ADDRESS + drive.position);
            bus.wire.drive(ask, now_ns() + wait).flatten()
        });
        if runs != Some(true) {
            wrong.push((axis, drive.position, watchdog::not_running(runs)));
        }
    }
    // one that has taken the drive out of OP has stopped since, as frames were lost
    if !wrong.is_empty() {
        let heard = (0..TRIES).any(|_| exchange(bus, config, options));
        if !heard || bus.reply().al_state.iter().any(|state| *state != al::OP) {
            return Err(not_in_op(bus, config));
        }
    }
    BusError::of(wrong)
}
