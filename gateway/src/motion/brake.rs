//! How soon each axis stands: in the time of a brake, or sooner where that would end outside its limits.

use flexhex_system::Motion;

use super::path::{Pace, Path};
use crate::config::{Config, AXES};

type Axes = [f64; AXES];

/// Largest deceleration of a brake over its mean one.
const PEAK: f64 = 1.5;

/// What a brake may take.
#[derive(Clone, Copy, Debug)]
pub struct Brakes {
    pub pace: Pace,
    /// Shortest time [s], and largest torque [N m].
    pub shortest: f64,
    pub most: f64,
    /// Limits of the angles [rad].
    pub limits: [(f64, f64); AXES],
}

impl Brakes {
    pub fn of(config: &Config, base_step: f64) -> Brakes {
        let (pace, most) = (Pace::of(&config.landing, base_step), config.landing.torque);
        let steps = std::array::from_fn(|k| config.limits(k).torque_step);
        let shortest = shortest(most, &steps) * base_step;
        Brakes {
            pace,
            shortest,
            most,
            limits: std::array::from_fn(|k| config.limits(k).position()),
        }
    }

    /// Times [s] in which the axes brake: shorter than usual where they would leave their limits, whatever torque that
    /// takes.
    pub fn soonest(&self, theta: &Axes, rate: &Axes) -> Axes {
        within(theta, rate, &self.limits, (self.shortest, self.pace.brake), self.pace.base_step)
    }

    /// The same, as far as the largest torque goes by what the `model` says that a motion takes; None: it says nothing.
    pub fn times(
        &self,
        theta: &Axes,
        rate: &Axes,
        mut model: impl FnMut(&Motion) -> Option<Axes>,
    ) -> Axes {
        let (usual, times) = ([self.pace.brake; AXES], self.soonest(theta, rate));
        if times == usual {
            return usual;
        }
        match [usual, times].map(|times| model(&hardest(theta, rate, &times))) {
            [Some(begin), Some(end)] => {
                affordable(self.pace.brake, &times, [&begin, &end], self.most)
            }
            _ => times,
        }
    }

    /// From this pose at this rate to rest in these times, then to `to`.
    pub fn path(&self, theta: &Axes, rate: &Axes, times: Axes, to: &Axes) -> Path {
        Path::within(*theta, *rate, (times, &self.limits), *to, self.pace)
    }
}

/// Cycles of a brake whose torque grows to `most` by half of the `steps` [N m] that are allowed in a cycle, as the
/// feedback adds its own: it grows as 4 (s - s^2). A step of 0 is not judged.
fn shortest(most: f64, steps: &Axes) -> f64 {
    let judged = steps.iter().filter(|step| **step > 0.0);
    judged.fold(1.0, |cycles: f64, step| cycles.max(8.0 * most / step))
}

/// Times [s] in which axes at `theta` [rad] with `rate` [rad/s] come to rest within `limits` [rad], between
/// the `shortest` and the `longest` time: a brake has half of its first rate on average. They are whole cycles.
fn within(
    theta: &Axes,
    rate: &Axes,
    limits: &[(f64, f64); AXES],
    (shortest, longest): (f64, f64),
    base_step: f64,
) -> Axes {
    std::array::from_fn(|k| {
        let ((low, high), rate) = (limits[k], rate[k]);
        let left = if rate < 0.0 { low - theta[k] } else { high - theta[k] };
        if rate == 0.0 {
            return longest;
        }
        let cycles = (2.0 * left / rate / base_step).floor();
        (cycles * base_step).max(shortest).min(longest)
    })
}

/// The largest decelerations of brakes that take so many seconds, half-way, where the rates are half of the first.
fn hardest(theta: &Axes, rate: &Axes, times: &Axes) -> Motion {
    Motion {
        theta: *theta,
        thetad: rate.map(|rate| rate / 2.0),
        thetadd: std::array::from_fn(|k| -PEAK * rate[k] / times[k]),
    }
}

/// Times from `usual` down to `soon` [s] in which no torque is above `most` [N m]. Torques are affine in the
/// accelerations, so the `torques` of the one and the other say how far it can go.
fn affordable(usual: f64, soon: &Axes, torques: [&Axes; 2], most: f64) -> Axes {
    let share = (0..AXES).fold(1.0, |share: f64, k| {
        let (begin, more) = (torques[0][k], torques[1][k] - torques[0][k]);
        let room = if more < 0.0 { most + begin } else { most - begin };
        share.min((room / more.abs()).max(0.0))
    });
    // accelerations go as the inverse of the time
    let longer = |time: f64| time * (1.0 - share) / (time + share * (usual - time));
    soon.map(|time| time + (usual - time) * longer(time))
}

#[cfg(test)]
#[path = "brake_tests.rs"]
mod tests;
