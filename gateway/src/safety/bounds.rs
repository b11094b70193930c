//! Limits that differ from one phase of a run to the next.

use super::{Safety, LONGEST};
use crate::config::{Config, Limits, AXES};

/// What differs from one phase of a run to the next.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// The drives are enabled: following error, frozen encoders and drive states are judged.
    pub powered: bool,
    /// Highest speed of each axis [rad/s].
    pub speed: [f64; AXES],
    /// Allowed angles of each axis [rad].
    pub low: [f64; AXES],
    pub high: [f64; AXES],
    /// Axes whose encoder is known to be wrong: their motion is not judged.
    pub blind: [bool; AXES],
}

impl Bounds {
    /// The limits of the configuration.
    pub fn of(config: &Config, powered: bool) -> Bounds {
        let by_axis = |value: fn(&Limits) -> f64| std::array::from_fn(|k| value(config.limits(k)));
        Bounds {
            powered,
            speed: by_axis(|l| l.speed),
            low: by_axis(|l| l.position_min),
            high: by_axis(|l| l.position_max),
            blind: [false; AXES],
        }
    }

    /// No speed above `most` [rad/s].
    pub fn slower(self, most: f64) -> Bounds {
        Bounds { speed: self.speed.map(|speed| speed.min(most)), ..self }
    }

    /// At least this speed and this range of angles are allowed, and `margin` [rad] beyond it.
    pub fn wider(self, speed: &[f64; AXES], poses: &[[f64; AXES]], margin: f64) -> Bounds {
        let mut wide = self;
        for k in 0..AXES {
            wide.speed[k] = wide.speed[k].max(speed[k].abs());
            for pose in poses {
                wide.low[k] = wide.low[k].min(pose[k] - margin);
                wide.high[k] = wide.high[k].max(pose[k] + margin);
            }
        }
        wide
    }
}

impl Safety {
    /// A phase of the run with bounds of its own begins.
    pub fn enter(&mut self, bounds: Bounds) {
        self.rules.bounds = bounds;
        self.still = [0; AXES];
    }

    /// Angles [rad] of a cycle before power: only their rate is judged then.
    pub fn note_rest(&mut self, theta: &[f64; AXES]) {
        self.past[self.seen % LONGEST] = *theta;
        self.seen += 1;
    }

    pub fn bounds(&self) -> &Bounds {
        &self.rules.bounds
    }

    /// Enough angles were seen for a mean speed.
    pub fn knows_rates(&self) -> bool {
        self.seen > self.rules.config.safety.speed_cycles.min(LONGEST as u32 - 1) as usize
    }

    /// Mean speed of each axis [rad/s] up to the newest cycle; 0 where it is not known.
    pub fn rates(&self) -> [f64; AXES] {
        let n = self.rules.config.safety.speed_cycles as usize;
        let n = n.min(LONGEST - 1);
        if !self.knows_rates() {
            return [0.0; AXES];
        }
        let then = |ago: usize| self.past[(self.seen - ago) % LONGEST];
        std::array::from_fn(|k| {
            let rate = (then(1)[k] - then(1 + n)[k]) / (n as f64 * self.rules.base_step);
            if rate.is_nan() {
                0.0
            } else {
                rate
            }
        })
    }
}
