//! Which poses the platform can take: reached, far from singular, within `[[pose]]`. A hexapod can leave its
//! workspace with every axis inside its limits.

use flexhex_system::{Dynamics, Error, Gain, Kinematics, Motion, System};

use crate::config::{Config, Homed, PoseLimit, AXES};
use crate::motion::Brakes;
use crate::obstacle::Obstacle;

type Axes = [f64; AXES];

/// Longest way between two poses that are judged [rad]: the gain hardly changes within it.
const STEP: f64 = 5e-3;
/// Parts of a brake at whose ends its torques are judged.
const PARTS: u32 = 16;

/// The platform's pose along the ways that are planned before the machine takes them.
pub struct Workspace {
    kinematics: Kinematics,
    neutral: Gain,
    most: f64,
    /// Limits of the pose, by the variable of the kinematics.
    limits: Vec<PoseLimit>,
    /// Axes judged of those that `watch` goes through, and their gain so far.
    watched: (usize, Gain),
    at: Axes,
    /// Where a landing leads from every pose, if that is known.
    rest: Option<Axes>,
    /// None: the system has no model that the reference alone feeds.
    dynamics: Option<Dynamics>,
    brakes: Brakes,
}

impl Workspace {
    /// It begins where the machine rests, if that is known, or else in the neutral pose. `purpose`: end of the names of
    /// its FMUs' instances, which no others have. None: the system has no kinematics of the reference.
    pub fn open(
        config: &Config,
        system: &System,
        purpose: &str,
    ) -> Result<Option<Workspace>, Error> {
        let (reference, feedforward) = (&config.system.reference, &config.system.feedforward);
        let Some(mut kinematics) = Kinematics::of(system, reference, purpose)? else {
            return Ok(None);
        };
        let at = [0.0; AXES];
        let neutral = kinematics.gain(&at)?.unwrap_or_default();
        // the pose that is wanted and the one that is measured have the same variables
        let mut limits = Vec::new();
        for limit in &config.pose {
            let signal = limit.signal.split_once('.').map_or("", |(_, variable)| variable);
            if kinematics.value(signal).is_some() {
                limits.push(PoseLimit { signal: signal.to_owned(), ..limit.clone() });
            }
        }
        let most = config.landing.platform_gain;
        let rest = config.landing.rest.or(config.homed.as_ref().and_then(Homed::rest));
        let at = rest.unwrap_or(at);
        Ok(Some(Workspace {
            kinematics,
            neutral,
            most,
            limits,
            watched: (0, Gain::default()),
            at,
            rest,
            dynamics: Dynamics::of(system, reference, feedforward, purpose)?,
            brakes: Brakes::of(config, system.base_step()),
        }))
    }

    /// The straight way from where it is, and the one on which a landing leads from there. It stays where it is if
    /// something is in the way.
    pub fn go(&mut self, to: &Axes) -> Result<(), Obstacle> {
        self.way(&self.at.clone(), to)?;
        if let Some(rest) = self.rest {
            self.way(to, &rest)?;
        }
        self.at = *to;
        Ok(())
    }

    /// Of poses along a motion: the gain over that in the neutral pose, as the largest of six calls, one for each axis; infinite where the platform cannot be. None before the sixth, and where the FMU fails.
    pub fn watch(&mut self, theta: &Axes) -> Option<f64> {
        let (axis, before) = self.watched;
        let Some(gain) = self.kinematics.gain_of(axis, theta).ok()? else {
            self.watched = (0, Gain::default());
            return Some(f64::INFINITY);
        };
        let gain = before.or_more(&gain);
        let whole = axis + 1 == AXES;
        self.watched = if whole { (0, Gain::default()) } else { (axis + 1, gain) };
        whole.then(|| over(&gain, &self.neutral))
    }

    /// The torques [N m] that a motion takes, by the model; None: there is no model, or the platform cannot be there.
    pub fn torques(&mut self, motion: &Motion) -> Option<Axes> {
        let torques = self.modelled(motion).ok()??;
        torques.iter().all(|torque| torque.is_finite()).then_some(torques)
    }

    fn modelled(&mut self, motion: &Motion) -> Result<Option<Axes>, Error> {
        self.dynamics.as_mut().map_or(Ok(None), |dynamics| dynamics.torque(motion))
    }

    /// Where a stop from a pose [rad] and rate [rad/s] ends, if its torques suffice.
    pub fn stop(&self, theta: &Axes, rate: &Axes) -> Axes {
        let times = self.brakes.soonest(theta, rate);
        self.brakes.path(theta, rate, times, theta).stop()
    }

    /// The pose and the stop that may begin there, as a landing brakes: the pose in which it ends, and the torques that
    /// it takes.
    pub fn stops_from(&mut self, motion: &Motion) -> Result<(), Obstacle> {
        let (brakes, theta, rate) = (self.brakes, &motion.theta, &motion.thetad);
        self.judge(theta)?;
        let times = brakes.times(theta, rate, |motion| self.torques(motion));
        let path = brakes.path(theta, rate, times, theta);
        let stop = path.stop();
        for (axis, (angle, (low, high))) in stop.iter().zip(brakes.limits).enumerate() {
            if !(low..=high).contains(angle) {
                return Err(Obstacle::Position { axis, angle: *angle, low, high });
            }
        }
        self.gain(&stop)?;
        for part in 0..PARTS {
            let braking = path.motion(path.braking() * part / PARTS);
            let Some(torques) = self.modelled(&braking).map_err(Obstacle::Failed)? else {
                continue;
            };
            let sizes = torques.map(f64::abs).into_iter().enumerate();
            let worst = sizes.max_by(|(_, one), (_, other)| one.total_cmp(other));
            let ((axis, needed), most) = (worst.unwrap_or((0, f64::NAN)), brakes.most);
            // a torque that is no number is none that a landing may give
            if needed.is_nan() || needed > most {
                return Err(Obstacle::Torque { at: braking.theta, axis, needed, most });
            }
        }
        Ok(())
    }

    fn way(&mut self, from: &Axes, to: &Axes) -> Result<(), Obstacle> {
        let far = (0..AXES).fold(0.0, |far: f64, k| far.max((to[k] - from[k]).abs()));
        let steps = (far / STEP).ceil().max(1.0) as u32;
        for step in 1..=steps {
            let share = f64::from(step) / f64::from(steps);
            self.judge(&std::array::from_fn(|k| from[k] + share * (to[k] - from[k])))?;
        }
        Ok(())
    }

    fn judge(&mut self, at: &Axes) -> Result<(), Obstacle> {
        self.gain(at)?;
        for limit in &self.limits {
            let value = self.kinematics.value(&limit.signal).unwrap_or(f64::NAN);
            if !limit.allows(value) {
                return Err(Obstacle::Limit { at: *at, limit: limit.clone(), value });
            }
        }
        Ok(())
    }

    fn gain(&mut self, at: &Axes) -> Result<(), Obstacle> {
        let gain = self.kinematics.gain(at).map_err(Obstacle::Failed)?;
        let gain = gain.ok_or(Obstacle::Unreachable(*at))?;
        let (there, most) = (over(&gain, &self.neutral), self.most);
        // also of what is no number
        let regular = there <= most;
        if !regular {
            return Err(Obstacle::Singular { at: *at, gain: there, most });
        }
        Ok(())
    }
}

/// The larger of both ratios.
fn over(gain: &Gain, neutral: &Gain) -> f64 {
    (gain.position / neutral.position).max(gain.orientation / neutral.orientation)
}
