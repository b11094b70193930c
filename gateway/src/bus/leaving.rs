//! From OP to INIT, with what the devices say on the way.

use ethercrab::{Command, MainDevice};

use super::al;
use super::clocks::Clocks;
use super::exchange::{with_group, Bus, Running};
use super::links::Links;
use crate::config::AXES;
use crate::realtime::now_ns;
use crate::wire::{Counts, Link, Wire};

const ERROR_CODE: u16 = 0x603f;
const STATUSWORD: u16 = 0x6041;
/// Longest wait for each reply while the bus is shut down.
const LEAVE_TIMEOUT_NS: u64 = 100_000_000;

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
    pub links: Links,
    pub clocks: Clocks,
}

impl<L: Link> Bus<L> {
    /// Request SAFE-OP, PRE-OP and INIT of all devices, so that no watchdog expires. Returns the
    /// frame counts, what `ask` asks, the statusword of every drive that is not known to be disabled, and what the
    /// controllers counted since `bring_up`.
    pub fn leave(mut self, ask: Ask, disabled: &[bool; AXES]) -> Left {
        let al_code = ask.al_code.and_then(|axis| self.al_status_code(axis));
        // a device in PRE-OP would take a request of SAFE-OP for a step up
        if self.axes.iter().all(Option::is_some) {
            self.request(al::SAFE_OP);
        }
        self.request(al::PRE_OP);
        let error_code = ask.error_code.and_then(|axis| self.read_word(axis, ERROR_CODE));
        let mut statusword = [None; AXES];
        for axis in (0..AXES).filter(|axis| !disabled[*axis]) {
            statusword[axis] = self.read_word(axis, STATUSWORD);
        }
        // as they were in OP: nothing sets them to 0 on the way
        let errors = self.read_links(LEAVE_TIMEOUT_NS, |_| ());
        let links = Links::between(&self.links, &errors, &self.axes);
        if links.known {
            self.clocks.end = self.read_clocks(LEAVE_TIMEOUT_NS, |_| ());
        }
        self.request(al::INIT);
        let (counts, clocks) = (self.wire.counts, self.clocks);
        Left { counts, error_code, al_code, statusword, links, clocks }
    }

    fn read_word(&mut self, axis: usize, object: u16) -> Option<u16> {
        let place = self.order[axis];
        with_group!(&self.group, group => {
            let device = group.subdevice(self.main, place).ok()?;
            let read = device.sdo_read::<u16>(object, 0);
            self.wire.drive(read, now_ns() + LEAVE_TIMEOUT_NS)?.ok()
        })
    }

    fn request(&mut self, state: u8) {
        request(&mut self.wire, self.main, state);
    }
}

/// All devices to INIT from a bring-up that is not over: OP may be requested already.
pub(super) fn to_init<L: Link>(wire: &mut Wire<L>, main: &'static MainDevice<'static>) {
    request(wire, main, al::INIT);
}

fn request<L: Link>(wire: &mut Wire<L>, main: &'static MainDevice<'static>, state: u8) {
    let command = Command::bwr(al::CONTROL).ignore_wkc();
    // no reply: the devices may be gone already
    let _ = wire.drive(command.send(main, u16::from(state)), now_ns() + LEAVE_TIMEOUT_NS);
}
