//! What is remembered of the machine: states that were recorded, and how fast and far it moved.
use crate::plant::AXES;
use crate::subdevice::SubDevice;
use std::collections::VecDeque;

/// Base steps of a mean speed.
const SPEED_STEPS: usize = 4;

/// The states of the last recorded events.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct States {
    pub(super) layer: &'static str,
    pub(super) drive: &'static str,
}

pub(super) fn states(device: &SubDevice) -> States {
    States { layer: device.layer.state.name(), drive: device.drive().machine.state.name() }
}

/// How fast and how far the axes have moved.
#[derive(Debug, Clone, Default)]
pub struct Extremes {
    past: VecDeque<[f64; AXES]>,
    /// Largest speed of any axis, mean over `SPEED_STEPS` [rad/s], and largest angle [rad].
    pub fastest: f64,
    pub farthest: f64,
}

impl Extremes {
    /// Angles [rad] after a base step [s].
    pub fn note(&mut self, theta: &[f64; AXES], dt: f64) {
        self.past.push_back(*theta);
        if self.past.len() > SPEED_STEPS {
            let before = self.past.pop_front().unwrap_or(*theta);
            let time = SPEED_STEPS as f64 * dt;
            let speed = |k: usize| (theta[k] - before[k]).abs() / time;
            self.fastest = (0..AXES).map(speed).fold(self.fastest, f64::max);
        }
        self.farthest = theta.iter().fold(self.farthest, |far, angle| far.max(angle.abs()));
    }
}
