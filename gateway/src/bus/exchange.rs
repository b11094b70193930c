//! Cyclic exchange of process data with the drives, one frame a cycle, without allocation.

use ethercrab::subdevice_group::{HasDc, NoDc, Op};
use ethercrab::{Command, DefaultLock, MainDevice, SubDeviceGroup};

use super::al;
use super::drives::Drives;
use crate::config::AXES;
use crate::realtime::now_ns;
use crate::wire::{Counts, Link, Wire};

pub(super) const MOST: usize = 16;
pub(super) const IMAGE: usize = 512;
pub(super) type Group<S, D = NoDc> = SubDeviceGroup<MOST, IMAGE, DefaultLock, S, D>;

const ERROR_CODE: u16 = 0x603f;
const STATUSWORD: u16 = 0x6041;
/// Longest wait for each reply while the bus is shut down.
const LEAVE_TIMEOUT_NS: u64 = 100_000_000;

pub(super) enum Running {
    Plain(Group<Op>),
    Synced(Group<Op, HasDc>),
}

/// The newest reply; without one in this cycle, the values of the last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reply {
    pub answered: bool,
    pub working_counter: u16,
    /// Phase of the frame in the drives' cycle, with distributed clocks [ns].
    pub phase_ns: Option<u64>,
    pub theta: [f64; AXES],
    pub tau: [f64; AXES],
    pub statusword: [u16; AXES],
    pub error_code: [u16; AXES],
    pub al_state: [u8; AXES],
    /// Mode of operation display, where the process data has it.
    pub mode: [Option<i8>; AXES],
}

/// Axes whose drives are asked for a cause while the bus leaves OP.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ask {
    /// Of the fault, 0x603F.
    pub error_code: Option<usize>,
    /// Of the AL state, register 0x0134.
    pub al_code: Option<usize>,
}

/// What is known after the bus has left OP.
pub struct Left {
    pub counts: Counts,
    pub error_code: Option<u16>,
    pub al_code: Option<u16>,
    /// None: known to be disabled before, or no reply.
    pub statusword: [Option<u16>; AXES],
}

/// The drives in operation.
pub struct Bus<L: Link> {
    pub(super) wire: Wire<L>,
    pub(super) main: &'static MainDevice<'static>,
    pub(super) group: Running,
    pub(super) drives: Drives,
    /// Place of each axis in the group of drives.
    pub(super) order: [usize; AXES],
    /// Other devices are on the bus; they stay in PRE-OP.
    pub(super) others: bool,
    pub(super) reply: Reply,
}

/// The same call on a group with or without distributed clocks.
macro_rules! with_group {
    ($running:expr, $group:ident => $call:expr) => {
        match $running {
            Running::Plain($group) => $call,
            Running::Synced($group) => $call,
        }
    };
}

impl<L: Link> Bus<L> {
    /// Working counter of a complete reply: each drive adds 2 for its outputs and 1 for its inputs.
    pub fn complete(&self) -> u16 {
        3 * AXES as u16
    }

    pub fn reply(&self) -> &Reply {
        &self.reply
    }

    /// Shows the angles of the newest reply as 0 from the next one on; the new offsets in counts.
    pub fn zero(&mut self) -> [i32; AXES] {
        let theta = self.reply.theta;
        std::array::from_fn(|axis| self.drives.zero(axis, theta[axis]))
    }

    /// Cycles that went by since the last call, where no clock but the emulator says so.
    pub fn stalled(&mut self) -> u64 {
        std::mem::take(&mut self.wire.stalled)
    }

    /// Torque [N m] and controlword of each axis in the next frame.
    pub fn write(&mut self, tau: &[f64; AXES], controlword: &[u16; AXES]) {
        for axis in 0..AXES {
            let place = self.order[axis];
            with_group!(&self.group, group => {
                if let Ok(device) = group.subdevice(self.main, place) {
                    let mut out = device.outputs_raw_mut();
                    self.drives.write(axis, controlword[axis], tau[axis], &mut out);
                }
            });
        }
    }

