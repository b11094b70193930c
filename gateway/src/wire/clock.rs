//! The clock that ethercrab's time-outs read, and when the next of them wants to be looked at.
//!
//! The thread that drives the bus polls its future again whenever it wakes, so wakers are not kept:
//! the earliest instant is enough.

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

/// When to look again at the latest: the earliest time-out asked for since the last call.
pub fn next_wake(now: u64) -> u64 {
    DRIVER.next_ns.swap(u64::MAX, Ordering::Relaxed).max(now)
}
