//! Why the machine was stopped, and what the configuration wants done then.

use serde::Deserialize;

/// One word for each rule. `Stopped` is no mistake: the run is over or somebody asked for its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    LostFrames,
    WorkingCounter,
    AlState,
    DriveFault,
    DriveState,
    Torque,
    Jump,
    FrozenEncoder,
    Speed,
    Position,
    FollowingError,
    NotFinite,
    FmuError,
    FmuFault,
    FmuOverrun,
    LateThread,
    Overrun,
    Stopped,
}

impl Reason {
    /// Name in the configuration, in logs and in JSON.
    pub fn key(self) -> &'static str {
        match self {
            Reason::LostFrames => "lost_frames",
            Reason::WorkingCounter => "working_counter",
            Reason::AlState => "al_state",
            Reason::DriveFault => "drive_fault",
            Reason::DriveState => "drive_state",
            Reason::Torque => "torque",
            Reason::Jump => "jump",
            Reason::FrozenEncoder => "frozen_encoder",
            Reason::Speed => "speed",
            Reason::Position => "position",
            Reason::FollowingError => "following_error",
            Reason::NotFinite => "not_finite",
            Reason::FmuError => "fmu_error",
            Reason::FmuFault => "fmu_fault",
            Reason::FmuOverrun => "fmu_overrun",
            Reason::LateThread => "late_thread",
            Reason::Overrun => "overrun",
            Reason::Stopped => "stopped",
        }
    }

    /// The value and its limit in words.
    fn words(self, value: f64, limit: f64) -> String {
        let word = |n: f64| n as u64;
        match self {
            Reason::LostFrames => {
                format!("{value} frames without an answer, allowed fewer than {limit}")
            }
            Reason::WorkingCounter => format!("working counter {value}, wanted {limit}"),
            Reason::AlState => {
                format!("AL status {:#04x}, wanted {:#04x}", word(value), word(limit))
            }
            Reason::DriveFault => format!("fault {:#06x} of the drive", word(value)),
            Reason::DriveState => format!(
                "statusword {:#04x}, wanted {:#04x} (operation enabled)",
                word(value),
                word(limit)
            ),
            Reason::Torque => format!("torque {value} N m, allowed {limit} N m"),
            Reason::Jump => format!("angle jumped by {value} rad, allowed {limit} rad"),
            Reason::FrozenEncoder => format!(
                "counts stand still while the reference moved {value} rad, allowed {limit} rad"
            ),
            Reason::Speed => format!("speed {value} rad/s, allowed {limit} rad/s"),
            Reason::Position => format!("angle {value} rad, limit {limit} rad"),
            Reason::FollowingError => format!("following error {value} rad, allowed {limit} rad"),
            Reason::NotFinite => "an FMU gave a number that is none".to_owned(),
            Reason::FmuError => "an FMU returned an error".to_owned(),
            Reason::FmuFault => format!("an FMU reports fault {value}"),
            Reason::FmuOverrun => format!("an FMU took {value} us for one step"),
            Reason::LateThread => "a component in its own thread was not ready".to_owned(),
            Reason::Overrun => format!("a cycle began {value} us late, allowed {limit} us"),
            Reason::Stopped => "asked to end".to_owned(),
        }
    }
}

/// The rule that was broken: which, where, by how much, when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trip {
    pub reason: Reason,
    /// Counted from 0; None where it is no axis.
    pub axis: Option<usize>,
    pub value: f64,
    pub limit: f64,
    pub cycle: i64,
}

impl Trip {
    pub fn of(reason: Reason, axis: Option<usize>, value: f64, limit: f64, cycle: i64) -> Trip {
        Trip { reason, axis, value, limit, cycle }
    }
}

impl std::fmt::Display for Trip {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        if let Some(axis) = self.axis {
            write!(f, "axis {}: ", axis + 1)?;
        }
        let words = self.reason.words(brief(self.value), brief(self.limit));
        write!(f, "{words} (cycle {})", self.cycle)
    }
}

/// Six digits: what people read.
fn brief(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// What is done with the torque.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Fade the last torque to zero, then disable.
    Ramp,
    /// Zero torque and the drive's own quick stop, then disable.
    #[default]
    QuickStop,
    /// Zero torque and disable at once.
    Zero,
}

macro_rules! reactions {
    ($($field:ident = $reason:ident / $kind:ident),* $(,)?) => {
        /// The reaction to each reason.
        #[derive(Clone, Copy, Debug, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct Reactions { $(pub $field: Kind),* }

        impl Default for Reactions {
            fn default() -> Self { Reactions { $($field: Kind::$kind),* } }
        }

        impl Reactions {
            pub fn to(&self, reason: Reason) -> Kind {
                match reason { $(Reason::$reason => self.$field),* }
            }
        }
    };
}

reactions! {
    lost_frames = LostFrames / Zero,
    working_counter = WorkingCounter / Zero,
    al_state = AlState / Zero,
    drive_fault = DriveFault / Zero,
    drive_state = DriveState / Zero,
    torque = Torque / Zero,
    jump = Jump / Zero,
    frozen_encoder = FrozenEncoder / Zero,
    speed = Speed / QuickStop,
    position = Position / QuickStop,
    following_error = FollowingError / QuickStop,
    not_finite = NotFinite / Ramp,
    fmu_error = FmuError / Ramp,
    fmu_fault = FmuFault / Ramp,
    fmu_overrun = FmuOverrun / Ramp,
    late_thread = LateThread / Ramp,
    overrun = Overrun / QuickStop,
    stopped = Stopped / Ramp,
}
