//! Kernel services: locked memory, FIFO priority, CPU affinity, absolute clock, stop signals.

pub mod stop;

use std::fmt::{self, Display, Formatter};
use std::io;
use std::time::Duration;

/// A right that the kernel does not give to this process.
#[derive(Debug)]
pub struct Denied {
    right: Right,
    why: io::Error,
}

#[derive(Clone, Copy, Debug)]
enum Right {
    LockedMemory,
    Priority,
    Cpu(usize),
}

impl Display for Denied {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let why = &self.why;
        match self.right {
            Right::LockedMemory => {
                write!(f, "memory not locked ({why}): run as root or raise `ulimit -l`")
            }
            Right::Priority => {
                write!(f, "no real-time priority ({why}): run as root or grant CAP_SYS_NICE")
            }
            Right::Cpu(cpu) => write!(
                f,
                "not pinned to CPU {cpu} ({why}): set real_time.cpu to a CPU that this process may use"
            ),
        }
    }
}

/// Time of the monotonic clock [ns].
pub fn now_ns() -> u64 {
    let mut t = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the kernel writes into the timespec above, which outlives the call.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &mut t) };
    t.tv_sec as u64 * 1_000_000_000 + t.tv_nsec as u64
}

/// Sleep until a time of the monotonic clock; the last `spin` of it is spent spinning.
pub fn sleep_until(at_ns: u64, spin: Duration) {
    let early = at_ns.saturating_sub(spin.as_nanos() as u64);
    let t = libc::timespec {
        tv_sec: (early / 1_000_000_000) as libc::time_t,
        tv_nsec: (early % 1_000_000_000) as libc::c_long,
    };
    // SAFETY: the timespec outlives the call; no remainder is asked for, an absolute time has none.
    // A signal ends the sleep early, so it is repeated.
    while unsafe {
        libc::clock_nanosleep(libc::CLOCK_MONOTONIC, libc::TIMER_ABSTIME, &t, std::ptr::null_mut())
    } == libc::EINTR
    {}
    while now_ns() < at_ns {
        std::hint::spin_loop();
    }
}

/// Lock all present and future pages in memory.
pub fn lock_memory() -> Result<(), Denied> {
    // SAFETY: takes flags, accesses no memory of this process.
    granted(Right::LockedMemory, unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) })
}

/// Set SCHED_FIFO with this priority (1 to 99) for the calling thread.
pub fn set_fifo(priority: i32) -> Result<(), Denied> {
    let p = libc::sched_param { sched_priority: priority };
    // SAFETY: 0 is the calling thread, the parameter outlives the call.
    granted(Right::Priority, unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &p) })
}

/// Run the calling thread on this CPU only.
pub fn pin_to(cpu: usize) -> Result<(), Denied> {
    // SAFETY: an all-zero cpu_set_t is the empty set; CPU_SET checks its bounds by itself.
    let set = unsafe {
        let mut set: libc::cpu_set_t = std::mem::zeroed();
        libc::CPU_SET(cpu, &mut set);
        set
    };
    // SAFETY: 0 is the calling thread; size and set belong together.
    let done = unsafe { libc::sched_setaffinity(0, std::mem::size_of_val(&set), &set) };
    granted(Right::Cpu(cpu), done)
}

fn granted(right: Right, done: libc::c_int) -> Result<(), Denied> {
    match done {
        0 => Ok(()),
        _ => Err(Denied { right, why: io::Error::last_os_error() }),
    }
}
