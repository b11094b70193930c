//! Why a controller stopped.

use std::fmt;
use std::time::Duration;

use crate::component::Component;

/// The kind of failure.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// An FMU call returned an error.
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
    /// Base step of the failure.
    pub now: i64,
    pub message: String,
}

impl Trip {
    fn new(component: &str, what: What, now: i64, message: String) -> Trip {
        Trip { component: component.to_owned(), what, now, message }
    }

    /// `message`: of the executor; it names component, call and time.
    pub(crate) fn refused(component: &str, now: i64, message: String) -> Trip {
        Trip::new(component, What::Error, now, message)
    }

    pub(crate) fn not_finite(component: &str, now: i64, signal: &str, value: f64) -> Trip {
        let message = format!("{signal} = {value} at base step {now}, must be finite");
        Trip::new(component, What::NotFinite, now, message)
    }

    pub(crate) fn fault(component: &Component, now: i64, fault: f64) -> Trip {
        let message = format!("{} at base step {now}, must be 0", component.fault_text(fault));
        Trip::new(component.name(), What::Fault(fault), now, message)
    }

    pub(crate) fn late(component: &str, now: i64, period: i64) -> Trip {
        let fed = now - period;
        let message = format!(
            "{component}: fed at base step {fed}, not finished at {now}, when its result is due"
        );
        Trip::new(component, What::Late, now, message)
    }

    pub(crate) fn hung(component: &str, now: i64, period: i64, ticks: u32) -> Trip {
        let fed = now - i64::from(ticks) * period;
        let message = format!(
            "{component}: fed at base step {fed}, not finished {ticks} of its periods later"
        );
        Trip::new(component, What::Late, now, message)
    }

    pub(crate) fn overrun(component: &str, now: i64, spent: Duration, limit: Duration) -> Trip {
        let micro = |time: Duration| (1e6 * time.as_secs_f64()).round();
        let message = format!(
            "{component}: its step at base step {now} took {} us, allowed {} us",
            micro(spent),
            micro(limit)
        );
        Trip::new(component, What::Overrun(spent), now, message)
    }
}

impl fmt::Display for Trip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Trip {}
