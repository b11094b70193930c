//! The cable: one raw socket, the frames in flight, and a loop that drives one future to its end.
//!
//! Everything happens in the calling thread: poll the future, send what it queued, hand it what
//! arrived, sleep until something does. No thread hop, no allocation, and a frame that nobody waits
//! for is counted and dropped.
//!
//! A frame's own index is one byte and comes again after some 32 cycles. So each frame carries its
//! number in the last four bytes of its source address too, which no device changes: a reply that is
//! older than the frame in flight is never taken for its answer.

mod clock;
mod socket;
#[cfg(test)]
mod tests;

use ethercrab::{PduRx, PduTx};
use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use crate::realtime::now_ns;
pub use socket::{Link, Socket};

const INDEX: usize = 17; // Ethernet header 14, EtherCAT header 2, command 1
const LARGEST: usize = 1600;
/// The number's place; the first device sets a bit of byte 6, the rest stays.
const NUMBER: std::ops::Range<usize> = 8..12;
/// What ethercrab's own source address has there.
const OURS: [u8; 4] = [0x10; 4];

/// What was seen on the cable.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub sent: u64,
    pub answered: u64,
    /// Came again after its first copy.
    pub duplicated: u64,
    /// Came after its cycle had given up.
    pub late: u64,
    /// Not an answer to anything that was sent.
    pub bad: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Slot {
    Never,
    InFlight,
    Answered,
    GivenUp,
}

/// One end of the cable, with `Socket` as the real one.
pub struct Wire<L: Link> {
    link: L,
    tx: PduTx<'static>,
    rx: PduRx<'static>,
    slots: [Slot; 256],
    /// Number of the newest frame with each index.
    numbers: [u32; 256],
    next_number: u32,
    buffer: [u8; LARGEST],
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
            next_number: 0,
            buffer: [0; LARGEST],
            counts: Counts::default(),
        }
    }

    /// The future's result, or None when `deadline_ns` passes first (it is dropped then).
    pub fn drive<F: Future>(&mut self, future: F, deadline_ns: u64) -> Option<F::Output> {
        let mut future = pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        loop {
            if let Poll::Ready(result) = future.as_mut().poll(&mut context) {
                return Some(result);
            }
            let moved = self.send() | self.receive();
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
            let (slots, numbers) = (&mut self.slots, &mut self.numbers);
            // a frame that the kernel did not take is a lost frame: its cycle counts it
            let _ = frame.send_blocking(|bytes| {
                let copy = &mut copy[..bytes.len()];
                copy.copy_from_slice(bytes);
                copy[NUMBER].copy_from_slice(&number.to_le_bytes());
                if link.send(copy) {
                    let slot = bytes[INDEX] as usize;
                    (slots[slot], numbers[slot]) = (Slot::InFlight, number);
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
        let slot = self.buffer[INDEX] as usize;
        let state = self.slots[slot];
        if state != Slot::Never && self.buffer[NUMBER] != self.numbers[slot].to_le_bytes() {
            self.counts.late += 1;
            return;
        }
        match state {
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

    /// Hand the reply over with the address that ethercrab knows.
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
