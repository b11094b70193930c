//! Why the platform does not take a way, and where on it.

use flexhex_system::Error;
use std::fmt::{self, Display, Formatter};

use crate::config::{PoseLimit, AXES};

type Axes = [f64; AXES];

/// Angles in rad, torques in N m.
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle {
    Unreachable(Axes),
    Singular {
        at: Axes,
        gain: f64,
        most: f64,
    },
    Limit {
        at: Axes,
        limit: PoseLimit,
        value: f64,
    },
    /// A stop would end outside the limits of an axis.
    Position {
        axis: usize,
        angle: f64,
        low: f64,
        high: f64,
    },
    /// A stop takes more torque than a landing may give.
    Torque {
        at: Axes,
        axis: usize,
        needed: f64,
        most: f64,
    },
    /// A planned path takes more torque than a lift-off may give.
    Weight {
        at: Axes,
        axis: usize,
        needed: f64,
        most: f64,
    },
    Failed(Error),
}

impl Display for Obstacle {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Obstacle::Unreachable(at) => write!(f, "the platform cannot reach {at:.3?} rad"),
            Obstacle::Singular { at, gain, most } => write!(
                f,
                "at {at:.3?} rad an axis moves the platform {gain:.2} times as far as in the neutral pose, \
                 allowed {most} (landing.platform_gain): a singular pose is near"
            ),
            Obstacle::Limit { at, limit: PoseLimit { signal, min, max }, value } => write!(
                f,
                "at {at:.3?} rad {signal} = {value:.4}, allowed {min} to {max} ([[pose]])"
            ),
            Obstacle::Position { axis, angle, low, high } => write!(
                f,
                "axis {} would come to rest at {angle:.3} rad, allowed {low} to {high} \
                 (position_min_rad, position_max_rad)",
                axis + 1
            ),
            Obstacle::Torque { at, axis, needed, most } => write!(
                f,
                "at {at:.3?} rad axis {} needs {needed:.2} N m to brake, allowed {most} (landing.torque_N_m)",
                axis + 1
            ),
            Obstacle::Weight { at, axis, needed, most } => write!(
                f,
                "at {at:.3?} rad axis {} needs {needed:.2} N m to carry the machine, allowed {most} \
                 (landing.torque_N_m): raise it, at most to limits.torque_N_m; more than that is needed, as the \
                 feedback adds its own",
                axis + 1
            ),
            Obstacle::Failed(why) => why.fmt(f),
        }
    }
}
