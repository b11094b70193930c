//! What the rules judge.

use crate::config::AXES;
use crate::rules::Reason;

/// Measurements of one cycle. Arrays are by axis.
pub struct Measured<'a> {
    pub cycle: i64,
    /// Cycles that the clock skipped before this one.
    pub skipped: u64,
    /// A reply came in time.
    pub answered: bool,
    pub working_counter: u16,
    pub theta: &'a [f64; AXES],
    pub tau_meas: &'a [f64; AXES],
    /// Torque of the next frame [N m].
    pub tau: &'a [f64],
    /// What the feedback adds to the torque of the model [N m]; None: there is no model in this phase.
    pub feedback: Option<&'a [f64; AXES]>,
    pub r: &'a [f64; AXES],
    pub e: &'a [f64; AXES],
    pub statusword: &'a [u16; AXES],
    pub error_code: &'a [u16; AXES],
    /// Values of the signals in `config.pose`; empty outside the run.
    pub pose: &'a [f64],
    /// Gain of the platform over that in the neutral pose, in the cycles in which it is known.
    pub gain: Option<f64>,
    /// AL status, 0 where a device did not answer.
    pub al_state: &'a [u8; AXES],
    /// Mode of operation display, where the process data has it.
    pub mode: &'a [Option<i8>; AXES],
    /// Failure of the controller, with its value.
    pub controller: Option<(Reason, f64)>,
    pub overrun_us: f64,
}
