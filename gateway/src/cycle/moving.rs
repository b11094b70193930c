//! Lift-off and landing: cycles in which the gateway moves the machine without the FMUs, and what ends
//! them.

use super::{ControlLoop, Ending, Phase};
use crate::bus::cia402;
use crate::bus::Reply;
use crate::config::AXES;
use crate::motion::{Mover, Path};
use crate::realtime::stop;
use crate::rules::{ReactionKind, Reason, Trip};
use crate::safety::{Bounds, Disabling, Measured};
use crate::wire::Link;

/// Distance [rad] within which the machine stands at a pose already.
const NEAR: f64 = 1e-3;

impl<L: Link> ControlLoop<'_, L> {
    /// All drives are enabled: lift off to where the reference starts. True where it is there already.
    pub(super) fn lift_off(&mut self, theta: &[f64; AXES]) -> bool {
        self.rest = *theta;
        let start = self.pick(self.signals.r);
        if (0..AXES).all(|k| (start[k] - theta[k]).abs() <= NEAR) {
            self.safety.enter(Bounds::of(self.config, true));
            return true;
        }
        let path = Path::new(*theta, [0.0; AXES], start, self.mechanics.pace);
        self.move_along(path, [false; AXES], &[0.0; AXES]);
        false
    }

    /// From this pose and rate to where the machine rested before it was enabled.
    pub(super) fn land(&mut self, blind: [bool; AXES]) {
        let (theta, mut rate) = (self.previous.theta, self.safety.history().rates());
        for k in (0..AXES).filter(|k| blind[*k]) {
            rate[k] = 0.0;
        }
        let path = Path::new(theta, rate, self.rest, self.mechanics.pace);
        self.move_along(path, blind, &rate);
    }

    fn move_along(&mut self, path: Path, blind: [bool; AXES], rate: &[f64; AXES]) {
        let margin = (0..AXES).fold(0.0, |m: f64, k| m.max(self.config.limits(k).following_error));
        let bounds = Bounds::of(self.config, true).slower(self.config.landing.speed_limit);
        // braking may begin above the limit of a landing: it must not become faster than it was by half
        let bounds = bounds.wider(
            &rate.map(|rate| 1.5 * rate),
            &[path.at(0), path.stop(), path.end()],
            margin,
        );
        self.safety.enter(Bounds { blind, ..bounds });
        let mut mover = Mover::new(self.mechanics, path, self.rest, blind);
        mover.step(&self.previous.theta, 0);
        self.phase = match self.phase {
            Phase::Arming(_) => Phase::Lifting(mover),
            _ => Phase::Landing(mover),
        };
    }

    /// A cycle of lift-off or landing: judge, then the torque of the next frame.
    pub(super) fn moving(&mut self, reply: &Reply, mut mover: Mover) {
        let lifting = matches!(self.phase, Phase::Lifting(_));
        let skipped = self.newly_skipped();
        let complete = reply.answered && reply.working_counter == self.bus.complete();
        let values = self.inputs.of(&Reply { answered: complete, ..*reply }, skipped);
        self.previous = values;
        mover.step(&values.theta, skipped);
        self.moved += 1;
        let n = if lifting { -i64::from(mover.left()) } else { self.after_end() };
        self.fill(n, reply, 0, 0);
        let trip = self.safety.judge(&Measured {
            cycle: n,
            skipped,
            answered: reply.answered,
            working_counter: reply.working_counter,
            theta: &reply.theta,
            tau_meas: &reply.tau,
            tau: &mover.tau,
            r: &mover.r,
            e: &mover.e,
            statusword: &reply.statusword,
            error_code: &reply.error_code,
            al_state: &reply.al_state,
            mode: &reply.mode,
            controller: None,
            overrun_us: 0.0,
        });
        self.push(0);
        let over = mover.left() == 0;
        self.phase = if lifting { Phase::Lifting(mover) } else { Phase::Landing(mover) };
        match trip {
            Some(trip) if lifting => {
                let reason = trip.reason;
                self.end(Ending::Tripped(trip, String::new()), reason);
            }
            Some(trip) => self.landing_failed(trip),
            None if lifting && stop::requested() => {
                self.end(Ending::StopRequested, Reason::Stopped)
            }
            None if stop::requested_twice() => self.take_power(ReactionKind::Zero),
            None if over && lifting => {
                self.safety.enter(Bounds::of(self.config, true));
                self.inputs = super::inputs::Inputs::default();
                self.phase = Phase::Running;
            }
            None if over => self.take_power(ReactionKind::Land),
            None => {}
        }
    }

    /// A rule is violated during a landing. An encoder that fails makes its axis blind, once; all else ends
    /// in category 0.
    fn landing_failed(&mut self, trip: Trip) {
        let kind = self.config.reactions.to(trip.reason);
        let first = self.out.landing_trip.is_none();
        self.out.landing_trip.get_or_insert(trip);
        if let (Phase::Landing(mover), Some(axis)) = (&mut self.phase, trip.axis) {
            if kind == ReactionKind::Damp && first && !mover.blind.contains(&true) {
                mover.blind[axis] = true;
                let blind = mover.blind;
                self.safety.enter(Bounds { blind, ..*self.safety.bounds() });
                return;
            }
        }
        self.take_power(if kind.lands() { ReactionKind::Zero } else { kind });
    }

    /// Zero torque from the next frame on; the drives are disabled.
    pub(super) fn take_power(&mut self, kind: ReactionKind) {
        self.phase = Phase::Disabling(Disabling::new(kind));
    }

    /// Controlword of an axis that moves. It must not lead a drive back to power.
    pub(super) fn kept_enabled(&self) -> [u16; AXES] {
        self.bus.reply().statusword.map(|word| match cia402::state(word) {
            cia402::State::OperationEnabled => cia402::ENABLE_OPERATION,
            _ => cia402::DISABLE_VOLTAGE,
        })
    }
}
