//! Cyclic exchange of process data with the drives, one frame a cycle, without allocation.

use ethercrab::subdevice_group::{HasDc, NoDc, Op};
use ethercrab::{DefaultLock, MainDevice, SubDeviceGroup};

use super::clocks::Clocks;
use super::drives::Drives;
use super::links::Readings;
use crate::config::AXES;
use crate::wire::{Link, Wire};

pub(super) const MOST: usize = 16;
pub(super) const IMAGE: usize = 512;
pub(super) type Group<S, D = NoDc> = SubDeviceGroup<MOST, IMAGE, DefaultLock, S, D>;

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

/// The drives in operation.
pub struct Bus<L: Link> {
    pub(super) wire: Wire<L>,
    pub(super) main: &'static MainDevice<'static>,
    pub(super) group: Running,
    pub(super) drives: Drives,
    /// Place of each axis in the group of drives.
    pub(super) order: [usize; AXES],
    /// Axis of each position on the bus. Devices without one stay in PRE-OP.
    pub(super) axes: Vec<Option<usize>>,
    /// Error counters before power.
    pub(super) links: Readings,
    /// Station addresses of drives whose clock follows another one.
    pub(super) followers: [Option<u16>; AXES],
    pub(super) clocks: Clocks,
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
pub(super) use with_group;

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
}
