//! Safe interface to the executor of the simulation (`ssp/executor.c`). It owns all strings and
//! arrays that the C side points to.

use std::ffi::{c_char, c_void, CStr, CString};
use std::ptr::{null, null_mut, NonNull};
use std::sync::Arc;

use crate::error::Error;
use crate::ffi::{self, Binary, Description, Functions};
use crate::unit::{Sorted, Unit};
use crate::watch::Watch;

/// Memory that the C side points to while the executor lives.
struct Kept {
    binary: Binary,
    functions: Box<Functions>,
    name: CString,
    guid: CString,
    resources: CString,
    _categories: Vec<CString>,
    category_pointers: Vec<*const c_char>,
    parameters: Sorted,
    values: Vec<f64>,
    inputs: Sorted,
    sources: Vec<usize>,
    outputs: Sorted,
    period: i64,
    slot: usize,
}

/// Open FMUs and their bus.
pub(crate) struct Executor {
    raw: NonNull<ffi::Opaque>,
    n_slots: usize,
    n_units: usize,
    _descriptions: Box<[Description]>,
    kept: Vec<Kept>,
    /// Its names: of each unit, then of all. Who steps the units says so here: another thread
    /// than that of the cycle may be late.
    watch: Arc<Watch>,
}

// SAFETY: FMI 2.0 lets any thread call an instance, one at a time, which `&mut self` ensures;
// the pointers inside lead to memory that the executor owns.
unsafe impl Send for Executor {}

impl Executor {
    /// Instantiates and initialises all units.
    pub fn open(units: Vec<Unit>, n_slots: usize, base: f64) -> Result<Executor, Error> {
        let mut names: Vec<_> = units.iter().map(|unit| unit.name.clone()).collect();
        names.push(format!("{}{}", if units.len() > 1 { "one of " } else { "" }, names.join(", ")));
        let watch = Watch::new(names);
        let load = |(k, unit)| {
            watch.begin(k);
            Kept::new(unit)
        };
        let kept = units.into_iter().enumerate().map(load).collect::<Result<Vec<_>, _>>()?;
        let descriptions: Box<[Description]> = kept.iter().map(Kept::description).collect();
        for (k, unit) in kept.iter().enumerate() {
            let end = unit.slot + unit.outputs.len();
            let inside = end <= n_slots && unit.sources.iter().all(|s| *s < n_slots);
            assert!(inside && unit.period > 0, "unit {k} leaves the bus");
        }
        watch.begin(kept.len());
        let mut message = [0u8; 1024];
        // SAFETY: descriptions and what they point to are kept in the returned value, on the
        // heap, unchanged; every slot is inside the bus (asserted); message has the size given.
        let raw = unsafe {
            ffi::executor_open(
                descriptions.as_ptr(),
                descriptions.len(),
                n_slots,
                base,
                null_mut(),
                0,
                false,
                message.as_mut_ptr().cast(),
                message.len(),
            )
        };
        watch.end();
        match NonNull::new(raw) {
            Some(raw) => Ok(Executor {
                raw,
                n_slots,
                n_units: kept.len(),
                _descriptions: descriptions,
                kept,
                watch,
            }),
            None => Err(Error::new(mended(text(&message)))),
        }
    }

    /// Outputs of a unit to the bus; false: `message` holds the reason.
    pub fn publish(&mut self, unit: usize, n: i64) -> bool {
        assert!(unit < self.n_units);
        // SAFETY: the executor is open and the unit exists.
        unsafe { ffi::executor_publish(self.raw.as_ptr(), unit, n) }
    }

    /// Inputs of a unit from the bus.
    pub fn feed(&mut self, unit: usize, n: i64) -> bool {
        assert!(unit < self.n_units);
        // SAFETY: the executor is open and the unit exists.
        unsafe { ffi::executor_feed(self.raw.as_ptr(), unit, n) }
    }

    /// One step of a unit from n to n + its period.
    pub fn advance(&mut self, unit: usize, n: i64) -> bool {
        assert!(unit < self.n_units);
        // SAFETY: the executor is open and the unit exists.
        unsafe { ffi::executor_advance(self.raw.as_ptr(), unit, n) }
    }

