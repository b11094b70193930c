//! A cycle allocates nothing, on either side: neither Rust, nor the executor, nor an FMU.
//!
//! The allocator of C is replaced for the whole process, FMUs included: this program's `malloc`
//! comes before that of the C library, which it calls. Only where that library is glibc.
#![cfg(all(target_os = "linux", target_env = "gnu"))]

use std::ffi::{c_char, c_void};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use flexhex_system::{Controller, Options, Plant, System};

static CALLS: AtomicU64 = AtomicU64::new(0);

extern "C" {
    fn __libc_malloc(size: usize) -> *mut c_void;
    fn __libc_calloc(count: usize, size: usize) -> *mut c_void;
    fn __libc_realloc(block: *mut c_void, size: usize) -> *mut c_void;
    fn fopen(path: *const c_char, mode: *const c_char) -> *mut c_void;
    fn fclose(stream: *mut c_void) -> i32;
}

/// # Safety
/// As `malloc` of the C library.
#[no_mangle]
pub unsafe extern "C" fn malloc(size: usize) -> *mut c_void {
    CALLS.fetch_add(1, Ordering::Relaxed);
    // SAFETY: the caller keeps the contract of `malloc`.
    unsafe { __libc_malloc(size) }
}

/// # Safety
/// As `calloc` of the C library.
#[no_mangle]
pub unsafe extern "C" fn calloc(count: usize, size: usize) -> *mut c_void {
    CALLS.fetch_add(1, Ordering::Relaxed);
    // SAFETY: the caller keeps the contract of `calloc`.
    unsafe { __libc_calloc(count, size) }
}

/// # Safety
/// As `realloc` of the C library.
#[no_mangle]
pub unsafe extern "C" fn realloc(block: *mut c_void, size: usize) -> *mut c_void {
    CALLS.fetch_add(1, Ordering::Relaxed);
    // SAFETY: the caller keeps the contract of `realloc`.
    unsafe { __libc_realloc(block, size) }
}

fn calls() -> u64 {
    CALLS.load(Ordering::Relaxed)
}

/// The `.ssp` that the environment names, else the one that `flexhex build` writes.
fn ssp() -> PathBuf {
    let built = concat!(env!("CARGO_MANIFEST_DIR"), "/../../out/hexapod.ssp");
    std::env::var_os("FLEXHEX_SSP").map_or(built.into(), PathBuf::from)
}

/// No test harness: its own threads allocate.
fn main() {
    the_counter_counts();
    a_cycle_allocates_nothing();
}

fn the_counter_counts() {
    let before = calls();
    drop(std::hint::black_box(vec![0u8; 100]));
    assert!(calls() > before, "allocations of Rust are not counted");
    // SAFETY: opened and closed with the C library's own functions; the library itself
    // allocates for it, which shows that its calls come here.
    let opened = unsafe {
        let before = calls();
        let stream = fopen(c"/dev/null".as_ptr(), c"r".as_ptr());
        assert!(!stream.is_null());
        fclose(stream);
        calls() - before
    };
    assert!(opened > 0, "allocations of shared libraries are not counted");
}

fn a_cycle_allocates_nothing() {
    let path = ssp();
    let system = System::open(&path).unwrap_or_else(|e| panic!("{e}: set FLEXHEX_SSP"));
    for own in [vec![], vec!["K".to_owned()]] {
        let options = Options {
            own_thread: own,
            wait: Duration::from_secs(5),
            step_limit: Some(Duration::from_secs(5)),
            fault_trips: true,
            ..Options::default()
        };
        let mut controller = Controller::open(&system, "plant", options).unwrap();
        let mut plant = Plant::open(&system, "plant", None, &[]).unwrap();
        let (mut theta, mut tau_meas) = ([0.0; 6], [0.0; 6]);
        let mut cycle = || {
            plant.read(&mut theta, &mut tau_meas);
            plant.step(controller.command()).unwrap();
            controller.cycle(&theta, &tau_meas).unwrap();
            controller.now()
        };
        // until a first result of the thread was taken: starting a thread allocates
        while cycle() < 240 {}
        let before = calls();
        while cycle() < 4000 {}
        assert_eq!(calls() - before, 0);
        assert!(controller.faults().next().is_none());
    }
}
