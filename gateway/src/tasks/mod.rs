//! What leads the machine in the place of the controller: poses, a person, end stops, pushes. A task sees what a
//! cycle measured and says what comes next; it uses no sockets, clocks or FMUs.

mod jog;
mod nudges;
mod poses;
mod stops;

use crate::config::AXES;
use crate::motion::{Pace, Path};
pub use jog::{Jog, Order, ORDERS};
pub use nudges::Nudges;
pub use poses::Poses;
pub use stops::{Search, Stops};

type Axes = [f64; AXES];

/// What a run does after the drives are enabled.
pub enum Task {
    /// The FMUs, from the start of the reference on.
    Control,
    Poses(Poses),
    Jog(Jog),
    Stops(Stops),
    Nudges(Nudges),
}

/// A cycle as a task sees it.
pub struct Seen<'a> {
    /// The reply is complete.
    pub complete: bool,
    pub theta: &'a Axes,
    pub tau_meas: &'a Axes,
    /// Wanted angles [rad].
    pub r: &'a Axes,
    /// Cycles left of the leg.
    pub left: u32,
}

/// A way from pose to pose [rad].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    pub from: Axes,
    pub to: Axes,
    /// Highest speed [rad/s]; None: that of a landing.
    pub speed: Option<f64>,
    /// Time to wait there [s]; None: that of a landing.
    pub hold: Option<f64>,
    /// An axis that may meet its end stop on the way, and its largest torque [N m].
    pub seeks: Option<(usize, f64)>,
}

impl Leg {
    pub fn new(from: Axes, to: Axes) -> Leg {
        Leg { from, to, speed: None, hold: None, seeks: None }
    }

    pub fn held(self, time: f64) -> Leg {
        Leg { hold: Some(time), ..self }
    }

    /// The path, with its own times or those of `pace`.
    pub fn path(&self, pace: Pace) -> Path {
        let (speed, pause) = (self.speed.unwrap_or(pace.speed), self.hold.unwrap_or(pace.pause));
        Path::new(self.from, [0.0; AXES], self.to, Pace { speed, pause, ..pace })
    }
}

/// What a task wants.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    Stay,
    Go(Leg),
    /// Torque of this axis without feedback [N m].
    Push(usize, f64),
    /// The FMUs take over.
    Begin,
    Over,
    Fail(String),
}

impl Task {
    /// The first leg from where the machine rests; None: to the start of the reference.
    pub fn begin(&mut self, rest: &Axes) -> Option<Leg> {
        match self {
            Task::Control => None,
            Task::Poses(poses) => poses.begin(rest),
            Task::Jog(jog) => Some(jog.begin(rest)),
            Task::Stops(stops) => Some(stops.begin(rest)),
            Task::Nudges(nudges) => Some(nudges.begin(rest)),
        }
    }

    pub fn step(&mut self, seen: &Seen) -> Step {
        match self {
            Task::Control if seen.left == 0 => Step::Begin,
            Task::Control => Step::Stay,
            Task::Poses(poses) => poses.step(seen),
            Task::Jog(jog) => jog.step(seen),
            Task::Stops(stops) => stops.step(seen),
            Task::Nudges(nudges) => nudges.step(seen),
        }
    }

    /// The angles mean something: the encoders are homed.
    pub fn is_homed(&self) -> bool {
        !matches!(self, Task::Stops(_) | Task::Nudges(_))
    }

    /// Feedback may be trusted: signs of torque and angle are known.
    pub fn feeds_back(&self) -> bool {
        !matches!(self, Task::Nudges(_))
    }
}
