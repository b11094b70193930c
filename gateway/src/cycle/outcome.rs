//! How a run ended, and its figures.

use super::timing::Histogram;
use crate::bus::cia402;
use crate::config::AXES;
use crate::rules::{ReactionKind, Reason, Trip};
use crate::wire::Counts;
use flexhex_system::{Error, State};

/// How the run ended.
pub enum Ending {
    /// The duration is over.
    Done,
    /// Ctrl-C or SIGTERM.
    StopRequested,
    /// The drives were not all enabled, with the reason.
    Refused(String),
    /// A rule was violated; the text is the message of the component, if any.
    Tripped(Trip, String),
}

/// Distributions of the durations of all cycles.
pub struct Timing {
    pub wake_up: Histogram,
    pub round_trip: Histogram,
    /// All FMU calls of a cycle.
    pub compute: Histogram,
    /// From the arrival of the reply to the end of the cycle.
    pub after_reply: Histogram,
}

/// Ending and figures of a run.
pub struct Outcome {
    pub ending: Ending,
    /// Cycles of the controller.
    pub cycles: i64,
    /// Cycles from the trip, or the end, to the first frame without torque, and to disabled drives.
    pub to_zero: u32,
    pub to_disabled: Option<u32>,
    pub reaction: ReactionKind,
    /// What cut a landing short.
    pub landing_trip: Option<Trip>,
    /// Axes whose drive was read back as disabled at the end.
    pub disabled: [bool; AXES],
    pub timing: Timing,
    pub skipped: u64,
    pub lost: u64,
    pub short: u64,
    pub late_threads: u64,
    pub counts: Counts,
    pub overflowed: u64,
    /// What the components with a thread of their own have learned, or why that is not known.
    pub states: Vec<Result<State, Error>>,
    /// Largest following error of each axis [rad].
    pub most_error: Vec<f64>,
}

impl Outcome {
    /// Before the run.
    pub fn new() -> Self {
        Outcome {
            ending: Ending::Done,
            cycles: 0,
            to_zero: 0,
            to_disabled: None,
            reaction: ReactionKind::Zero,
            landing_trip: None,
            disabled: [false; AXES],
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
            states: Vec::new(),
            most_error: vec![0.0; crate::config::AXES],
        }
    }

    /// Statuswords that were read after the bus left OP.
    pub fn read_back(&mut self, statusword: &[Option<u16>; AXES]) {
        for (disabled, word) in self.disabled.iter_mut().zip(statusword) {
            let off = |word: u16| {
                let state = cia402::state(word);
                !state.is_energised() || state == cia402::State::Fault
            };
            *disabled |= word.is_some_and(off);
        }
    }

    /// Axes, from 1, whose drive may still have power.
    pub fn unconfirmed(&self) -> Vec<usize> {
        (0..AXES).filter(|k| !self.disabled[*k]).map(|k| k + 1).collect()
    }

    /// It ended as wanted: on its rest pose, every drive disabled.
    pub fn good(&self) -> bool {
        let wanted = matches!(self.ending, Ending::Done | Ending::StopRequested);
        wanted && self.landing_trip.is_none() && self.unconfirmed().is_empty()
    }

    /// The axis of a drive fault whose code is not in the process data.
    pub fn axis_with_fault(&self) -> Option<usize> {
        let unknown = |trip: &Trip| trip.reason == Reason::DriveFault && trip.value == 0.0;
        match &self.ending {
            Ending::Tripped(trip, _) if unknown(trip) => trip.axis,
            _ => self.landing_trip.filter(unknown)?.axis,
        }
    }

    /// Sets the fault code that was read from the drive afterwards.
    pub fn set_error_code(&mut self, code: Option<u16>) {
        let Some(code) = code else { return };
        match (&mut self.ending, &mut self.landing_trip) {
            (Ending::Tripped(trip, _), _) | (_, Some(trip)) => trip.value = code.into(),
            _ => {}
        }
    }
}
