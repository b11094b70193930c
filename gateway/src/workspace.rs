//! Which poses the platform can take: reached, far from singular, within `[[pose]]`. A hexapod can leave its
//! workspace with every axis inside its limits.

use flexhex_system::{Dynamics, Error, Gain, Kinematics, Motion, System};

use crate::config::{Config, Homed, PoseLimit, AXES};
use crate::motion::{Brakes, Path};
use crate::obstacle::Obstacle;

type Axes = [f64; AXES];

/// Longest way between two poses that are judged [rad]: the gain hardly changes within it.
const STEP: f64 = 5e-3;
/// Most steps of that size on the way to the pose in which the machine rests without torque.
const STEPS_DOWN: u32 = 400;
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
    /// Whether the way from the rest pose has been judged.
    lifted: bool,
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
            lifted: false,
            dynamics: Dynamics::of(system, reference, feedforward, purpose)?,
            brakes: Brakes::of(config, system.base_step()),
        }))
    }

    /// The straight way from where it is, and the one on which a landing leads from there. It stays where it is if
    /// something is in the way.
    pub fn go(&mut self, to: &Axes) -> Result<(), Obstacle> {
        let from = self.at;
        self.way(&from, to)?;
        if let Some(rest) = self.rest {
            self.way(to, &rest)?;
        }
        // the lift-off leads to the first pose; from there on the drives carry the machine
        if !self.lifted {
            self.lifts(to)?;
        }
        self.carries(&from, to)?;
        (self.at, self.lifted) = (*to, true);
        Ok(())
    }

    /// Whether the torque of a lift-off carries the machine from where it rests to a pose.
    pub fn lifts(&mut self, to: &Axes) -> Result<(), Obstacle> {
        let rest = self.rest.map_or_else(|| self.sunk(to), Ok)?;
        self.carries(&rest, to)
    }

    /// Where the machine comes to rest without torque from a pose, by the model. The torques that hold it are the slopes of
    /// its energy, so the way down goes against them.
    fn sunk(&mut self, from: &Axes) -> Result<Axes, Obstacle> {
        let (mut at, mut before, limits) = (*from, [0.0; AXES], self.brakes.limits);
        for _ in 0..STEPS_DOWN {
            let motion = Motion { theta: at, ..Motion::default() };
            let Some(torques) = self.modelled(&motion).map_err(Obstacle::Failed)? else { break };
            let most = torques.map(f64::abs).into_iter().fold(0.0, f64::max);
            let along: f64 = torques.iter().zip(before).map(|(now, before)| now * before).sum();
            let falls = most > 0.0 && along >= 0.0;
            if !falls {
                break;
            }
            at = std::array::from_fn(|k| {
                (at[k] - STEP * torques[k] / most).clamp(limits[k].0, limits[k].1)
            });
            before = torques;
        }
        Ok(at)
    }

    /// Whether the torque of a lift-off suffices on the planned path between two poses, by the model.
    fn carries(&mut self, from: &Axes, to: &Axes) -> Result<(), Obstacle> {
        let path = Path::new(*from, [0.0; AXES], *to, self.brakes.pace);
        let steps = steps(from, to);
        let (mut at, mut axis, mut needed) = (*to, 0, 0.0_f64);
        for step in 1..=steps {
            let motion = path.motion(path.cycles() * step / steps);
            let Some(torques) = self.modelled(&motion).map_err(Obstacle::Failed)? else {
                continue;
            };
            let (worst, torque) = largest(&torques);
            if torque.total_cmp(&needed).is_gt() {
                (at, axis, needed) = (motion.theta, worst, torque);
            }
        }
        let most = self.brakes.most;
        match needed <= most {
            true => Ok(()),
            false => Err(Obstacle::Weight { at, axis, needed, most }),
        }
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
            let ((axis, needed), most) = (largest(&torques), brakes.most);
            // a torque that is no number is none that a landing may give
            if needed.is_nan() || needed > most {
                return Err(Obstacle::Torque { at: braking.theta, axis, needed, most });
            }
        }
        Ok(())
    }

    fn way(&mut self, from: &Axes, to: &Axes) -> Result<(), Obstacle> {
        let steps = steps(from, to);
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

/// Steps of a straight way.
fn steps(from: &Axes, to: &Axes) -> u32 {
    let far = (0..AXES).fold(0.0, |far: f64, k| far.max((to[k] - from[k]).abs()));
    (far / STEP).ceil().max(1.0) as u32
}

/// The axis of the largest torque, and its size [N m]. One that is no number is above all others.
fn largest(torques: &Axes) -> (usize, f64) {
    let sizes = torques.map(f64::abs).into_iter().enumerate();
    let worst = sizes.max_by(|(_, one), (_, other)| one.total_cmp(other));
    worst.unwrap_or((0, f64::NAN))
}

/// The larger of both ratios.
fn over(gain: &Gain, neutral: &Gain) -> f64 {
    (gain.position / neutral.position).max(gain.orientation / neutral.orientation)
}
