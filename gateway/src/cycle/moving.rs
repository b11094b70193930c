//! Lift-off and landing: cycles in which the gateway moves the machine without the controller, and what ends
//! them.

use flexhex_system::Motion;

use super::given::Given;
use super::{ControlLoop, Ending, Phase};
use crate::bus::cia402;
use crate::bus::Reply;
use crate::config::AXES;
use crate::motion::{Brakes, Mover};
use crate::realtime::stop;
use crate::rules::{ReactionKind, Reason, Trip};
use crate::safety::{in_landing, Bounds, Disabling, InLanding, Measured};
use crate::tasks::Leg;
use crate::wire::Link;

/// Distance [rad] within which the machine stands at a pose already.
const NEAR: f64 = 1e-3;

impl<L: Link> ControlLoop<'_, L> {
    /// All drives are enabled: lift off to where the reference starts. True where it is there already.
    pub(super) fn lift_off(&mut self, theta: &[f64; AXES]) -> bool {
        self.rest = *theta;
        self.given = Given::at(theta);
        let first = self.task.begin(theta);
        let start = self.pick(self.signals.r);
        if first.is_none() && (0..AXES).all(|k| (start[k] - theta[k]).abs() <= NEAR) {
            self.safety.begin(Bounds::of(self.config, true), self.sent);
            return true;
        }
        let leg = first.unwrap_or(Leg::new(*theta, start));
        let (path, blind) = (leg.path(self.mechanics.pace), [!self.task.feeds_back(); AXES]);
        self.safety.enter(self.leg_bounds(&leg));
        let mut mover = Mover::new(self.mechanics, path, self.rest, blind);
        mover.step(&self.previous.theta, 0);
        self.phase = Phase::Lifting(mover);
        false
    }

    /// From this pose and rate to where the machine rested before it was enabled.
    pub(super) fn land(&mut self, blind: [bool; AXES]) {
        let (theta, mut rate) = (self.previous.theta, self.safety.history().rates());
        for k in (0..AXES).filter(|k| blind[*k]) {
            rate[k] = 0.0;
        }
        let mut brakes = Brakes::of(self.config, self.mechanics.pace.base_step);
        if blind.contains(&true) {
            // one leg sinks already: the others follow at once
            brakes.pace.pause = 0.0;
        }
        let times = brakes.times(&theta, &rate, |motion| self.modelled(motion));
        let shorter = |time: &f64| *time < brakes.pace.brake - brakes.pace.base_step;
        self.out.brakes = times.map(|time| Some(time).filter(shorter));
        let path = brakes.path(&theta, &rate, times, &self.rest);
        self.out.passed = path.goes_back();
        let bounds = self.moving_bounds(&[path.at(0), path.stop(), path.end()], &rate);
        self.safety.enter(Bounds { blind, ..bounds });
        let mut mover = Mover::new(self.mechanics, path, self.rest, blind);
        let expected = self.expected(&theta, &rate);
        mover.model = self.modelled(&mover.motion()).filter(|_| expected.is_some());
        mover.begin_with(&self.given.tau, &expected.unwrap_or_else(|| mover.holding()));
        // without a fault the sums of the errors still hold: no step of the torque
        if let (Phase::Lifting(before), Ending::Done | Ending::StopRequested) =
            (&self.phase, &self.out.ending)
        {
            mover = *before;
            mover.follow(path);
            mover.most = [self.mechanics.torque; AXES];
        }
        mover.step(&self.previous.theta, 0);
        self.phase = Phase::Landing(mover);
    }

    /// Limits of a motion through these poses that begins at this rate.
    pub(super) fn moving_bounds(&self, poses: &[[f64; AXES]], rate: &[f64; AXES]) -> Bounds {
        let margin = (0..AXES).fold(0.0, |m: f64, k| m.max(self.config.limits(k).following_error));
        let bounds = Bounds::of(self.config, true).slower(self.config.landing.speed_limit);
        // braking may begin above the limit of a landing: it must not become faster than it was by half
        bounds.wider(&rate.map(|rate| 1.5 * rate), poses, margin)
    }

    /// A cycle of lift-off or landing: judge, then the torque of the next frame.
    pub(super) fn moving(
        &mut self,
        reply: &Reply,
        mut mover: Mover,
        (late_ns, round_trip_ns): (u64, u64),
    ) {
        let lifting = matches!(self.phase, Phase::Lifting(_));
        let skipped = self.newly_skipped();
        let complete = reply.answered && reply.working_counter == self.bus.complete();
        let values = self.inputs.of(&Reply { answered: complete, ..*reply }, skipped);
        self.previous = values;
        if mover.model.is_some() {
            // what was known last is better than nothing
            mover.model = self.modelled(&mover.motion()).or(mover.model);
        }
        mover.step(&values.theta, skipped);
        self.given.note(&values, self.mechanics.pace);
        self.moved += 1;
        self.out.lifted += u64::from(lifting);
        let n = if lifting { -i64::from(mover.left()) } else { self.after_end() };
        let gain = self.platform_gain(&values.theta, complete);
        self.fill(n, reply, late_ns, round_trip_ns);
        let trip = self.safety.judge(&Measured {
            cycle: n,
            skipped,
            answered: reply.answered,
            working_counter: reply.working_counter,
            theta: &reply.theta,
            tau_meas: &reply.tau,
            tau: &mover.tau,
            feedback: None,
            pose: &[],
            gain,
            r: &mover.r,
            e: &mover.e,
            statusword: &reply.statusword,
            error_code: &reply.error_code,
            al_state: &reply.al_state,
            mode: &reply.mode,
            controller: None,
            overrun_us: late_ns as f64 / 1e3,
        });
        self.push(0);
        let over = mover.left() == 0;
        self.phase = if lifting { Phase::Lifting(mover) } else { Phase::Landing(mover) };
        match trip {
            Some(trip) if lifting => {
                self.end(Ending::Tripped(trip, String::new()), trip.reason);
                return;
            }
            Some(trip) => self.landing_failed(trip),
            None => {}
        }
        if lifting && stop::requested() {
            self.end(Ending::StopRequested, Reason::Stopped);
        } else if lifting {
            self.guide(reply, complete);
        } else if matches!(self.phase, Phase::Landing(_)) && stop::at_once() {
            self.take_power(ReactionKind::Zero);
        } else if matches!(self.phase, Phase::Landing(_)) && over {
            self.take_power(ReactionKind::Land);
        }
    }

    /// What the model expects of the mean torques that were given, of a machine that moves so. It comes there on the way
    /// of the machine, as friction depends on it.
    fn expected(&mut self, theta: &[f64; AXES], rate: &[f64; AXES]) -> Option<[f64; AXES]> {
        let mean = self.given.motion(theta, rate, self.mechanics.pace.brake);
        let before = std::array::from_fn(|k| 2.0 * mean.theta[k] - theta[k]);
        self.modelled(&Motion { theta: before, ..mean });
        self.modelled(&mean)
    }

    /// The torques of a motion by the model, where there is one.
    fn modelled(&mut self, motion: &Motion) -> Option<[f64; AXES]> {
        self.workspace.as_mut()?.torques(motion)
    }

    /// A rule is violated during a landing: the first is told.
    fn landing_failed(&mut self, trip: Trip) {
        let Phase::Landing(mover) = &mut self.phase else { return };
        self.out.landing_trip.get_or_insert(trip);
        match in_landing(&trip, self.config.reactions.to(trip.reason), &mover.blind) {
            InLanding::GoOn => {}
            InLanding::Blind(axis) => {
                mover.blind[axis] = true;
                let blind = mover.blind;
                self.safety.enter(Bounds { blind, ..*self.safety.bounds() });
            }
            InLanding::TakePower(kind) => self.take_power(kind),
        }
    }

    /// Zero torque from the next frame on; the drives are disabled.
    pub(super) fn take_power(&mut self, kind: ReactionKind) {
        self.phase = Phase::Disabling(Disabling::new(kind));
    }

    /// Controlword of an axis that moves; of `but`: that is braked by its drive. It must not lead a drive back to power.
    pub(super) fn kept_enabled(&self, but: &[bool; AXES]) -> [u16; AXES] {
        let statusword = &self.bus.reply().statusword;
        std::array::from_fn(|k| match cia402::state(statusword[k]) {
            cia402::State::OperationEnabled if !but[k] => cia402::ENABLE_OPERATION,
            _ => cia402::DISABLE_VOLTAGE,
        })
    }
}