    /// Calls of an instance by functions of its binary, watched.
    pub fn with_instance<T>(
        &mut self,
        unit: usize,
        calls: impl FnOnce(*mut c_void, &Binary) -> T,
    ) -> T {
        assert!(unit < self.n_units);
        // SAFETY: the executor is open and the unit exists.
        let instance = unsafe { ffi::executor_instance(self.raw.as_ptr(), unit) };
        self.watch.begin(unit);
        let out = calls(instance, &self.kept[unit].binary);
        self.watch.end();
        out
    }

    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// Message of the last call that failed.
    pub fn message(&self) -> String {
        // SAFETY: the executor is open; its message is a terminated string inside of it, which
        // no other call changes while `self` is borrowed.
        let message = unsafe { CStr::from_ptr(ffi::executor_message(self.raw.as_ptr())) };
        message.to_string_lossy().into_owned()
    }

    pub fn bus(&self) -> &[f64] {
        // SAFETY: the bus has n_slots values for as long as the executor is open, and calls
        // that write them want `&mut self`.
        unsafe { std::slice::from_raw_parts(ffi::executor_bus(self.raw.as_ptr()), self.n_slots) }
    }

    pub fn bus_mut(&mut self) -> &mut [f64] {
        // SAFETY: as for `bus`, borrowed exclusively.
        unsafe {
            std::slice::from_raw_parts_mut(ffi::executor_bus(self.raw.as_ptr()), self.n_slots)
        }
    }
}

impl Drop for Executor {
    fn drop(&mut self) {
        self.watch.begin(self.n_units);
        // SAFETY: opened by `executor_open`, closed once; binaries are unloaded after this.
        unsafe { ffi::executor_close(self.raw.as_ptr()) }
        self.kept.clear();
        self.watch.end();
    }
}

impl Kept {
    fn new(unit: Unit) -> Result<Kept, Error> {
        let path = unit.fmu.library()?;
        let binary = Binary::load(&path).map_err(|e| e.at(&unit.fmu.file).at(&unit.name))?;
        let string = |text: &str| {
            CString::new(text).map_err(|_| Error::new("a name holds a NUL").at(&unit.fmu.file))
        };
        let categories = unit.fmu.categories.iter().map(|c| string(c));
        let categories = categories.collect::<Result<Vec<_>, _>>()?;
        Ok(Kept {
            functions: Box::new(binary.functions),
            binary,
            name: string(&unit.name)?,
            guid: string(&unit.fmu.guid)?,
            resources: string(&unit.fmu.resources())?,
            category_pointers: categories.iter().map(|c| c.as_ptr()).collect(),
            _categories: categories,
            parameters: unit.parameters,
            values: unit.values,
            inputs: unit.inputs,
            sources: unit.sources,
            outputs: unit.outputs,
            period: unit.period,
            slot: unit.slot,
        })
    }

    /// Pointers into this value's heap memory, which moving the value leaves where it is.
    fn description(&self) -> Description {
        Description {
            name: self.name.as_ptr(),
            library: null(),
            functions: &*self.functions,
            guid: self.guid.as_ptr(),
            resources: self.resources.as_ptr(),
            period: self.period,
            parameters: self.parameters.raw(),
            values: self.values.as_ptr(),
            inputs: self.inputs.raw(),
            sources: self.sources.as_ptr(),
            outputs: self.outputs.raw(),
            slot: self.slot,
            n_categories: self.category_pointers.len(),
            categories: self.category_pointers.as_ptr(),
        }
    }
}

/// The remedy for an error of an FMU while it is opened, where its message has none.
fn mended(message: String) -> String {
    if message.contains("fmi2Instantiate") {
        let hint = "its binary is not the one that its modelDescription.xml describes, or lacks a \
                    file: build the FMU anew";
        return format!("{message}: {hint}");
    }
    message
}

fn text(buffer: &[u8]) -> String {
    let end = buffer.iter().position(|b| *b == 0).unwrap_or(buffer.len());
    String::from_utf8_lossy(&buffer[..end]).into_owned()
}
