//! What the controllers of the devices are asked beside the process data: error counters, and clocks.

use ethercrab::Command;
use std::future::Future;

use super::al;
use super::clocks::{self, Differences};
use super::difference::Difference;
use super::error::BusError;
use super::exchange::Bus;
use super::links::{self, Readings};
use super::operational::FIRST_ADDRESS;
use crate::config::Config;
use crate::realtime::{now_ns, stop};
use crate::wire::Link;

/// A lost reply is no reason to know nothing.
const TRIES: usize = 2;
/// Longest wait for an AL status code: no drive has power then, or the reaction is over.
const AL_CODE_NS: u64 = 100_000_000;

impl<L: Link> Bus<L> {
    /// The answer to a question; None where nothing replies within `wait_ns` a try.
    fn answer<F: Future>(&mut self, wait_ns: u64, question: impl Fn() -> F) -> Option<F::Output> {
        (0..TRIES).find_map(|_| self.wire.drive(question(), now_ns() + wait_ns))
    }

    /// Why a device left OP, or did not reach it; it keeps the code until the error is acknowledged. None: not read.
    pub(super) fn al_status_code(&mut self, axis: usize) -> Option<u16> {
        let (main, address) = (self.main, FIRST_ADDRESS + self.position(axis)?);
        let read = || Command::fprd(address, al::STATUS_CODE).receive::<u16>(main);
        (0..TRIES).find_map(|_| self.wire.drive(read(), now_ns() + AL_CODE_NS)?.ok())
    }

    fn position(&self, axis: usize) -> Option<u16> {
        self.axes.iter().position(|at| *at == Some(axis)).map(|position| position as u16)
    }

    /// Counters of all devices; `between` is done after each of them. Where nothing replies no more is asked: the cable is
    /// cut, or a capture has no such frames.
    pub(super) fn read_links(
        &mut self,
        wait_ns: u64,
        mut between: impl FnMut(&mut Self),
    ) -> Readings {
        let mut answers = vec![None; self.axes.len()];
        for (position, place) in answers.iter_mut().enumerate() {
            let (main, address) = (self.main, FIRST_ADDRESS + position as u16);
            let Some(reply) = self.answer(wait_ns, || links::ask(main, address)) else { break };
            *place = reply;
            between(self);
        }
        answers
    }

    /// Differences of all clocks that follow another one; `between` is done after each of them. Where nothing replies no
    /// more is asked.
    pub(super) fn read_clocks(
        &mut self,
        wait_ns: u64,
        mut between: impl FnMut(&mut Self),
    ) -> Differences {
        let mut answers = Differences::default();
        for (axis, place) in answers.iter_mut().enumerate() {
            let Some(address) = self.followers[axis] else { continue };
            let main = self.main;
            let Some(reply) = self.answer(wait_ns, || clocks::ask(main, address)) else { break };
            *place = reply;
            between(self);
        }
        answers
    }

    /// Waits, by so many rounds at most, until no clock is further off than the bound; `between` sends a frame. What
    /// does not reply is not judged.
    pub(super) fn settle_clocks(
        &mut self,
        config: &Config,
        (wait_ns, rounds): (u64, u64),
        mut between: impl FnMut(&mut Self),
    ) -> Result<(), BusError> {
        let bound = self.clocks.bound_ns;
        let off = |ns: &Option<i32>| ns.filter(|ns| ns.unsigned_abs() > bound);
        for _ in 0..rounds.max(1) {
            self.clocks.start = self.read_clocks(wait_ns, &mut between);
            if self.clocks.start.iter().all(|ns| off(ns).is_none()) || stop::requested() {
                return Ok(());
            }
        }
        let wrong = self.clocks.start.iter().enumerate();
        let wrong = wrong.filter_map(|(axis, ns)| Some((axis, off(ns)?)));
        let refused = |(axis, ns): (usize, i32)| {
            let mend = "its clock does not follow that of the first device: switch the drive off and on, compare \
                        its support of distributed clocks with its manual, or raise the bound if it only \
                        needs more";
            let expected = format!("at most {bound} ns either way (bus.clock_difference_ns)");
            let what = format!("system time difference (register {:#06x})", clocks::DIFFERENCE);
            let d = Difference::new(what, format!("{ns} ns"), expected, mend);
            (axis, config.drive[axis].position, d)
        };
        BusError::of(wrong.map(refused).collect())
    }
}
