//! Reasons for a trip as data, and the reaction that the configuration assigns to each.

use serde::Deserialize;

/// One name for each rule. `Stopped` is no fault: the run is over or was stopped by a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    LostFrames,
    WorkingCounter,
    AlState,
    DriveFault,
    DriveState,
    Mode,
    Torque,
    TorqueStep,
    MeasuredTorque,
    FeedbackTorque,
    Jump,
    FrozenEncoder,
    Speed,
    Position,
    FollowingError,
    Pose,
    Singular,
    Thermal,
    NotFinite,
    FmuError,
    FmuFault,
    FmuOverrun,
    LateThread,
    Overrun,
    Panic,
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
            Reason::Mode => "mode",
            Reason::Torque => "torque",
            Reason::TorqueStep => "torque_step",
            Reason::MeasuredTorque => "measured_torque",
            Reason::FeedbackTorque => "feedback_torque",
            Reason::Jump => "jump",
            Reason::FrozenEncoder => "frozen_encoder",
            Reason::Speed => "speed",
            Reason::Position => "position",
            Reason::FollowingError => "following_error",
            Reason::Pose => "pose",
            Reason::Singular => "singular",
            Reason::Thermal => "thermal",
            Reason::NotFinite => "not_finite",
            Reason::FmuError => "fmu_error",
            Reason::FmuFault => "fmu_fault",
            Reason::FmuOverrun => "fmu_overrun",
            Reason::LateThread => "late_thread",
            Reason::Overrun => "overrun",
            Reason::Panic => "panic",
            Reason::Stopped => "stopped",
        }
    }

    /// The value and its limit as a sentence.
    fn text(self, value: f64, limit: f64) -> String {
        let bits = |n: f64| n as u64;
        match self {
            Reason::LostFrames => {
                format!("{value} frames without a reply, in a row or too often, allowed fewer than {limit}")
            }
            Reason::WorkingCounter => format!("working counter {value}, expected {limit}"),
            Reason::AlState => {
                format!("AL status {:#04x}, expected {:#04x} (OP)", bits(value), bits(limit))
            }
            Reason::DriveFault => format!("drive fault {:#06x} (0x603F)", bits(value)),
            Reason::DriveState => {
                // "switch on disabled" without a fault: nobody here asked for it
                let why = match bits(value) & 0x4F {
                    0x40 => ": no power in the drive: emergency stop, safe torque off or mains?",
                    _ => "",
                };
                let (is, wanted) = (bits(value), bits(limit));
                format!("statusword {is:#04x}, expected {wanted:#04x} (operation enabled){why}")
            }
            Reason::Mode => format!("mode of operation {value} (0x6061), expected {limit}"),
            Reason::Torque => format!("torque {value} N m, allowed {limit} N m"),
            Reason::TorqueStep => {
                format!("wanted torque changes by {value} N m in a cycle, allowed {limit} N m")
            }
            Reason::MeasuredTorque => {
                format!("measured torque is {value} N m off the commanded one, allowed {limit} N m")
            }
            Reason::FeedbackTorque => format!(
                "the feedback adds {value} N m to the model, allowed {limit} N m: model, encoder or \
                 torque constant is wrong"
            ),
            Reason::Jump => format!("angle jumped by {value} rad, allowed {limit} rad"),
            Reason::FrozenEncoder => format!(
                "encoder counts constant for too long, the reference moved {value} rad meanwhile"
            ),
            Reason::Speed => format!("speed {value} rad/s, allowed {limit} rad/s"),
            Reason::Position => format!("angle {value} rad, limit {limit} rad"),
            Reason::FollowingError => format!("following error {value} rad, allowed {limit} rad"),
            Reason::Pose => format!("the platform would leave its limits: {value}, limit {limit}"),
            Reason::Singular => format!(
                "a singular pose is near: an axis moves the platform {value} times as far as in the neutral pose, \
                 allowed {limit} (landing.platform_gain)"
            ),
            Reason::Thermal => format!(
                "root mean square of the torque {value} N m, allowed {limit} N m (rated_torque_N_m)"
            ),
            Reason::NotFinite => "an FMU output is NaN or infinite".to_owned(),
            Reason::FmuError => "an FMU returned an error".to_owned(),
            Reason::FmuFault => format!("an FMU reports fault {value}"),
            Reason::FmuOverrun => format!("one FMU step took {value} us"),
            Reason::LateThread => "a component in a thread of its own was late".to_owned(),
            Reason::Overrun => format!("cycle started {value} us late, allowed {limit} us"),
            Reason::Panic => "the control loop panicked".to_owned(),
            Reason::Stopped => "stopped".to_owned(),
        }
    }
}

