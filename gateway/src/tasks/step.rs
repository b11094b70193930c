//! What a task sees of a cycle, and what it wants next.

use crate::config::AXES;
use crate::motion::{Pace, Path};

use super::failure::Failure;

pub type Axes = [f64; AXES];

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

    pub fn holding(self, time: f64) -> Leg {
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
    Fail(Failure),
}
