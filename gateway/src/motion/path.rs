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
    /// Where the axes pause, and where they go from there.
    stand: Angles,
    to: Angles,
    /// Cycles in which each axis brakes, and in which it goes from there to where it pauses.
    brake: [u32; AXES],
    back: [u32; AXES],
    /// Cycles of each part.
    stopping: u32,
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
        let anywhere = [(f64::NEG_INFINITY, f64::INFINITY); AXES];
        Path::within(from, rate, ([pace.brake; AXES], &anywhere), to, pace)
    }

    /// The same with axes that brake in `times` [s] and go back where that ends outside `limits` [rad].
    pub fn within(
        from: Angles,
        rate: Angles,
        (times, limits): (Angles, &[(f64, f64); AXES]),
        to: Angles,
        pace: Pace,
    ) -> Path {
        let cycles = |time: f64| (time / pace.base_step).round() as u32;
        // a way of a few cycles would take an acceleration that no axis gives
        let moving = |far: f64| match (PEAK * far / pace.speed / pace.base_step).ceil() as u32 {
            0 => 0,
            least => least.max(cycles(pace.brake)),
        };
        let still = rate.iter().all(|rate| *rate == 0.0);
        let mut path = Path {
            from,
            rate,
            stand: from,
            to,
            brake: times.map(|time| if still { 0 } else { cycles(time) }),
            back: [0; AXES],
            stopping: 0,
            pause: if still { 0 } else { cycles(pace.pause) },
            travel: 0,
            wait: cycles(pace.pause),
            base_step: pace.base_step,
        };
        let stop = path.stop();
        if !still {
            path.stand = std::array::from_fn(|k| stop[k].clamp(limits[k].0, limits[k].1));
            path.back = std::array::from_fn(|k| moving((path.stand[k] - stop[k]).abs()));
        }
        path.stopping = (0..AXES).fold(0, |most, k| most.max(path.brake[k] + path.back[k]));
        path.travel = moving((0..AXES).fold(0.0, |far, k| far.max((to[k] - path.stand[k]).abs())));
        path
    }

    /// Where braking ends.
    pub fn stop(&self) -> Angles {
        std::array::from_fn(|k| {
            let time = f64::from(self.brake[k]) * self.base_step;
            self.from[k] + self.rate[k] * time / 2.0
        })
    }

    /// Axes that come to rest outside their limits, and go back.
    pub fn goes_back(&self) -> [bool; AXES] {
        self.back.map(|cycles| cycles > 0)
    }

    /// Cycles until it stands where it pauses.
    pub fn braking(&self) -> u32 {
        self.stopping
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
        self.stopping + self.pause + self.travel + self.wait
    }

    /// Positions in cycle k [rad].
    pub fn at(&self, k: u32) -> Angles {
        if k < self.stopping {
            return std::array::from_fn(|axis| self.stopping(axis, k));
        }
        let moved = k.saturating_sub(self.stopping + self.pause);
        if moved >= self.travel {
            return self.to;
        }
        let share = smooth(f64::from(moved) / f64::from(self.travel));
        let stand = self.stand;
        std::array::from_fn(|axis| stand[axis] + (self.to[axis] - stand[axis]) * share)
    }

    /// The same of an axis that brakes, or goes from there to where it pauses.
    fn stopping(&self, axis: usize, k: u32) -> f64 {
        let (brake, back) = (self.brake[axis], self.back[axis]);
        if k < brake {
            let time = f64::from(brake) * self.base_step;
            let s = f64::from(k) / f64::from(brake);
            // the rate falls as 1 - 3 s^2 + 2 s^3
            let share = s - s * s * s + s * s * s * s / 2.0;
            return self.from[axis] + self.rate[axis] * time * share;
        }
        let (stop, stand) = (self.stop()[axis], self.stand[axis]);
        if k - brake >= back {
            return stand;
        }
        stop + (stand - stop) * smooth(f64::from(k - brake) / f64::from(back))
    }
}

/// From 0 to 1, with rate and acceleration 0 at both ends.
fn smooth(s: f64) -> f64 {
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}
