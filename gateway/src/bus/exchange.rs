//! Process data: what every drive gets, what it gave, one frame a cycle. Nothing is allocated here.

use ethercrab::subdevice_group::{HasDc, NoDc, Op};
use ethercrab::{Command, DefaultLock, MainDevice, SubDeviceGroup};

use super::drives::Drives;
use crate::config::AXES;
use crate::realtime::now_ns;
use crate::wire::{Counts, Link, Wire};

pub(super) const MOST: usize = 16;
pub(super) const IMAGE: usize = 512;
pub(super) type Group<S, D = NoDc> = SubDeviceGroup<MOST, IMAGE, DefaultLock, S, D>;

const AL_CONTROL: u16 = 0x0120;
const INIT: u16 = 1;
const PRE_OP: u16 = 2;
const ERROR_CODE: u16 = 0x603f;
const SAFE_OP: u16 = 4;
const GOODBYE_NS: u64 = 100_000_000;

pub(super) enum Running {
    Plain(Group<Op>),
    Synced(Group<Op, HasDc>),
}

/// What came back in the newest cycle; where nothing came, the values before it.
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
}

/// The drives in operation.
pub struct Bus<L: Link> {
    pub(super) wire: Wire<L>,
    pub(super) main: &'static MainDevice<'static>,
    pub(super) group: Running,
    pub(super) drives: Drives,
    /// Place on the cable of each axis.
    pub(super) order: [usize; AXES],
    pub(super) reply: Reply,
}

/// The same call on either kind of group.
macro_rules! with_group {
    ($running:expr, $group:ident => $call:expr) => {
        match $running {
            Running::Plain($group) => $call,
            Running::Synced($group) => $call,
        }
    };
}

impl<L: Link> Bus<L> {
    /// Working counter when every drive has read its outputs (2) and given its inputs (1).
    pub fn complete(&self) -> u16 {
        3 * AXES as u16
    }

    pub fn reply(&self) -> &Reply {
        &self.reply
    }

    /// What the next frame carries to each axis: torque [N m] and controlword.
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
        }
    }

    /// Take every device out of operation, each step with one frame, so that no watchdog has a say.
    /// Gives the counts, and the error code of the drive of one axis.
    pub fn leave(mut self, ask: Option<usize>) -> (Counts, Option<u16>) {
        for state in [SAFE_OP, PRE_OP] {
            self.request(state);
        }
        let place = ask.map(|axis| self.order[axis]);
        let code = place.and_then(|place| {
            with_group!(&self.group, group => {
                let device = group.subdevice(self.main, place).ok()?;
                let asked = device.sdo_read::<u16>(ERROR_CODE, 0);
                self.wire.drive(asked, now_ns() + GOODBYE_NS)?.ok()
            })
        });
        self.request(INIT);
        (self.wire.counts, code)
    }

    fn request(&mut self, state: u16) {
        let order = Command::bwr(AL_CONTROL).ignore_wkc();
        // nobody may be there any more: then there is nothing to take out
        let _ = self.wire.drive(order.send(self.main, state), now_ns() + GOODBYE_NS);
    }
}
