//! The clock of ethercrab's time-outs, and the time of the next one.
//!
//! The thread of the bus polls its future whenever it wakes, so no wakers are kept: the earliest
//! time-out is enough.

use std::sync::atomic::{AtomicU64, Ordering};
use std::task::Waker;

use crate::realtime::now_ns;

const TICK_NS: u64 = 1_000_000_000 / embassy_time_driver::TICK_HZ;

struct Monotonic {
    next_ns: AtomicU64,
}

impl embassy_time_driver::Driver for Monotonic {
    fn now(&self) -> u64 {
        now_ns() / TICK_NS
    }

    fn schedule_wake(&self, at: u64, _: &Waker) {
        let at = at.saturating_add(1).saturating_mul(TICK_NS);
        self.next_ns.fetch_min(at, Ordering::Relaxed);
    }
}

embassy_time_driver::time_driver_impl!(static DRIVER: Monotonic = Monotonic {
    next_ns: AtomicU64::new(u64::MAX),
});

/// Latest time of the next poll: the earliest time-out requested since the last call.
pub fn next_wake(now: u64) -> u64 {
    DRIVER.next_ns.swap(u64::MAX, Ordering::Relaxed).max(now)
}
