//! How a run ended, and its figures.

use super::timing::Histogram;
use crate::safety::{Reason, Trip};
use crate::wire::Counts;

/// Why the drives were not enabled, or why they were disabled.
pub enum Ending {
    /// The wanted time is over.
    Done,
    /// Ctrl-C or SIGTERM.
    Asked,
    /// Refused before any power, with the reason.
    Refused(String),
    /// A rule was broken; the text adds what a component said.
    Tripped(Trip, String),
}

/// Durations of all cycles.
pub struct Timing {
    pub wake_up: Histogram,
    pub round_trip: Histogram,
    /// All FMU calls of a cycle.
    pub compute: Histogram,
    /// From the reply's arrival to the end of the cycle: computed, judged, recorded.
    pub after_reply: Histogram,
}

/// What a run was.
pub struct Outcome {
    pub ending: Ending,
    /// Cycles of the controller.
    pub cycles: i64,
    /// Cycles from the trip, or the end, to the first frame without torque, and to disabled drives.
    pub to_zero: u32,
    pub to_disabled: Option<u32>,
    pub timing: Timing,
    pub skipped: u64,
    pub lost: u64,
    pub short: u64,
    pub late_threads: u64,
    pub counts: Counts,
    pub overflowed: u64,
    /// Largest following error of each axis [rad].
    pub most_error: Vec<f64>,
}

impl Outcome {
    /// A run that has not begun.
    pub fn new() -> Self {
        Outcome {
            ending: Ending::Done,
            cycles: 0,
            to_zero: 0,
            to_disabled: None,
            timing: Timing {
                wake_up: Histogram::new(),
                round_trip: Histogram::new(),
                compute: Histogram::new(),
                after_reply: Histogram::new(),
            },
            skipped: 0,
            lost: 0,
            short: 0,
            late_threads: 0,
            counts: Counts::default(),
            overflowed: 0,
            most_error: vec![0.0; crate::config::AXES],
        }
    }

    /// The axis whose drive reported a fault, but whose process data does not say which.
    pub fn axis_with_fault(&self) -> Option<usize> {
        match &self.ending {
            Ending::Tripped(trip, _) if trip.reason == Reason::DriveFault && trip.value == 0.0 => {
                trip.axis
            }
            _ => None,
        }
    }

    /// Which fault it was, asked of the drive afterwards.
    pub fn set_error_code(&mut self, code: Option<u16>) {
        if let (Ending::Tripped(trip, _), Some(code)) = (&mut self.ending, code) {
            trip.value = code.into();
        }
    }
}
