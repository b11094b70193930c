//! Requests to end, by signals: which are heeded, and which of them take the torque at once.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::now_ns;

/// Somebody wants the run to end: the machine lands.
static REQUESTED: AtomicBool = AtomicBool::new(false);
/// Somebody wants it to end at once.
static AT_ONCE: AtomicBool = AtomicBool::new(false);
/// Time of the first request from the keyboard [ns]; 0: none.
static FIRST_NS: AtomicU64 = AtomicU64::new(0);

/// A second request from the keyboard counts from this time after the first on [ns]. A program that starts the
/// gateway may pass on the signal that the terminal has sent already; nobody presses keys twice so fast.
const APART_NS: u64 = 100_000_000;

/// Ctrl-C, a closed terminal, and what else would end or stop this process while it holds the machine:
/// Ctrl-\, Ctrl-Z, a power cut that is announced, limits of computing time, signals sent by mistake.
const REQUEST: [libc::c_int; 10] = [
    libc::SIGINT,
    libc::SIGTERM,
    libc::SIGHUP,
    libc::SIGQUIT,
    libc::SIGTSTP,
    libc::SIGPWR,
    libc::SIGXCPU,
    libc::SIGALRM,
    libc::SIGUSR1,
    libc::SIGUSR2,
];
/// What is a failed read or write without it: the keyboard or the terminal in the background, a file that is
/// larger than allowed.
const IGNORE: [libc::c_int; 3] = [libc::SIGTTIN, libc::SIGTTOU, libc::SIGXFSZ];

/// Notes a request. Only a person can want less than a landing: a closed terminal sends SIGHUP twice, by the kernel
/// and by the shell, and a shutdown sends SIGTERM after SIGPWR.
extern "C" fn note(signal: libc::c_int) {
    REQUESTED.store(true, Ordering::Relaxed);
    if !matches!(signal, libc::SIGINT | libc::SIGQUIT) {
        return;
    }
    // the clock may be read in a signal handler
    let now = now_ns();
    let first = FIRST_NS.compare_exchange(0, now, Ordering::Relaxed, Ordering::Relaxed);
    if first.is_err_and(|first| is_second(first, now)) {
        AT_ONCE.store(true, Ordering::Relaxed);
    }
}

fn is_second(first_ns: u64, now_ns: u64) -> bool {
    now_ns.saturating_sub(first_ns) >= APART_NS
}

/// From here on these signals end the process, as nothing is held yet, also where the program that started it
/// ignores or blocks them: a script does so for what it starts in the background, and the request would be lost.
pub fn end_by_default() {
    set(REQUEST.map(|signal| (signal, libc::SIG_DFL)));
    // SAFETY: an all-zero sigset_t is valid memory for sigemptyset; the set outlives the calls.
    unsafe {
        let mut set: libc::sigset_t = std::mem::zeroed();
        libc::sigemptyset(&mut set);
        for signal in REQUEST {
            libc::sigaddset(&mut set, signal);
        }
        libc::pthread_sigmask(libc::SIG_UNBLOCK, &set, std::ptr::null_mut());
    }
}

/// From here on these signals request an orderly end.
pub fn listen() {
    let handler = note as extern "C" fn(libc::c_int) as libc::sighandler_t;
    set(REQUEST.map(|signal| (signal, handler)));
    set(IGNORE.map(|signal| (signal, libc::SIG_IGN)));
}

fn set<const N: usize>(signals: [(libc::c_int, libc::sighandler_t); N]) {
    for (signal, what) in signals {
        // SAFETY: the handler reads a clock and stores to atomics, which is allowed in a signal handler.
        unsafe { libc::signal(signal, what) };
    }
}

/// A request of the program itself.
pub fn request() {
    REQUESTED.store(true, Ordering::Relaxed);
}

pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// Requested again, by a person.
pub fn at_once() -> bool {
    AT_ONCE.load(Ordering::Relaxed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_keystroke_passed_on_is_no_second_request() {
        let first = 7_000_000_000;
        assert!(![0, 1, APART_NS - 1].iter().any(|later| is_second(first, first + later)));
        assert!(is_second(first, first + APART_NS) && is_second(first, u64::MAX));
        assert!(!is_second(first, first - 1), "two signals at once, on two threads");
    }
}
