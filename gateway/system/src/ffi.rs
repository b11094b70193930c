//! The executor's C interface as in `ssp/executor.h`, and an FMU's functions by `dlopen`.
//! No decisions are made here; `executor.rs` is the safe interface.

use std::ffi::{c_char, c_int, c_void};
use std::marker::{PhantomData, PhantomPinned};
use std::path::Path;

use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};

use crate::error::Error;

/// `executor_functions`: addresses in the order of the header.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Functions([*const c_void; N_FUNCTIONS]);

const N_FUNCTIONS: usize = 14;

const NAMES: [&str; N_FUNCTIONS] = [
    "fmi2Instantiate",
    "fmi2FreeInstance",
    "fmi2SetDebugLogging",
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2Terminate",
    "fmi2GetReal",
    "fmi2SetReal",
    "fmi2GetInteger",
    "fmi2SetInteger",
    "fmi2GetBoolean",
    "fmi2SetBoolean",
    "fmi2DoStep",
];

/// `executor_variables`.
#[repr(C)]
pub struct Variables {
    pub n_reals: usize,
    pub n_integers: usize,
    pub n_booleans: usize,
    pub references: *const u32,
}

/// `executor_component`.
#[repr(C)]
pub struct Description {
    pub name: *const c_char,
    pub library: *const c_char,
    pub functions: *const Functions,
    pub guid: *const c_char,
    pub resources: *const c_char,
    pub period: i64,
    pub parameters: Variables,
    pub values: *const f64,
    pub inputs: Variables,
    pub sources: *const usize,
    pub outputs: Variables,
    pub slot: usize,
    pub n_categories: usize,
    pub categories: *const *const c_char,
}

/// `struct executor`, seen through pointers only.
#[repr(C)]
pub struct Opaque {
    _data: [u8; 0],
    _marker: PhantomData<(*mut u8, PhantomPinned)>,
}

extern "C" {
    pub fn executor_open(
        components: *const Description,
        n_components: usize,
        n_slots: usize,
        base: f64,
        logs: *mut c_void,
        n_logs: usize,
        timing: bool,
        message: *mut c_char,
        size: usize,
    ) -> *mut Opaque;
    pub fn executor_publish(e: *mut Opaque, component: usize, n: i64) -> bool;
    pub fn executor_feed(e: *mut Opaque, component: usize, n: i64) -> bool;
    pub fn executor_advance(e: *mut Opaque, component: usize, n: i64) -> bool;
    pub fn executor_message(e: *const Opaque) -> *const c_char;
    pub fn executor_instance(e: *const Opaque, component: usize) -> *mut c_void;
    pub fn executor_bus(e: *mut Opaque) -> *mut f64;
    pub fn executor_close(e: *mut Opaque);
}

/// The functions of FMI 2.0 for the state of an instance, `fmi2FMUstate` being `*mut c_void`.
#[derive(Clone, Copy)]
pub struct StateFunctions {
    pub get: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int,
    pub set: unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_int,
    pub free: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int,
    pub size: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut usize) -> c_int,
    pub to_bytes: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut u8, usize) -> c_int,
    pub of_bytes: unsafe extern "C" fn(*mut c_void, *const u8, usize, *mut *mut c_void) -> c_int,
}

/// A loaded FMU binary; its functions are good for as long as it lives.
#[derive(Debug)]
pub struct Binary {
    pub functions: Functions,
    library: Library,
}

// SAFETY: the addresses are of code, which never moves or changes while the library is loaded.
unsafe impl Send for Binary {}
// SAFETY: as above; a shared reference only reads the addresses.
unsafe impl Sync for Binary {}

impl Binary {
    pub fn load(path: &Path) -> Result<Binary, Error> {
        // SAFETY: loading runs the initialisers of the FMU that the user names; whoever runs an
        // FMU trusts its code. RTLD_NOW: no symbol is looked up later, inside a cycle.
        let library = unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }
            .map_err(|e| Error::new(format!("its library does not load: {e}")))?;
        let mut functions = Functions([std::ptr::null(); N_FUNCTIONS]);
        for (function, name) in functions.0.iter_mut().zip(NAMES) {
            // SAFETY: only the address is taken; the executor calls it with the signature that
            // FMI 2.0 gives this name.
            let symbol = unsafe { library.get::<*const c_void>(name.as_bytes()) }
                .map_err(|_| Error::new(format!("its library lacks the function {name}")))?;
            *function = *symbol;
        }
        Ok(Binary { functions, library })
    }

    /// None where the FMU cannot save its state, which FMI leaves open.
    pub fn state_functions(&self) -> Option<StateFunctions> {
        // SAFETY: the signatures are those that FMI 2.0 gives these names.
        unsafe {
            Some(StateFunctions {
                get: *self.library.get(b"fmi2GetFMUstate").ok()?,
                set: *self.library.get(b"fmi2SetFMUstate").ok()?,
                free: *self.library.get(b"fmi2FreeFMUstate").ok()?,
                size: *self.library.get(b"fmi2SerializedFMUstateSize").ok()?,
                to_bytes: *self.library.get(b"fmi2SerializeFMUstate").ok()?,
                of_bytes: *self.library.get(b"fmi2DeSerializeFMUstate").ok()?,
            })
        }
    }
}
