//! Limits that differ from one phase of a run to the next.

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
    /// Largest following error of each axis [rad].
    pub following_error: [f64; AXES],
    /// Axes whose encoder or drive is known to be wrong, and has no power: their motion, the state of their drive and
    /// what it gives are not judged.
    pub blind: [bool; AXES],
    /// An axis may be held by its end stop: constant counts are no fault.
    pub may_stand: bool,
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
            following_error: by_axis(|l| l.following_error),
            blind: [false; AXES],
            may_stand: false,
        }
    }

    /// No speed above `most` [rad/s].
    pub fn slower(self, most: f64) -> Bounds {
        Bounds { speed: self.speed.map(|speed| speed.min(most)), ..self }
    }

    /// No following error above `most` [rad].
    pub fn closer(self, most: f64) -> Bounds {
        let following_error = self.following_error.map(|error| error.min(most));
        Bounds { following_error, ..self }
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
