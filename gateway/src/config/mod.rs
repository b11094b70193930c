//! The configuration of one machine, read from a TOML file and checked.

mod check;
mod check_profile;
mod estimate;
mod hash;
mod homing;
mod landing;
mod limits;
mod mistakes;
mod offsets;
mod profile;
mod startup;
#[cfg(test)]
mod tests;
mod toml_error;

use serde::Deserialize;
use std::path::{Path, PathBuf};

pub use self::hash::hash as text_hash;
#[cfg(test)]
pub use check::parse;
pub use check::read;
pub use estimate::Estimate;
pub use flexhex_system::AXES;
pub use homing::{Homed, HomedAxis, Homing, STOPS};
pub use landing::Landing;
pub use limits::{Limits, PoseLimit};
pub use mistakes::ConfigError;
pub use profile::{Pdo, Profile, Role, Scale};
pub use startup::{Kind, Sdo};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    pub system: System,
    pub bus: Bus,
    pub real_time: RealTime,
    pub profile: Profile,
    pub limits: Limits,
    #[serde(default)]
    pub pose: Vec<PoseLimit>,
    pub safety: Safety,
    pub landing: Landing,
    #[serde(default)]
    pub reactions: crate::rules::Reactions,
    pub recorder: Recorder,
    #[serde(default)]
    pub estimate: Estimate,
    #[serde(default)]
    pub homing: Homing,
    pub drive: Vec<Drive>,
    /// Of the file with the values that the command line replaces.
    #[serde(skip)]
    pub hash: u64,
    /// The content of `homing.file`.
    #[serde(skip)]
    pub homed: Option<Homed>,
}

/// The system description and the component that the drives replace.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct System {
    pub ssp: PathBuf,
    pub host: String,
    /// Components that run in a thread of their own.
    #[serde(default)]
    pub own_thread: Vec<String>,
    /// Reaction to a component that is late.
    #[serde(default)]
    pub late: Late,
    /// Trip when one is late at more ticks in a row than this (`hold`).
    #[serde(default = "late_limit")]
    pub late_limit: u32,
    /// Longest wall-clock time of one step of a component [us].
    pub step_limit_us: Option<u32>,
    pub reference: String,
    pub following_error: String,
    pub feedforward: String,
    /// Inverse kinematics, for poses of the platform.
    pub pose_fmu: Option<PathBuf>,
    /// Parameters by name, `"feedback.tau_step" = 0.003`: numbers, true or false, names of items.
    #[serde(default)]
    pub parameters: std::collections::BTreeMap<String, flexhex_system::Value>,
}

fn late_limit() -> u32 {
    10
}

#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Late {
    /// Keep the last outputs for one more period and count it.
    #[default]
    Hold,
    Trip,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bus {
    pub interface: String,
    /// Longest wall-clock wait of a cycle for its reply.
    pub reply_timeout_us: u32,
    /// The same in lockstep.
    pub lockstep_timeout_ms: u32,
    /// The drives remove the torque by themselves after this time without process data.
    pub watchdog_ms: u32,
    pub distributed_clocks: bool,
    /// Phase of SYNC0 in the cycle.
    #[serde(default)]
    pub sync0_shift_us: u32,
    /// Largest difference of a drive's clock from the first drive's before power. Left out: a hundredth of the cycle.
    pub clock_difference_ns: Option<u32>,
    /// Longest time of a drive for a change of state.
    pub state_timeout_ms: u32,
}

impl Bus {
    /// Of a hundredth of the cycle an axis at full speed turns by less than its tracking error.
    pub fn clock_bound_ns(&self, cycle: std::time::Duration) -> u32 {
        self.clock_difference_ns.unwrap_or((cycle.as_nanos() / 100) as u32)
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RealTime {
    /// SCHED_FIFO priority, 1 to 99; 0 sets none.
    pub priority: i32,
    /// CPU of the control loop.
    pub cpu: Option<usize>,
    /// Last part of each wait, spent spinning.
    pub spin_us: u32,
    pub lock_memory: bool,
    /// Without these rights no drive is enabled. Left out: so on a hardware port.
    pub required: Option<bool>,
}

fn feedback_s() -> f64 {
    1.0
}

fn thermal_s() -> f64 {
    10.0
}

fn measured_s() -> f64 {
    0.01
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Safety {
    /// Trip after this many consecutive cycles without a reply.
    pub lost_frame_limit: u32,
    /// Trip after this many consecutive short working counters.
    pub working_counter_limit: u32,
    /// Speed is the mean over this many cycles.
    pub speed_cycles: u32,
    /// An encoder is frozen when its counts are constant for this many cycles ...
    pub frozen_cycles: u32,
    /// ... while the reference moved by more than this, ...
    pub frozen_motion_rad: f64,
    /// ... or for this many cycles in any case; 0: not judged, for coarse encoders.
    pub frozen_still_cycles: u32,
    /// Time constants of the means in the rules `feedback_torque` and `measured_torque`.
    #[serde(default = "feedback_s")]
    pub feedback_s: f64,
    #[serde(default = "measured_s")]
    pub measured_s: f64,
    /// Time constant of the mean square in the rule `thermal`.
    #[serde(default = "thermal_s")]
    pub thermal_s: f64,
    /// Trip when a cycle starts later than this (wall clock).
    pub overrun_us: u32,
    /// Values of the output `fault` that are reported but do not trip, by component:
    /// `feedback = [2.0]`.
    #[serde(default)]
    pub non_trip_faults: std::collections::BTreeMap<String, Vec<f64>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorder {
    pub folder: PathBuf,
    /// Seconds kept before a trip, also without a recording.
    pub keep_s: f64,
    /// Rows between the control loop and the writer.
    pub buffer_cycles: usize,
    /// Further signals of the system description, one column each.
    #[serde(default)]
    pub signals: Vec<String>,
}

/// One drive, in the order of the axes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Position on the bus, the first drive is 0.
    pub position: u16,
    /// Left out: any.
    pub serial: Option<u32>,
    pub direction: i8,
    pub offset_counts: i32,
    /// Objects of this drive alone; each replaces the same object of `profile.startup`.
    #[serde(default)]
    pub startup: Vec<Sdo>,
    /// Limits of this axis, if they differ from `[limits]`.
    pub limits: Option<Limits>,
}

impl Config {
    /// Limits of an axis.
    pub fn limits(&self, axis: usize) -> &Limits {
        self.drive[axis].limits.as_ref().unwrap_or(&self.limits)
    }

    /// Place of an axis among the drives in bus order, whatever other devices lie between.
    pub fn place_on_bus(&self, axis: usize) -> usize {
        let position = self.drive[axis].position;
        self.drive.iter().filter(|drive| drive.position < position).count()
    }

    /// Axis at each position of a bus with so many devices; None: no drive of the configuration.
    pub fn axes_on_bus(&self, devices: usize) -> Vec<Option<usize>> {
        let at =
            |position: usize| self.drive.iter().position(|d| usize::from(d.position) == position);
        (0..devices).map(at).collect()
    }

    /// Whether a drive of the configuration is at this position.
    pub fn is_drive(&self, position: u16) -> bool {
        self.drive.iter().any(|drive| drive.position == position)
    }

    /// Angle of one count [rad].
    pub fn theta_step(&self) -> f64 {
        2.0 * std::f64::consts::PI / self.profile.counts_per_revolution
    }

    /// A path of the configuration, relative to its file.
    fn place(file: &Path, path: &Path) -> PathBuf {
        let place = file.parent().unwrap_or(Path::new(".")).join(path);
        place.canonicalize().unwrap_or(place)
    }
}