/// A violated rule with axis, value, limit and cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trip {
    pub reason: Reason,
    /// From 0; None for a rule that concerns no single axis.
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
        let text = self.reason.text(brief(self.value), brief(self.limit));
        write!(f, "{text} (cycle {})", self.cycle)
    }
}

/// Rounded to six significant digits, for text.
fn brief(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// How torque and drives are brought to a stop.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum ReactionKind {
    /// Category 2: stop and hold by feedback alone, land, then disable.
    #[default]
    Land,
    /// Category 1: the same by the other axes. The drive of the axis of the trip is disabled at once, and brakes it.
    Damp,
    /// Category 0: zero torque and quick stop of the drive, then disable.
    QuickStop,
    /// Category 0: zero torque and disable at once.
    Zero,
}

impl ReactionKind {
    /// The torque stays on until the machine has landed.
    pub fn lands(self) -> bool {
        matches!(self, ReactionKind::Land | ReactionKind::Damp)
    }

    /// Name in the configuration and in JSON.
    pub fn key(self) -> &'static str {
        match self {
            ReactionKind::Land => "land",
            ReactionKind::Damp => "damp",
            ReactionKind::QuickStop => "quick_stop",
            ReactionKind::Zero => "zero",
        }
    }
}

macro_rules! reactions {
    ($($field:ident = $reason:ident / $kind:ident),* $(,)?) => {
        /// The reaction to each reason.
        #[derive(Clone, Copy, Debug, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct Reactions { $(pub $field: ReactionKind),* }

        impl Default for Reactions {
            fn default() -> Self { Reactions { $($field: ReactionKind::$kind),* } }
        }

        impl Reactions {
            pub fn to(&self, reason: Reason) -> ReactionKind {
                match reason { $(Reason::$reason => self.$field),* }
            }

            /// Names of the rules with this reaction.
            pub fn with(&self, kind: ReactionKind) -> Vec<&'static str> {
                let all = [$((stringify!($field), self.$field)),*];
                all.into_iter().filter(|(_, k)| *k == kind).map(|(name, _)| name).collect()
            }
        }
    };
}

reactions! {
    lost_frames = LostFrames / Zero,
    working_counter = WorkingCounter / Zero,
    al_state = AlState / Zero,
    drive_fault = DriveFault / Damp,
    drive_state = DriveState / Zero,
    mode = Mode / Zero,
    torque = Torque / Land,
    torque_step = TorqueStep / Land,
    measured_torque = MeasuredTorque / Damp,
    feedback_torque = FeedbackTorque / Land,
    jump = Jump / Damp,
    frozen_encoder = FrozenEncoder / Damp,
    speed = Speed / Land,
    position = Position / Land,
    following_error = FollowingError / Land,
    pose = Pose / Land,
    singular = Singular / Land,
    thermal = Thermal / Land,
    not_finite = NotFinite / Land,
    fmu_error = FmuError / Land,
    fmu_fault = FmuFault / Land,
    fmu_overrun = FmuOverrun / Land,
    late_thread = LateThread / Land,
    overrun = Overrun / Land,
    panic = Panic / Land,
    stopped = Stopped / Land,
}
