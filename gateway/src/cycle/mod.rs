//! The frame loop: wait, exchange, judge, compute, record. It allocates nothing.

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
use crate::safety::{Kind, Reaction, Reason, Safety};
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

/// What a run fills in, laid out before the drives are in OP: they do not wait for memory.
pub struct Blank {
    row: Vec<f64>,
    outcome: Outcome,
}

impl Blank {
    /// For recordings of so many columns.
    pub fn new(columns: usize) -> Self {
        Blank { row: vec![0.0; columns], outcome: Outcome::new() }
    }
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
    inputs: inputs::Inputs,
    /// What the controller took in the cycle before.
    taken: inputs::Values,
    skipped_before: u64,
    /// Cycles since cycle 0 that the clock left out and the controller did not make up for.
    missed: u64,
    stopped_for: u32,
}

impl<'a, L: Link> Machine<'a, L> {
    pub fn new(
        config: &'a Config,
        wanted: Wanted,
        bus: Bus<L>,
        (controller, signals): (Controller, Signals),
        (sink, out): (Sink, Blank),
        (pulse, base_step): (&'a Pulse, f64),
    ) -> Self {
        let cycle = Duration::from_nanos((base_step * NANOSECONDS).round() as u64);
        let spin = Duration::from_micros(config.real_time.spin_us.into());
        let powered = !wanted.dry_run;
        Machine {
            safety: Safety::new(config, base_step, bus.complete(), powered),
            clock: Clock::new(cycle, spin, wanted.lockstep),
            phase: if powered { Phase::Arming(0) } else { Phase::Running },
            row: out.row,
            out: out.outcome,
            sent: [0.0; AXES],
            deaf: 0,
            inputs: inputs::Inputs::default(),
            taken: inputs::Values::default(),
            skipped_before: 0,
            missed: 0,
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
        let (counts, code) = self.bus.leave(self.out.axis_with_fault());
        self.out.counts = counts;
        self.out.set_error_code(code);
        self.out
    }

    /// One cycle; true when the drives are disabled and nothing is left to do.
    fn cycle(&mut self) -> bool {
        let (begin, late_ns) = self.clock.wait();
        let (tau, words) = self.outputs();
        self.bus.write(&tau, &words);
        self.sent = tau;
        // a late cycle waits less: the next one is not to be late too
        let patience = self.patience_ns();
        let deadline = begin + patience - late_ns.min(patience / 2);
        let reply = *self.bus.exchange(deadline);
        let arrived = now_ns();
        let round_trip = arrived - begin;
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
        self.out.timing.after_reply.add(now_ns() - arrived);
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
                let (tau, word) = reaction.next(&self.bus.reply().statusword);
                (tau, [word; AXES])
            }
        }
    }

    /// Begin the reaction; whatever comes later does not change the reason.
    fn end(&mut self, ending: Ending, reason: Reason) {
        // drives that were never all enabled are not led on to it by a ramp
        let kind = match self.phase {
            Phase::Running if !self.wanted.dry_run => self.config.reactions.to(reason),
            _ => Kind::Zero,
        };
        let per_ms = self.controller_steps_per_ms();
        let ramp = f64::from(self.config.safety.ramp_ms) * per_ms;
        let from = if self.wanted.dry_run { [0.0; AXES] } else { self.sent };
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