    /// Send the frame and wait for its reply until `deadline_ns` of the monotonic clock.
    pub fn exchange(&mut self, deadline_ns: u64) -> &Reply {
        let mut phase = None;
        let answer = match &self.group {
            Running::Plain(group) => self
                .wire
                .drive(group.tx_rx(self.main), deadline_ns)
                .and_then(Result::ok)
                .map(|a| (a.working_counter, a.subdevice_states)),
            Running::Synced(group) => {
                self.wire.drive(group.tx_rx_dc(self.main), deadline_ns).and_then(Result::ok).map(
                    |a| {
                        phase = Some(a.extra.cycle_start_offset.as_nanos() as u64);
                        (a.working_counter, a.subdevice_states)
                    },
                )
            }
        };
        self.reply.answered = answer.is_some();
        self.reply.phase_ns = phase;
        if let Some((counter, states)) = answer {
            self.reply.working_counter = counter;
            for axis in 0..AXES {
                let state = states.get(self.order[axis]).copied();
                self.reply.al_state[axis] = state.map_or(0, u8::from);
            }
            self.read();
        }
        &self.reply
    }

    fn read(&mut self) {
        for axis in 0..AXES {
            let place = self.order[axis];
            let report = with_group!(&self.group, group => {
                let Ok(device) = group.subdevice(self.main, place) else { continue };
                let inputs = device.inputs_raw();
                self.drives.read(axis, &inputs)
            });
            self.reply.theta[axis] = report.theta;
            self.reply.tau[axis] = report.tau;
            self.reply.statusword[axis] = report.statusword;
            self.reply.error_code[axis] = report.error_code;
            self.reply.mode[axis] = report.mode;
        }
    }

    /// Request SAFE-OP, PRE-OP and INIT of all devices, so that no watchdog expires. Returns the
    /// frame counts, what `ask` asks, and the statusword of every drive that is not known to be disabled.
    pub fn leave(mut self, ask: Ask, disabled: &[bool; AXES]) -> Left {
        let al_code = ask.al_code.and_then(|axis| self.al_status_code(axis));
        // a device in PRE-OP would take a request of SAFE-OP for a step up
        if !self.others {
            self.request(al::SAFE_OP);
        }
        self.request(al::PRE_OP);
        let error_code = ask.error_code.and_then(|axis| self.read_word(axis, ERROR_CODE));
        let mut statusword = [None; AXES];
        for axis in (0..AXES).filter(|axis| !disabled[*axis]) {
            statusword[axis] = self.read_word(axis, STATUSWORD);
        }
        self.request(al::INIT);
        Left { counts: self.wire.counts, error_code, al_code, statusword }
    }

    fn read_word(&mut self, axis: usize, object: u16) -> Option<u16> {
        let place = self.order[axis];
        with_group!(&self.group, group => {
            let device = group.subdevice(self.main, place).ok()?;
            let read = device.sdo_read::<u16>(object, 0);
            self.wire.drive(read, now_ns() + LEAVE_TIMEOUT_NS)?.ok()
        })
    }

    /// Why a drive left OP; it keeps the code until the error is acknowledged.
    fn al_status_code(&mut self, axis: usize) -> Option<u16> {
        let address = with_group!(&self.group, group => {
            group.subdevice(self.main, self.order[axis]).ok()?.configured_address()
        });
        let read = Command::fprd(address, al::STATUS_CODE).receive::<u16>(self.main);
        self.wire.drive(read, now_ns() + LEAVE_TIMEOUT_NS)?.ok().filter(|code| *code != 0)
    }

    fn request(&mut self, state: u8) {
        let command = Command::bwr(al::CONTROL).ignore_wkc();
        // no reply: the devices may be gone already
        let _ =
            self.wire.drive(command.send(self.main, u16::from(state)), now_ns() + LEAVE_TIMEOUT_NS);
    }
}
