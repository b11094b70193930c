//! A planned motion of all axes: brake, pause, move to a pose, wait there.

use flexhex_system::Motion;

use crate::config::{Landing, AXES};

type Angles = [f64; AXES];

/// Highest speed of `smooth` over its mean speed.
const PEAK: f64 = 1.875;

/// Positions by cycle, without a step in position or rate.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    from: Angles,
    rate: Angles,
    to: Angles,
    /// Cycles until each axis stands, and those of each part.
    brakes: [u32; AXES],
    brake: u32,
    pause: u32,
    travel: u32,
    wait: u32,
    base_step: f64,
}

/// Times [s] and highest speed [rad/s] of a path.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    pub speed: f64,
    pub brake: f64,
    /// Between braking and moving, and at the end.
    pub pause: f64,
    pub base_step: f64,
}

impl Pace {
    /// That of lift-off and landing.
    pub fn of(landing: &Landing, base_step: f64) -> Pace {
        Pace {
            speed: landing.speed,
            brake: f64::from(landing.brake_ms) * 1e-3,
            pause: f64::from(landing.hold_ms) * 1e-3,
            base_step,
        }
    }
}

impl Path {
    /// From `from` [rad] at `rate` [rad/s] to `to` at rest.
    pub fn new(from: Angles, rate: Angles, to: Angles, pace: Pace) -> Path {
        Path::braking_in(from, rate, [pace.brake; AXES], to, pace)
    }

    /// The same with axes that brake in `times` [s].
    pub fn braking_in(
        from: Angles,
        rate: Angles,
        times: [f64; AXES],
        to: Angles,
        pace: Pace,
    ) -> Path {
        let cycles = |time: f64| (time / pace.base_step).round() as u32;
        let still = rate.iter().all(|rate| *rate == 0.0);
        let brakes = times.map(|time| if still { 0 } else { cycles(time) });
        let mut path = Path {
            from,
            rate,
            to,
            brakes,
            brake: brakes.into_iter().fold(0, u32::max),
            pause: if still { 0 } else { cycles(pace.pause) },
            travel: 0,
            wait: cycles(pace.pause),
            base_step: pace.base_step,
        };
        let stop = path.stop();
        let far = (0..AXES).fold(0.0, |far: f64, k| far.max((to[k] - stop[k]).abs()));
        path.travel = (PEAK * far / pace.speed / pace.base_step).ceil() as u32;
        if path.travel > 0 {
            // a way of a few cycles would take an acceleration that no axis gives
            path.travel = path.travel.max(cycles(pace.brake));
        }
        path
    }

    /// Where braking ends.
    pub fn stop(&self) -> Angles {
        std::array::from_fn(|k| {
            let time = f64::from(self.brakes[k]) * self.base_step;
            self.from[k] + self.rate[k] * time / 2.0
        })
    }

    /// Cycles until it stands there.
    pub fn braking(&self) -> u32 {
        self.brake
    }

    /// Angles, rates and accelerations of the cycle after k, by differences.
    pub fn motion(&self, k: u32) -> Motion {
        let (before, theta, after) = (self.at(k), self.at(k + 1), self.at(k + 2));
        let h = self.base_step;
        Motion {
            theta,
            thetad: std::array::from_fn(|k| (after[k] - before[k]) / (2.0 * h)),
            thetadd: std::array::from_fn(|k| (after[k] - 2.0 * theta[k] + before[k]) / (h * h)),
        }
    }

    pub fn end(&self) -> Angles {
        self.to
    }

    /// Cycles until all is over.
    pub fn cycles(&self) -> u32 {
        self.brake + self.pause + self.travel + self.wait
    }

    /// Positions in cycle k [rad].
    pub fn at(&self, k: u32) -> Angles {
        let stop = self.stop();
        if k < self.brake {
            return std::array::from_fn(|axis| match self.brakes[axis] {
                brake if k < brake => {
                    let time = f64::from(brake) * self.base_step;
                    let s = f64::from(k) / f64::from(brake);
                    // the rate falls as 1 - 3 s^2 + 2 s^3
                    let share = s - s * s * s + s * s * s * s / 2.0;
                    self.from[axis] + self.rate[axis] * time * share
                }
                _ => stop[axis],
            });
        }
        let moved = k.saturating_sub(self.brake + self.pause);
        if moved >= self.travel {
            return self.to;
        }
        let share = smooth(f64::from(moved) / f64::from(self.travel));
        std::array::from_fn(|axis| stop[axis] + (self.to[axis] - stop[axis]) * share)
    }
}

/// From 0 to 1, with rate and acceleration 0 at both ends.
fn smooth(s: f64) -> f64 {
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}
