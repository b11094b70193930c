//! Why configuration and system description do not go together.

use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use flexhex_system::{Component, Error, System};

use crate::exit::{Ends, Exit};

#[derive(Debug)]
pub enum Mismatch {
    /// The system description, its parameters or its FMUs cannot be used.
    System(Error),
    Parameters(Error),
    /// A key names a component that is not there.
    NoComponent {
        key: &'static str,
        name: String,
        all: Vec<String>,
    },
    /// A component lacks a variable, and which key to correct.
    NoVariable {
        ssp: PathBuf,
        component: String,
        variable: String,
        mend: &'static str,
    },
    /// A key names a signal that is not there, and some that are.
    NoSignal {
        key: String,
        signal: String,
        near: Vec<String>,
    },
    /// A key names a signal of another unit, and some that have the right one.
    Unit {
        key: String,
        signal: String,
        unit: String,
        wanted: &'static str,
        near: Vec<String>,
    },
    /// A signal starts outside the limits of the platform's pose.
    Start {
        key: String,
        signal: String,
        value: f64,
        min: f64,
        max: f64,
    },
    /// `bus.reply_timeout_us` and the cycle time [us].
    Timeout {
        timeout: u32,
        cycle: f64,
        ssp: PathBuf,
    },
    /// The torque that a component may command is above the limit of an axis [N m].
    Torque {
        axis: usize,
        limit: f64,
        key: String,
        commands: f64,
    },
    /// A gain without which an axis cannot be landed: key, value.
    NoGain(String, f64),
    /// Limits that contradict each other, with the keys.
    Limits(Vec<String>),
}

impl Mismatch {
    pub fn no_component(key: &'static str, name: &str, system: &System) -> Mismatch {
        let all = system.components().iter().map(Component::name).map(str::to_owned).collect();
        Mismatch::NoComponent { key, name: name.to_owned(), all }
    }
}

impl Display for Mismatch {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Mismatch::System(why) => why.fmt(f),
            Mismatch::Parameters(why) => write!(f, "[system.parameters]: {why}"),
            Mismatch::NoComponent { key, name, all } => {
                write!(f, "{key}: no component {name:?}, only {all:?}: correct the name")
            }
            Mismatch::NoVariable { ssp, component, variable, mend } => write!(
                f,
                "{}: component {component} has no variable {variable}: {mend}",
                ssp.display()
            ),
            Mismatch::NoSignal { key, signal, near } => {
                write!(f, "{key}: the system has no signal {signal:?}; some of its signals: {near:?}")
            }
            Mismatch::Unit { key, signal, unit, wanted, near } => write!(
                f,
                "{key}: {signal} is in {unit:?}, must be in {wanted:?}: name another signal; in {wanted:?} are {near:?}"
            ),
            Mismatch::Start { key, signal, value, min, max } => write!(
                f,
                "{key}: {signal} starts at {value}, allowed {min} to {max}: correct the limits, or the \
                 start of the motion"
            ),
            Mismatch::Timeout { timeout, cycle, ssp } => write!(
                f,
                "bus.reply_timeout_us = {timeout}, allowed less than {cycle:.0}, the cycle time of {}",
                ssp.display()
            ),
            Mismatch::Torque { axis, limit, key, commands } => write!(
                f,
                "limits.torque_N_m = {limit} of axis {}: {key} = {commands} N m exceeds it: lower {key} in \
                 [system.parameters] or raise the limit",
                axis + 1
            ),
            Mismatch::NoGain(key, value) => write!(
                f,
                "{key} = {value}, must be above 0: lift-off and landing hold the axis by it: correct it in \
                 [system.parameters], or name another feedback in landing.feedback"
            ),
            Mismatch::Limits(all) => f.write_str(&all.join("\n")),
        }
    }
}

impl Ends for Mismatch {
    fn exit(&self) -> Exit {
        Exit::BadInput
    }
}
