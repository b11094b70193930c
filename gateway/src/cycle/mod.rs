//! The frame loop: wait, exchange, judge, compute, record. It allocates nothing.

mod outcome;
mod row;
pub mod signals;
mod timing;

use flexhex_system::Controller;
use std::sync::atomic::{AtomicI64, AtomicU64, Ordering};
use std::time::Duration;

pub use outcome::{Ending, Outcome};
pub use signals::Signals;
pub use timing::{Clock, Histogram};

use crate::bus::cia402::{self, State};
use crate::bus::{Bus, Reply};
use crate::config::{Config, AXES};
use crate::realtime::{now_ns, stop};
use crate::record::Sink;
use crate::safety::{Kind, Measured, Reaction, Reason, Safety};
use crate::wire::Link;

/// Cycles without any reply after which a reaction gives up: the watchdog has acted long ago.
const DEAF: u32 = 40;
const NANOSECONDS: f64 = 1e9;

/// What a run is asked to do.
#[derive(Clone, Debug)]
pub struct Wanted {
    pub cycles: i64,
    pub dry_run: bool,
    pub lockstep: bool,
    pub reset_faults: bool,
}

/// Read by whoever shows the run while it goes on.
#[derive(Default)]
pub struct Pulse {
    pub cycle: AtomicI64,
    pub lost: AtomicU64,
    /// Largest following error of this moment [nrad].
    pub error_nrad: AtomicU64,
}

enum Phase {
    Arming(u64),
    Running,
    Stopping(Reaction),
}

/// Everything that a cycle touches.
pub struct Machine<'a, L: Link> {
    config: &'a Config,
    wanted: Wanted,
    bus: Bus<L>,
    controller: Controller,
    signals: Signals,
    safety: Safety,
    clock: Clock,
    sink: Sink,
    pulse: &'a Pulse,
    phase: Phase,
    row: Vec<f64>,
    out: Outcome,
    sent: [f64; AXES],
    deaf: u32,
    stopped_for: u32,
}

