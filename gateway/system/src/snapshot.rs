//! The state of an FMU instance as bytes, by the functions that FMI 2.0 has for it.

use std::ffi::{c_int, c_void};
use std::ptr::null_mut;

use crate::error::Error;
use crate::executor::Executor;
use crate::ffi::{Binary, StateFunctions};

const NO_STATE: &str = "the FMU cannot save its state (no fmi2SerializeFMUstate)";
/// `fmi2OK` and `fmi2Warning`; whatever is greater is an error.
const MOST_GOOD: c_int = 1;

/// The state of a unit between two steps.
pub(crate) fn save(executor: &mut Executor, unit: usize) -> Result<Vec<u8>, Error> {
    executor.with_instance(unit, saved)
}

fn saved(instance: *mut c_void, binary: &Binary) -> Result<Vec<u8>, Error> {
    let call = binary.state_functions().ok_or_else(|| Error::new(NO_STATE))?;
    let mut state = null_mut();
    // SAFETY: the instance lives as long as the executor, which is borrowed exclusively; the FMU
    // writes the state's address.
    good("fmi2GetFMUstate", unsafe { (call.get)(instance, &mut state) })?;
    let bytes = serialised(&call, instance, state);
    free(&call, instance, state);
    bytes
}

/// Puts a unit into a state that `save` gave; its own time then goes on from there.
pub(crate) fn restore(executor: &mut Executor, unit: usize, bytes: &[u8]) -> Result<(), Error> {
    executor.with_instance(unit, |instance, binary| put(instance, binary, bytes))
}

fn put(instance: *mut c_void, binary: &Binary, bytes: &[u8]) -> Result<(), Error> {
    let call = binary.state_functions().ok_or_else(|| Error::new(NO_STATE))?;
    let mut state = null_mut();
    // SAFETY: as in `saved`; pointer and length are those of one slice.
    let status = unsafe { (call.of_bytes)(instance, bytes.as_ptr(), bytes.len(), &mut state) };
    good("fmi2DeSerializeFMUstate", status).map_err(|why| {
        Error::new(format!("the saved state is damaged ({why}): start without it"))
    })?;
    // SAFETY: as in `saved`; the state is the one that the FMU has just made.
    let set = good("fmi2SetFMUstate", unsafe { (call.set)(instance, state) });
    free(&call, instance, state);
    set
}

fn serialised(
    call: &StateFunctions,
    instance: *mut c_void,
    state: *mut c_void,
) -> Result<Vec<u8>, Error> {
    let mut size = 0;
    // SAFETY: as in `saved`; the FMU writes the size.
    good("fmi2SerializedFMUstateSize", unsafe { (call.size)(instance, state, &mut size) })?;
    let mut bytes = vec![0; size];
    // SAFETY: as in `saved`; pointer and size are those of one vector.
    let status = unsafe { (call.to_bytes)(instance, state, bytes.as_mut_ptr(), size) };
    good("fmi2SerializeFMUstate", status).map(|()| bytes)
}

fn free(call: &StateFunctions, instance: *mut c_void, mut state: *mut c_void) {
    // SAFETY: the state is of this instance and is not used again.
    unsafe { (call.free)(instance, &mut state) };
}

fn good(name: &str, status: c_int) -> Result<(), Error> {
    if (0..=MOST_GOOD).contains(&status) {
        return Ok(());
    }
    Err(Error::new(format!("{name} returned status {status}")))
}
