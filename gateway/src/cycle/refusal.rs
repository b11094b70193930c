//! Why the drives were not enabled, or a task was not done.

use std::fmt;

use crate::bus::al;
use crate::bus::cia402::State;
use crate::config::AXES;
use crate::rules::Trip;
use crate::tasks::Failure;

/// Axes are counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// Too many replies were lost or incomplete.
    Replies(Trip),
    /// Its code is read when the run is over.
    AlState {
        axis: usize,
        al: u8,
        code: Option<u16>,
    },
    /// The same of a code 0.
    DriveFault {
        axis: usize,
        code: u16,
    },
    /// An angle outside its limits, or not a number.
    Angle {
        axis: usize,
        theta: f64,
        low: f64,
        high: f64,
    },
    Moving {
        axis: usize,
        rate: f64,
        limit: f64,
    },
    NotAtRestPose {
        axis: usize,
        theta: f64,
        wanted: f64,
        limit: f64,
    },
    /// The pose in which the machine rested when it was homed.
    NotAsHomed {
        axis: usize,
        theta: f64,
        wanted: f64,
        limit: f64,
    },
    /// Its weight, the torque that holds the neutral pose [N m], should have pulled it to the other side.
    AgainstWeight {
        axis: usize,
        theta: f64,
        weight: f64,
    },
    /// Others have been enabled for longer than `most_ms`; those that are not must not wait, as they carry no weight.
    LeftBehind {
        states: [State; AXES],
        most_ms: u32,
    },
    NotEnabled {
        states: [State; AXES],
    },
    Task(Failure),
}

impl Refusal {
    /// Name in JSON.
    pub fn key(&self) -> &'static str {
        match self {
            Refusal::Replies(trip) => trip.reason.key(),
            Refusal::AlState { .. } => "al_state",
            Refusal::DriveFault { .. } => "drive_fault",
            Refusal::Angle { .. } => "angle",
            Refusal::Moving { .. } => "moving",
            Refusal::NotAtRestPose { .. } => "rest_pose",
            Refusal::NotAsHomed { .. } => "not_as_homed",
            Refusal::AgainstWeight { .. } => "against_weight",
            Refusal::LeftBehind { .. } => "left_behind",
            Refusal::NotEnabled { .. } => "not_enabled",
            Refusal::Task(_) => "task",
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Refusal::Replies(trip) => {
                write!(f, "while the drives were being enabled: {trip}: check cables and supplies")
            }
            Refusal::AlState { axis, al, code } => {
                let (axis, state) = (axis + 1, al::name(*al));
                write!(f, "axis {axis}: {state} (AL status {al:#04x}) while enabling, expected OP: ")?;
                match code {
                    Some(code) => f.write_str(&al::describe(*code)),
                    None => f.write_str("AL status code not read: check the cable"),
                }
            }
            Refusal::DriveFault { axis, code } => {
                write!(f, "axis {}: drive fault {code:#06x} while enabling", axis + 1)
            }
            Refusal::Angle { axis, theta, low, high } => write!(
                f,
                "axis {}: theta = {theta:.4} rad, allowed {low:.4} to {high:.4} rad: move it by hand, or check \
                 drive[{axis}].offset_counts and direction",
                axis + 1
            ),
            Refusal::Moving { axis, rate, limit } => write!(
                f,
                "axis {}: it moves with {rate:.3} rad/s, allowed {limit} rad/s: wait until the machine rests",
                axis + 1
            ),
            Refusal::NotAtRestPose { axis, theta, wanted, limit } => write!(
                f,
                "axis {}: theta = {theta:.4} rad, landing.rest_rad = {wanted} rad, more than {limit} rad away: \
                 check drive[{axis}].offset_counts and that nothing blocks the axis",
                axis + 1
            ),
            Refusal::NotAsHomed { axis, theta, wanted, limit } => write!(
                f,
                "axis {}: theta = {theta:.4} rad, it rested at {wanted:.4} rad when it was homed (rest_rad or \
                 pose_rad in homing.file), more than {limit} rad away: its offset or its encoder is wrong, or something \
                 blocks it: free it, or home the machine again",
                axis + 1
            ),
            Refusal::AgainstWeight { axis, theta, weight } => write!(
                f,
                "axis {}: it rests at {theta:.4} rad, but its weight ({weight:.3} N m hold it in the neutral pose) \
                 pulls it to the other side: check drive[{axis}].direction and offset_counts; if something \
                 holds it there, set landing.rest_rad",
                axis + 1
            ),
            Refusal::LeftBehind { states, most_ms } => {
                let behind = states.iter().enumerate();
                let behind = behind.filter(|(_, state)| **state != State::OperationEnabled);
                let named: Vec<_> =
                    behind.map(|(k, state)| format!("axis {}: {}", k + 1, state.name())).collect();
                write!(
                    f,
                    "{}, but others have been enabled for more than landing.enable_ms = {most_ms}: read the \
                     warnings of this drive, or raise enable_ms if it releases a brake",
                    named.join(", ")
                )
            }
            Refusal::NotEnabled { states } => {
                let names = states.map(State::name);
                write!(f, "not all drives reached operation enabled: {names:?}")
            }
            Refusal::Task(why) => why.fmt(f),
        }
    }
}