impl<'a, L: Link> Machine<'a, L> {
    pub fn new(
        config: &'a Config,
        wanted: Wanted,
        bus: Bus<L>,
        (controller, signals): (Controller, Signals),
        (sink, width): (Sink, usize),
        (pulse, base_step): (&'a Pulse, f64),
    ) -> Self {
        let cycle = Duration::from_nanos((base_step * NANOSECONDS).round() as u64);
        let spin = Duration::from_micros(config.real_time.spin_us.into());
        let powered = !wanted.dry_run;
        Machine {
            safety: Safety::new(config, base_step, bus.complete(), powered),
            clock: Clock::new(cycle, spin, wanted.lockstep),
            phase: if powered {
                Phase::Arming(0)
            } else {
                Phase::Running
            },
            row: vec![0.0; width],
            out: Outcome::new(),
            sent: [0.0; AXES],
            deaf: 0,
            stopped_for: 0,
            config,
            wanted,
            bus,
            controller,
            signals,
            sink,
            pulse,
        }
    }

    /// From disabled drives to disabled drives.
    pub fn run(mut self) -> Outcome {
        while !self.cycle() {}
        self.out.cycles = self.controller.now();
        self.out.skipped = self.clock.skipped;
        self.out.late_threads = self.controller.late();
        self.out.overflowed = self.sink.overflowed();
        self.out.counts = self.bus.leave();
        self.out
    }

    /// One cycle; true when the drives are disabled and nothing is left to do.
    fn cycle(&mut self) -> bool {
        let (begin, late_ns) = self.clock.wait();
        let (tau, words) = self.outputs();
        self.bus.write(&tau, &words);
        self.sent = tau;
        let deadline = begin + self.patience_ns();
        let reply = *self.bus.exchange(deadline);
        let round_trip = now_ns() - begin;
        if let Some(phase) = reply.phase_ns {
            self.clock.steer(phase);
        }
        self.deaf = if reply.answered { 0 } else { self.deaf + 1 };
        if let Phase::Arming(tries) = self.phase {
            if !self.armed(&reply, tries) {
                return false;
            }
        }
        if let Phase::Stopping(reaction) = &self.phase {
            let over = reaction.over(&reply.statusword);
            let disabled = reply.answered && over;
            self.stopping(&reply);
            if disabled && self.out.to_disabled.is_none() {
                self.out.to_disabled = Some(self.stopped_for);
            }
            return over || self.deaf >= DEAF;
        }
        self.out.timing.wake_up.add(late_ns);
        if reply.answered {
            self.out.timing.round_trip.add(round_trip);
        }
        self.running(&reply, late_ns, round_trip);
        false
    }

    fn patience_ns(&self) -> u64 {
        let b = &self.config.bus;
        match self.wanted.lockstep {
            true => u64::from(b.lockstep_timeout_ms) * 1_000_000,
            false => u64::from(b.reply_timeout_us) * 1000,
        }
    }

    /// Torque and controlword of the next frame.
    fn outputs(&mut self) -> ([f64; AXES], [u16; AXES]) {
        let mut tau = [0.0; AXES];
        tau.copy_from_slice(&self.controller.command()[..AXES]);
        match &mut self.phase {
            Phase::Running if self.wanted.dry_run => ([0.0; AXES], [cia402::DISABLE_VOLTAGE; AXES]),
            Phase::Running => (tau, [cia402::ENABLE_OPERATION; AXES]),
            Phase::Arming(_) => {
                let now = self.bus.reply().statusword.map(cia402::state);
                let reset = self.wanted.reset_faults;
                let word = |s| match s {
                    State::Fault if reset => cia402::FAULT_RESET,
                    _ => cia402::towards_enabled(s),
                };
                (tau, now.map(word))
            }
            Phase::Stopping(reaction) => {
                let (tau, word) = reaction.next();
                (tau, [word; AXES])
            }
        }
    }

    /// Whether this reply is cycle 0: every drive is enabled. Refusals end the run.
    fn armed(&mut self, reply: &Reply, tries: u64) -> bool {
        self.phase = Phase::Arming(tries + 1);
        if !reply.answered {
            if self.deaf >= self.config.safety.lost_frame_limit {
                self.refuse(
                    "the drives stopped answering while they were being enabled".to_owned(),
                );
            }
            return false;
        }
        if tries == 0 {
            if let Some(why) = self.not_at_rest(reply) {
                self.refuse(why);
                return false;
            }
        }
        let states = reply.statusword.map(cia402::state);
        let faulty = states.iter().position(|s| *s == State::Fault);
        if let Some(axis) = faulty.filter(|_| !self.wanted.reset_faults || tries > 400) {
            let code = reply.error_code[axis];
            self.refuse(format!(
                "axis {}: fault {code:#06x} while enabling",
                axis + 1
            ));
            return false;
        }
        if stop::asked() {
            self.end(Ending::Asked, Reason::Stopped);
            return false;
        }
        if states.iter().all(|s| *s == State::OperationEnabled) {
            self.phase = Phase::Running;
            return true;
        }
        let most = u64::from(self.config.bus.state_timeout_ms) * 4;
        if tries > most {
            let words = states.map(State::words);
            self.refuse(format!("the drives do not become enabled: {words:?}"));
        }
        false
    }

    /// Why the machine must not be energised where it is.
    fn not_at_rest(&self, reply: &Reply) -> Option<String> {
        (0..AXES).find_map(|k| {
            let (l, theta) = (self.config.limits(k), reply.theta[k]);
            let r = self.controller.bus()[self.signals.r[k]];
            let (low, high) = (l.position_min, l.position_max);
            if !(theta >= low && theta <= high) {
                return Some(format!(
                    "axis {}: theta = {theta} rad, allowed {low} to {high} rad: move it by hand, or \
                     check drive[{k}].offset_counts and direction", k + 1
                ));
            }
            let far = (r - theta).abs() > l.following_error;
            far.then(|| {
                format!(
                    "axis {}: theta = {theta} rad, the reference begins at {r} rad, farther than {} rad: \
                     move it there by hand, or check drive[{k}].offset_counts", k + 1, l.following_error
                )
            })
        })
    }

    fn refuse(&mut self, why: String) {
        self.end(Ending::Refused(why), Reason::Stopped);
    }

    /// Begin the reaction; whatever comes later does not change the reason.
    fn end(&mut self, ending: Ending, reason: Reason) {
        // drives that were never all enabled are not led on to it by a ramp
        let kind = match self.phase {
            Phase::Running => self.config.reactions.to(reason),
            _ => Kind::Zero,
        };
        let per_ms = self.controller_steps_per_ms();
        let ramp = f64::from(self.config.safety.ramp_ms) * per_ms;
        let from = if self.wanted.dry_run {
            [0.0; AXES]
        } else {
            self.sent
        };
        self.phase = Phase::Stopping(Reaction::new(kind, from, ramp as u32));
        self.out.ending = ending;
    }

    fn controller_steps_per_ms(&self) -> f64 {
        1e-3 / self.safety.base_step()
    }

    /// A cycle of the controller: judge what was measured, compute what comes next.
    fn running(&mut self, reply: &Reply, late_ns: u64, round_trip_ns: u64) {
        let n = self.controller.now();
        let (r, e) = (self.pick(self.signals.r), self.pick(self.signals.e));
        self.fill(n, reply, late_ns, round_trip_ns);
        let begin = now_ns();
        let failure = self.controller.cycle(&reply.theta, &reply.tau).err();
        let compute = now_ns() - begin;
        self.out.timing.compute.add(compute);
        let controller = match &failure {
            Some(failure) => Some(signals::reason(failure)),
            None => self.untold_fault(),
        };
        let counters = (reply.answered, reply.working_counter == self.bus.complete());
        self.out.lost += u64::from(!counters.0);
        self.out.short += u64::from(counters.0 && !counters.1);
        let trip = self.safety.judge(&Measured {
            cycle: n,
            answered: reply.answered,
            working_counter: reply.working_counter,
            theta: &reply.theta,
            tau_meas: &reply.tau,
            tau: self.controller.command(),
            r: &r,
            e: &e,
            statusword: &reply.statusword,
            error_code: &reply.error_code,
            al_state: &reply.al_state,
            controller,
            overrun_us: if self.wanted.lockstep {
                0.0
            } else {
                late_ns as f64 / 1e3
            },
        });
        self.push(compute);
        self.tell(n, &e);
        if let Some(trip) = trip {
            let said = failure.map(|f| f.message).unwrap_or_default();
            let reason = trip.reason;
            self.end(Ending::Tripped(trip, said), reason);
        } else if stop::asked() {
            self.end(Ending::Asked, Reason::Stopped);
        } else if n + 1 >= self.wanted.cycles {
            self.end(Ending::Done, Reason::Stopped);
        }
    }

    /// The first fault output that does not only tell.
    fn untold_fault(&self) -> Option<(Reason, f64)> {
        let told = &self.config.safety.told_faults;
        let untold = |(name, value): &(&str, f64)| {
            !told.get(*name).is_some_and(|values| values.contains(value))
        };
        let first = self.controller.faults().find(untold)?;
        (!self.wanted.dry_run).then_some((Reason::FmuFault, first.1))
    }

    fn pick(&self, slots: [usize; AXES]) -> [f64; AXES] {
        slots.map(|slot| self.controller.bus()[slot])
    }

    fn tell(&mut self, n: i64, e: &[f64; AXES]) {
        let mut most: f64 = 0.0;
        for (seen, e) in self.out.most_error.iter_mut().zip(e) {
            *seen = seen.max(e.abs());
            most = most.max(e.abs());
        }
        self.pulse.cycle.store(n, Ordering::Relaxed);
        self.pulse.lost.store(self.out.lost, Ordering::Relaxed);
        self.pulse
            .error_nrad
            .store((most * 1e9) as u64, Ordering::Relaxed);
    }

    fn stopping(&mut self, reply: &Reply) {
        self.stopped_for += 1;
        if self.out.to_zero == 0 && self.sent.iter().all(|t| *t == 0.0) {
            self.out.to_zero = self.stopped_for;
        }
        let n = self.controller.now() - 1 + i64::from(self.stopped_for);
        self.fill(n, reply, 0, 0);
        self.push(0);
    }
}
