//! The system description on the machine: the `.ssp` with its FMUs, run by the executor of the
//! simulation. The component that stands for the machine (the host) is left out: who owns the
//! drives writes its outputs and reads its inputs.
//!
//! Signatures; the bodies follow.
#![allow(unused_variables, dead_code)]

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// What cannot be run: one text that says what, where and how to mend it.
#[derive(Debug, Clone)]
pub struct Error(String);

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

/// One scalar variable of an FMU; `start` is None where the FMU declares none.
pub struct Variable {
    pub name: String,
    pub unit: String,
    pub start: Option<f64>,
}

/// One component of the system.
pub struct Component {
    name: String,
}

impl Component {
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Base steps between two steps of it.
    pub fn period(&self) -> i64 {
        todo!()
    }
    /// Value of a parameter: the .ssp's, else the FMU's start value; None: no such parameter.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        todo!()
    }
    /// An input, output or parameter of the FMU.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        todo!()
    }
}

/// A `.ssp` that was read, checked and unpacked to a temporary folder.
pub struct System;

impl System {
    pub fn open(path: &Path) -> Result<System, Error> {
        todo!()
    }
    /// `[s]`
    pub fn base_step(&self) -> f64 {
        todo!()
    }
    pub fn component(&self, name: &str) -> Option<&Component> {
        todo!()
    }
    pub fn components(&self) -> &[Component] {
        todo!()
    }
}

/// What happens when a thread of its own has not finished at its tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Late {
    /// `cycle` returns a `Trip`.
    #[default]
    Trip,
    /// Its outputs stay as they are, the tick is left out and counted (`Controller::late`).
    Hold,
}

/// Called in every new thread before it does anything, with the component's name: priority, CPU.
pub type ThreadHook = Arc<dyn Fn(&str) + Send + Sync>;

/// How a controller is run.
#[derive(Clone, Default)]
pub struct Options {
    /// Components with a thread of their own, such as the estimator `K`.
    pub own_thread: Vec<String>,
    /// How long a late one is waited for: zero on a wall clock, seconds in lockstep.
    pub wait: Duration,
    pub late: Late,
    /// A component that takes longer for one step trips (`What::Overrun`); None: not measured.
    pub step_limit: Option<Duration>,
    /// Over what the `.ssp` says: ("feedback.tau_step", 0.003). Names of components that are not
    /// part of the controller (the plant's) are checked and left out, so that one list serves both.
    pub parameters: Vec<(String, f64)>,
    /// A `fault` output that is nonzero trips (`What::Fault`).
    pub fault_trips: bool,
    pub on_thread: Option<ThreadHook>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// The FMU refused a call.
    Error,
    /// NaN or infinite on an output.
    NotFinite,
    /// Its output `fault`.
    Fault(f64),
    /// Its own thread had not finished at its tick.
    Late,
    /// One step took longer than `Options::step_limit`.
    Overrun(Duration),
}

/// Why the controller stopped; every later `cycle` returns the same.
#[derive(Debug, Clone, PartialEq)]
pub struct Trip {
    pub component: String,
    pub what: What,
    pub message: String,
}

impl fmt::Display for Trip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Trip {}

/// Every component but the host. `Send`: may be opened in one thread and cycled in another.
pub struct Controller;

impl Controller {
    pub fn open(system: &System, host: &str, options: Options) -> Result<Controller, Error> {
        todo!()
    }
    /// Base steps n.
    pub fn now(&self) -> i64 {
        todo!()
    }
    /// `tau[1..6]` that the host gets at `now` [N m].
    pub fn command(&self) -> &[f64] {
        todo!()
    }
    /// Host outputs of n go on the bus, all components due step, then n + 1 is published.
    pub fn cycle(&mut self, theta: &[f64], tau_meas: &[f64]) -> Result<(), Trip> {
        todo!()
    }
    /// Place of "K.p[1]" on the bus.
    pub fn slot(&self, signal: &str) -> Option<usize> {
        todo!()
    }
    pub fn bus(&self) -> &[f64] {
        todo!()
    }
    /// Names "component.variable" in the order of the bus.
    pub fn signals(&self) -> &[String] {
        todo!()
    }
    /// Unit of each signal, in the order of the bus.
    pub fn units(&self) -> &[String] {
        todo!()
    }
    /// Component and value of every `fault` output that is not zero at `now`.
    pub fn faults(&self) -> impl Iterator<Item = (&str, f64)> {
        std::iter::empty()
    }
    /// Ticks that threads of their own have left out so far (`Late::Hold`).
    pub fn late(&self) -> u64 {
        todo!()
    }
}

/// One component of the `.ssp`, or another FMU in its place, with whatever feeds its other inputs.
pub struct Plant;

impl Plant {
    /// parameters: as `Options::parameters`, with the component's name: ("plant.tau_step", 0.003).
    pub fn open(
        system: &System,
        name: &str,
        fmu: Option<&Path>,
        parameters: &[(String, f64)],
    ) -> Result<Plant, Error> {
        todo!()
    }
    /// `theta[1..6]` [rad] and `tau_meas[1..6]` [N m] at `now`.
    pub fn read(&self, theta: &mut [f64], tau: &mut [f64]) {
        todo!()
    }
    /// One base step under the torques `tau` [N m].
    pub fn step(&mut self, tau: &[f64]) -> Result<(), Error> {
        todo!()
    }
    pub fn now(&self) -> i64 {
        todo!()
    }
}
