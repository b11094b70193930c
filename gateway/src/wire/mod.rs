//! Frames on the cable: one raw socket, the frames in flight, and a loop that polls one future.
//!
//! All of it runs in the calling thread: poll the future, send the frames that it queued, pass on
//! the replies, sleep until the next one. It changes no thread and allocates nothing. Replies to no
//! frame in flight are counted and dropped.
//!
//! The index of a frame is one byte and repeats after some 32 cycles. So the last four bytes of the
//! source address, which no device changes, carry the number of the frame: a reply to an older frame
//! is never taken for the reply to the newest.
//!
//! In lockstep no clock tells that a reply will not come: the emulator says so, with a frame of its own
//! (`NO_REPLY`), and how many cycles went by before a frame, where it plays a computer that stood still
//! (`STALLED`). So a run does not depend on how fast either computer is.

mod cable;
mod clock;
mod emergency;
#[cfg(test)]
mod fuzz_tests;
mod port_error;
mod replay;
mod socket;
#[cfg(test)]
mod tests;

use ethercrab::{PduRx, PduTx};
use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use crate::realtime::{now_ns, stop};
pub use cable::Cable;
#[cfg(test)]
pub use replay::pcap;
pub use replay::Replay;
pub use socket::{Link, Socket};

const INDEX: usize = 17; // Ethernet header 14, EtherCAT header 2, command 1
const LARGEST: usize = 1600;
/// Bytes of the number; the first device sets a bit of byte 6 and changes nothing else.
const NUMBER: std::ops::Range<usize> = 8..12;
/// Type of the EtherCAT header, byte 15, bits 4 to 7, that says "no reply to the frame of this number".
const TYPE: usize = 15;
const NO_REPLY: u8 = 0xF;
/// The same, with "so many cycles went by before it" in the other bits of bytes 14 and 15.
const STALLED: u8 = 0xE;
/// The same bytes in the source address of ethercrab.
const OURS: [u8; 4] = [0x10; 4];

/// A frame that says that none comes.
fn no_reply(frame: &[u8]) -> Vec<u8> {
    let mut notice = frame[..=INDEX].to_vec();
    notice[TYPE] = NO_REPLY << 4;
    notice
}

/// Frame counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub sent: u64,
    pub answered: u64,
    /// Second copies of a reply.
    pub duplicated: u64,
    /// Replies after the time-out of their cycle.
    pub late: u64,
    /// Frames that reply to none of ours.
    pub bad: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Slot {
    Never,
    InFlight,
    Answered,
    GivenUp,
}

/// The frames of one link; `Socket` is the real link.
pub struct Wire<L: Link> {
    link: L,
    tx: PduTx<'static>,
    rx: PduRx<'static>,
    slots: [Slot; 256],
    /// Number of the newest frame with each index.
    numbers: [u32; 256],
    /// How often each was sent again.
    again: [u16; 256],
    next_number: u32,
    buffer: [u8; LARGEST],
    lockstep: bool,
    /// The emulator said that the newest frame gets no reply.
    unanswered: bool,
    /// A stop request ends the wait: nothing has power yet.
    pub heeds_stop: bool,
    /// Cycles that went by, as the emulator says, since it was last looked at.
    pub stalled: u64,
    pub counts: Counts,
}

impl<L: Link> Wire<L> {
    pub fn new(link: L, tx: PduTx<'static>, rx: PduRx<'static>) -> Self {
        Wire {
            link,
            tx,
            rx,
            slots: [Slot::Never; 256],
            numbers: [0; 256],
            again: [0; 256],
            next_number: 0,
            buffer: [0; LARGEST],
            lockstep: false,
            unanswered: false,
            heeds_stop: false,
            stalled: 0,
            counts: Counts::default(),
        }
    }

    /// Whether the other end may say that a frame gets no reply.
    pub fn in_lockstep(self, lockstep: bool) -> Self {
        Wire { lockstep, ..self }
    }

