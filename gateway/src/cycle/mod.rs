//! The control loop: wait, exchange, compute, judge, record. It allocates nothing.

mod arming;
mod inputs;
mod outcome;
mod row;
mod running;
pub mod signals;
mod timing;

use flexhex_system::Controller;
use std::sync::atomic::{AtomicI64, AtomicU64};
use std::time::Duration;

pub use outcome::{Ending, Outcome};
pub use signals::Signals;
pub use timing::{Clock, Histogram};

use crate::bus::cia402::{self, State};
use crate::bus::{Bus, Reply};
use crate::config::{Config, AXES};
use crate::realtime::now_ns;
use crate::record::Sink;
use crate::rules::{ReactionKind, Reason};
use crate::safety::{Reaction, Safety};
use crate::wire::Link;

/// Cycles without any reply after which a reaction ends: the watchdog of the drives has acted before.
const UNANSWERED_LIMIT: u32 = 40;
const NANOSECONDS: f64 = 1e9;

/// Options of a run.
#[derive(Clone, Debug)]
pub struct RunOptions {
    pub cycles: i64,
    pub dry_run: bool,
    pub lockstep: bool,
    pub reset_faults: bool,
}

/// Values for the status display, read by another thread.
#[derive(Default)]
pub struct LiveStatus {
    pub cycle: AtomicI64,
    pub lost: AtomicU64,
    /// Largest following error of the newest cycle [nrad].
    pub error_nrad: AtomicU64,
}

enum Phase {
    Arming(u64),
    Running,
    Stopping(Reaction),
}

/// Buffers that are allocated before the drives are in OP, as the loop must not allocate.
pub struct Preallocated {
    row: Vec<f64>,
    outcome: Outcome,
}

impl Preallocated {
    /// For recordings with this many columns.
    pub fn new(columns: usize) -> Self {
        Preallocated { row: vec![0.0; columns], outcome: Outcome::new() }
    }
}

/// The control loop with everything that a cycle uses.
pub struct ControlLoop<'a, L: Link> {
    config: &'a Config,
    options: RunOptions,
    bus: Bus<L>,
    controller: Controller,
    signals: Signals,
    safety: Safety,
    clock: Clock,
    sink: Sink,
    status: &'a LiveStatus,
    phase: Phase,
    row: Vec<f64>,
    out: Outcome,
    sent: [f64; AXES],
    unanswered: u32,
    inputs: inputs::Inputs,
    /// Inputs of the controller in the cycle before.
    previous: inputs::Values,
    skipped_before: u64,
    /// Cycles since cycle 0 that the clock skipped and the controller did not compute afterwards.
    missed: u64,
    stopped_for: u32,
}

impl<'a, L: Link> ControlLoop<'a, L> {
    pub fn new(
        config: &'a Config,
        options: RunOptions,
        bus: Bus<L>,
        (controller, signals): (Controller, Signals),
        (sink, out): (Sink, Preallocated),
        (status, base_step): (&'a LiveStatus, f64),
    ) -> Self {
        let cycle = Duration::from_nanos((base_step * NANOSECONDS).round() as u64);
        let spin = Duration::from_micros(config.real_time.spin_us.into());
        let powered = !options.dry_run;
        ControlLoop {
            safety: Safety::new(config, base_step, bus.complete(), powered),
            clock: Clock::new(cycle, spin, options.lockstep),
            phase: if powered { Phase::Arming(0) } else { Phase::Running },
            row: out.row,
            out: out.outcome,
            sent: [0.0; AXES],
            unanswered: 0,
            inputs: inputs::Inputs::default(),
            previous: inputs::Values::default(),
            skipped_before: 0,
            missed: 0,
            stopped_for: 0,
            config,
            options,
            bus,
            controller,
            signals,
            sink,
            status,
        }
    }

    /// The whole run, from disabled drives to disabled drives.
    pub fn run(mut self) -> Outcome {
        while !self.cycle() {}
        self.out.cycles = self.controller.now();
        self.out.skipped = self.clock.skipped;
        self.out.late_threads = self.controller.late();
        self.out.overflowed = self.sink.overflowed();
        let (counts, code) = self.bus.leave(self.out.axis_with_fault());
        self.out.counts = counts;
        self.out.set_error_code(code);
        self.out
    }

    /// One cycle; true when the run is over.
    fn cycle(&mut self) -> bool {
        let (begin, late_ns) = self.clock.wait();
        let (tau, controlwords) = self.outputs();
        self.bus.write(&tau, &controlwords);
        self.sent = tau;
        // a late cycle waits less, so that the next one is not late too
        let timeout = self.reply_timeout_ns();
        let deadline = begin + timeout - late_ns.min(timeout / 2);
        let reply = *self.bus.exchange(deadline);
        let arrived = now_ns();
        let round_trip = arrived - begin;
        if let Some(phase) = reply.phase_ns {
            self.clock.steer(phase);
        }
        self.unanswered = if reply.answered { 0 } else { self.unanswered + 1 };
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
            return over || self.unanswered >= UNANSWERED_LIMIT;
        }
        self.out.timing.wake_up.add(late_ns);
        if reply.answered {
            self.out.timing.round_trip.add(round_trip);
        }
        self.running(&reply, late_ns, round_trip);
        self.out.timing.after_reply.add(now_ns() - arrived);
        false
    }

    fn reply_timeout_ns(&self) -> u64 {
        let b = &self.config.bus;
        match self.options.lockstep {
            true => u64::from(b.lockstep_timeout_ms) * 1_000_000,
            false => u64::from(b.reply_timeout_us) * 1000,
        }
    }

    /// Torque and controlword of the next frame.
    fn outputs(&mut self) -> ([f64; AXES], [u16; AXES]) {
        let mut tau = [0.0; AXES];
        tau.copy_from_slice(&self.controller.command()[..AXES]);
        match &mut self.phase {
            Phase::Running if self.options.dry_run => {
                ([0.0; AXES], [cia402::DISABLE_VOLTAGE; AXES])
            }
            Phase::Running => (tau, [cia402::ENABLE_OPERATION; AXES]),
            Phase::Arming(_) => {
                let now = self.bus.reply().statusword.map(cia402::state);
                let reset = self.options.reset_faults;
                let word = |s| match s {
                    State::Fault if reset => cia402::FAULT_RESET,
                    _ => cia402::towards_enabled(s),
                };
                (tau, now.map(word))
            }
            Phase::Stopping(reaction) => {
                let (tau, word) = reaction.next(&self.bus.reply().statusword);
                (tau, [word; AXES])
            }
        }
    }

    /// Begin the reaction; later events do not change the reason.
    fn end(&mut self, ending: Ending, reason: Reason) {
        // a ramp would enable drives that are not yet enabled
        let kind = match self.phase {
            Phase::Running if !self.options.dry_run => self.config.reactions.to(reason),
            _ => ReactionKind::Zero,
        };
        let per_ms = self.controller_steps_per_ms();
        let ramp = f64::from(self.config.safety.ramp_ms) * per_ms;
        let from = if self.options.dry_run { [0.0; AXES] } else { self.sent };
        self.phase = Phase::Stopping(Reaction::new(kind, from, ramp as u32));
        self.out.ending = ending;
    }

    fn controller_steps_per_ms(&self) -> f64 {
        1e-3 / self.safety.base_step()
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
