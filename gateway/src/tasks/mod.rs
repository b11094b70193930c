//! What leads the machine in the place of the controller: poses, a person, end stops, pushes. A task sees what a
//! cycle measured and says what comes next; it uses no sockets, clocks or FMUs.

mod arrivals;
mod failure;
mod jog;
mod nudges;
mod poses;
mod step;
mod stops;

pub use arrivals::{Arrivals, Arrived};
pub use failure::Failure;
pub use jog::{Jog, Order, ORDERS};
pub use nudges::Nudges;
pub use poses::Poses;
use step::Axes;
pub use step::{Leg, Seen, Step};
pub use stops::{Search, Stops};

/// What a run does after the drives are enabled.
pub enum Task {
    /// The FMUs, from the start of the reference on.
    Control,
    Poses(Poses),
    Jog(Jog),
    Stops(Stops),
    Nudges(Box<Nudges>),
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