    /// The result of the future, or None if the other end says that no reply comes, on a stop request that is heeded,
    /// or if `deadline_ns` passes first; the future is then dropped.
    pub fn drive<F: Future>(&mut self, future: F, deadline_ns: u64) -> Option<F::Output> {
        let mut future = pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        self.unanswered = false;
        loop {
            if let Poll::Ready(result) = future.as_mut().poll(&mut context) {
                return Some(result);
            }
            let moved = self.send() | self.receive();
            if std::mem::take(&mut self.unanswered) || self.heeds_stop && stop::requested() {
                self.give_up();
                return None;
            }
            if moved {
                continue;
            }
            let now = now_ns();
            if now >= deadline_ns {
                self.give_up();
                return None;
            }
            self.link.wait(clock::next_wake(now).min(deadline_ns) - now);
        }
    }

    fn send(&mut self) -> bool {
        let mut moved = false;
        while let Some(frame) = self.tx.next_sendable_frame() {
            let (link, counts, copy) = (&mut self.link, &mut self.counts, &mut self.buffer);
            let number = self.next_number;
            self.next_number = number.wrapping_add(1);
            let (slots, numbers, again) = (&mut self.slots, &mut self.numbers, &mut self.again);
            // a frame that the kernel refuses counts as lost in its cycle
            let _ = frame.send_blocking(|bytes| {
                let copy = &mut copy[..bytes.len()];
                copy.copy_from_slice(bytes);
                copy[NUMBER].copy_from_slice(&number.to_le_bytes());
                if link.send(copy) {
                    let slot = bytes[INDEX] as usize;
                    (slots[slot], numbers[slot], again[slot]) = (Slot::InFlight, number, 0);
                    counts.sent += 1;
                }
                Ok(bytes.len())
            });
            moved = true;
        }
        moved
    }

    fn receive(&mut self) -> bool {
        let mut moved = false;
        while let Some(length) = self.link.receive(&mut self.buffer) {
            moved = true;
            self.take(length);
        }
        moved
    }

    fn take(&mut self, length: usize) {
        if length <= INDEX {
            self.counts.bad += 1;
            return;
        }
        let kind = self.buffer[TYPE] >> 4;
        if self.lockstep && matches!(kind, NO_REPLY | STALLED) {
            let newest = self.next_number.wrapping_sub(1).to_le_bytes();
            if self.buffer[NUMBER] == newest {
                let count = u16::from_le_bytes([self.buffer[TYPE - 1], self.buffer[TYPE]]);
                match kind {
                    STALLED => self.stalled += u64::from(count & 0x7FF),
                    _ => self.unanswered = true,
                }
            }
            return;
        }
        let slot = self.buffer[INDEX] as usize;
        let state = self.slots[slot];
        if state != Slot::Never && self.buffer[NUMBER] != self.numbers[slot].to_le_bytes() {
            self.counts.late += 1;
            return;
        }
        match state {
            Slot::InFlight if emergency::asks_again(&self.buffer[..length], self.again[slot]) => {
                self.again[slot] += 1;
                emergency::request(&mut self.buffer[..length]);
                self.link.send(&self.buffer[..length]);
            }
            Slot::InFlight => match self.answer(length) {
                Ok(ethercrab::ReceiveAction::Processed) => {
                    self.slots[slot] = Slot::Answered;
                    self.counts.answered += 1;
                }
                _ => self.counts.bad += 1,
            },
            Slot::Answered => self.counts.duplicated += 1,
            Slot::GivenUp => {
                self.slots[slot] = Slot::Answered;
                self.counts.late += 1;
            }
            Slot::Never => self.counts.bad += 1,
        }
    }

    /// Pass the reply on with the source address that ethercrab expects.
    fn answer(
        &mut self,
        length: usize,
    ) -> Result<ethercrab::ReceiveAction, ethercrab::error::Error> {
        self.buffer[NUMBER].copy_from_slice(&OURS);
        self.rx.receive_frame(&self.buffer[..length])
    }

    fn give_up(&mut self) {
        for slot in &mut self.slots {
            if *slot == Slot::InFlight {
                *slot = Slot::GivenUp;
            }
        }
    }
}
