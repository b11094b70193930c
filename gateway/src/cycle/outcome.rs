//! How a run ended, and its figures.

use super::refusal::Refusal;
use super::timing::Histogram;
use crate::bus::{al, cia402, Ask, Clocks, Left, Links};
use crate::config::AXES;
use crate::rules::{ReactionKind, Reason, Trip};
use crate::tasks::Task;
use crate::wire::Counts;

/// How the run ended.
pub enum Ending {
    /// The duration is over.
    Done,
    /// Ctrl-C or SIGTERM.
    StopRequested,
    /// The drives were not all enabled, or a task was not done.
    Refused(Refusal),
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
    /// Cycles of the controller, and of the lift-off or another task before it.
    pub cycles: i64,
    pub lifted: u64,
    /// Cycles from the trip, or the end, to the first frame without torque, and to disabled drives.
    pub to_zero: u32,
    pub to_disabled: Option<u32>,
    pub reaction: ReactionKind,
    /// Times [s] in which axes braked that took less than `landing.brake_ms`.
    pub brakes: [Option<f64>; AXES],
    /// Axes whose brake ended outside their limits all the same.
    pub passed: [bool; AXES],
    /// What cut a landing short.
    pub landing_trip: Option<Trip>,
    /// Its cause, if a drive told it.
    pub landing_detail: String,
    /// Axes whose drive was read back as disabled at the end.
    pub disabled: [bool; AXES],
    pub timing: Timing,
    pub skipped: u64,
    pub lost: u64,
    pub short: u64,
    pub late_threads: u64,
    /// Cycles in which each axis showed each of `cia402::REMARKS`.
    pub remarks: [[u64; cia402::REMARKS.len()]; AXES],
    /// Components that left the bounds of their estimates, and by what.
    pub frozen: Vec<String>,
    /// Largest share of its limit of each rule, the nearest first, and of the bounds of the estimate.
    pub shares: Vec<(&'static str, f64)>,
    pub counts: Counts,
    /// What the controllers of the devices counted, and how far their clocks were off.
    pub links: Links,
    pub clocks: Clocks,
    pub overflowed: u64,
    /// What was done, with what was found.
    pub task: Task,
    /// Offsets of the encoders, in counts, under which the angles of the run were measured.
    pub offsets: [i32; AXES],
    /// Serial numbers of the drives.
    pub serials: [u32; AXES],
    /// Largest following error of each axis [rad].
    pub most_error: Vec<f64>,
}

impl Outcome {
    /// Before the run.
    pub fn new() -> Self {
        Outcome {
            ending: Ending::Done,
            cycles: 0,
            lifted: 0,
            to_zero: 0,
            to_disabled: None,
            reaction: ReactionKind::Zero,
            brakes: [None; AXES],
            passed: [false; AXES],
            landing_trip: None,
            landing_detail: String::new(),
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
            remarks: [[0; cia402::REMARKS.len()]; AXES],
            frozen: Vec::new(),
            shares: Vec::new(),
            counts: Counts::default(),
            links: Links::default(),
            clocks: Clocks::default(),
            overflowed: 0,
            task: Task::Control,
            offsets: [0; AXES],
            serials: [0; AXES],
            most_error: vec![0.0; crate::config::AXES],
        }
    }

    /// Takes what the devices said after the end.
    pub fn take(&mut self, left: Left) {
        self.read_back(&left.statusword);
        (self.counts, self.links, self.clocks) = (left.counts, left.links, left.clocks);
        self.answer(left.error_code, left.al_code);
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

    /// Takes the remarks of the statuswords of a reply.
    pub fn note_remarks(&mut self, statusword: &[u16; AXES]) {
        for (counts, word) in self.remarks.iter_mut().zip(statusword) {
            // one that has no power may say that there is no voltage
            let enabled = cia402::state(*word) == cia402::State::OperationEnabled;
            for (count, (bit, value, _)) in counts.iter_mut().zip(cia402::REMARKS) {
                *count += u64::from(word & bit == value && (enabled || value != 0));
            }
        }
    }

    /// What the drives said without a fault: axis, from 1, remark, cycles.
    pub fn remarked(&self) -> Vec<(usize, &'static str, u64)> {
        let by_axis = self.remarks.iter().enumerate();
        let all = by_axis.flat_map(|(k, counts)| {
            let named = cia402::REMARKS.iter().zip(counts);
            named.map(move |((.., name), count)| (k + 1, *name, *count))
        });
        all.filter(|(_, _, count)| *count > 0).collect()
    }

    /// Axes, from 1, whose drive may still have power.
    pub fn unconfirmed(&self) -> Vec<usize> {
        (0..AXES).filter(|k| !self.disabled[*k]).map(|k| k + 1).collect()
    }

    /// Why it tripped, as recordings have it.
    pub fn trip_text(&self) -> Option<String> {
        let Ending::Tripped(trip, detail) = &self.ending else { return None };
        Some(format!("{}: {trip} {detail}", trip.reason.key()))
    }

    /// It ended as wanted: on its rest pose, every drive disabled.
    pub fn good(&self) -> bool {
        let wanted = matches!(self.ending, Ending::Done | Ending::StopRequested);
        wanted && self.landing_trip.is_none() && self.unconfirmed().is_empty()
    }

    /// Causes that only the drives know: of a fault whose code is not in the process data, of an AL state.
    pub fn open_questions(&self) -> Ask {
        let (error_code, al_code) = match &self.ending {
            Ending::Refused(Refusal::DriveFault { axis, code: 0 }) => (Some(*axis), None),
            Ending::Refused(Refusal::AlState { axis, .. }) => (None, Some(*axis)),
            _ => (
                self.axis_of(|trip| trip.reason == Reason::DriveFault && trip.value == 0.0),
                self.axis_of(|trip| trip.reason == Reason::AlState),
            ),
        };
        Ask { error_code, al_code }
    }

    fn axis_of(&self, wanted: impl Fn(&Trip) -> bool) -> Option<usize> {
        match &self.ending {
            Ending::Tripped(trip, _) if wanted(trip) => trip.axis,
            _ => self.landing_trip.filter(wanted)?.axis,
        }
    }

    /// Sets the causes that were read from the drives afterwards.
    pub fn answer(&mut self, error_code: Option<u16>, al_code: Option<u16>) {
        let trip = match (&mut self.ending, &mut self.landing_trip) {
            (Ending::Tripped(trip, _), _) | (_, Some(trip)) => Some(trip),
            _ => None,
        };
        if let (Some(trip), Some(code)) = (trip, error_code) {
            trip.value = code.into();
        }
        let text = al_code.map(al::describe);
        match (&mut self.ending, text) {
            (Ending::Refused(Refusal::DriveFault { code, .. }), _) => {
                *code = error_code.unwrap_or(*code);
            }
            (Ending::Refused(Refusal::AlState { code, .. }), _) => *code = al_code,
            (Ending::Tripped(trip, detail), Some(text)) if trip.reason == Reason::AlState => {
                *detail = text;
            }
            (_, Some(text)) => self.landing_detail = text,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remarks_are_counted_and_no_voltage_only_of_drives_that_are_enabled() {
        let mut out = Outcome::new();
        // warning; no voltage; the same of a drive that is not enabled; a limit
        out.note_remarks(&[0x02B7, 0x0227, 0x0240, 0x0A37, 0x0237, 0x0237]);
        let [voltage, warning, limit] = cia402::REMARKS.map(|(.., text)| text);
        assert_eq!(out.remarked(), [(1, warning, 1), (2, voltage, 1), (4, limit, 1)]);
    }
}
