//! The configuration of one machine, as it stands in a TOML file. `check` says what is wrong in it.

mod check;
mod check_profile;
mod profile;
#[cfg(test)]
mod tests;
mod words;

use serde::Deserialize;
use std::path::{Path, PathBuf};

#[cfg(test)]
pub use check::parse;
pub use check::read;
pub use profile::{Pdo, Profile, Role, Scale};

/// Axes of the machine; the drives, the host's inputs and outputs and every limit have this many.
pub const AXES: usize = 6;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    pub system: System,
    pub bus: Bus,
    pub real_time: RealTime,
    pub profile: Profile,
    pub limits: Limits,
    pub safety: Safety,
    #[serde(default)]
    pub reactions: crate::safety::Reactions,
    pub recorder: Recorder,
    pub drive: Vec<Drive>,
}

/// What is computed: the system description and the component that the drives stand in for.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct System {
    pub ssp: PathBuf,
    pub host: String,
    /// Components that run in a thread of their own.
    #[serde(default)]
    pub own_thread: Vec<String>,
    /// What happens when one of those is not ready in time.
    #[serde(default)]
    pub late: Late,
    /// One step of a component may take this long (wall clock).
    pub step_limit_us: Option<u32>,
    pub reference: String,
    pub following_error: String,
    pub feedforward: String,
    /// Parameters of components by name, `feedback.tau_step = 0.003`.
    #[serde(default)]
    pub parameters: std::collections::BTreeMap<String, f64>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Late {
    /// The last estimate stays for one more period, and it is counted.
    #[default]
    Hold,
    Trip,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bus {
    pub interface: String,
    /// How long a cycle waits for its reply (wall clock).
    pub reply_timeout_us: u32,
    /// The same in lockstep, in real time.
    pub lockstep_timeout_ms: u32,
    /// After this long without process data the drives take the torque away by themselves.
    pub watchdog_ms: u32,
    pub distributed_clocks: bool,
    /// Phase of SYNC0 in the cycle.
    #[serde(default)]
    pub sync0_shift_us: u32,
    /// How long the drives may take for a change of state.
    pub state_timeout_ms: u32,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RealTime {
    /// SCHED_FIFO priority, 1 to 99; 0 asks for none.
    pub priority: i32,
    /// CPU that the cycle is pinned to.
    pub cpu: Option<usize>,
    /// Last part of the wait that is spent spinning.
    pub spin_us: u32,
    pub lock_memory: bool,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    #[serde(rename = "torque_N_m")]
    pub torque: f64,
    #[serde(rename = "speed_rad_per_s")]
    pub speed: f64,
    #[serde(rename = "position_min_rad")]
    pub position_min: f64,
    #[serde(rename = "position_max_rad")]
    pub position_max: f64,
    #[serde(rename = "following_error_rad")]
    pub following_error: f64,
    /// Largest change of an angle in one cycle.
    #[serde(rename = "jump_rad")]
    pub jump: f64,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Safety {
    /// Trip at this many cycles without a reply, one after the other.
    pub lost_frame_limit: u32,
    /// Trip at this many short working counters, one after the other.
    pub working_counter_limit: u32,
    /// Speed is the mean over this many cycles.
    pub speed_cycles: u32,
    /// An encoder is frozen when it gives the same counts this long ...
    pub frozen_cycles: u32,
    /// ... while its reference moved by this much.
    pub frozen_motion_rad: f64,
    /// Trip when a cycle begins this late (wall clock).
    pub overrun_us: u32,
    /// Fault outputs that only tell: `feedback = [2.0]`.
    #[serde(default)]
    pub told_faults: std::collections::BTreeMap<String, Vec<f64>>,
    /// How long the ramp of a reaction takes.
    pub ramp_ms: u32,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorder {
    pub folder: PathBuf,
    /// Kept before a trip, even when nothing is recorded.
    pub keep_s: f64,
    /// Rows between the cycle and the writer.
    pub buffer_cycles: usize,
    /// More signals of the system description, each a column.
    #[serde(default)]
    pub signals: Vec<String>,
}

/// One drive, in the order of the axes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Place on the cable, the first is 0.
    pub position: u16,
    /// Any, where it is left out.
    pub serial: Option<u32>,
    pub direction: i8,
    pub offset_counts: i32,
    /// Limits of this axis where they differ.
    pub limits: Option<Limits>,
}

impl Config {
    /// Limits of an axis.
    pub fn limits(&self, axis: usize) -> &Limits {
        self.drive[axis].limits.as_ref().unwrap_or(&self.limits)
    }

    /// Angle of one count [rad].
    pub fn theta_step(&self) -> f64 {
        2.0 * std::f64::consts::PI / self.profile.counts_per_revolution
    }

    /// A path of the configuration, taken from where its file lies.
    fn place(file: &Path, path: &Path) -> PathBuf {
        let place = file.parent().unwrap_or(Path::new(".")).join(path);
        place.canonicalize().unwrap_or(place)
    }
}
