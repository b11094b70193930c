//! The control loop: wait, exchange, compute, judge, record. It allocates nothing.

mod arming;
mod ending;
mod given;
mod guiding;
mod inputs;
mod moving;
mod outcome;
mod outputs;
mod refusal;
mod row;
mod running;
pub mod signals;
#[cfg(test)]
mod tests;
mod timing;

use flexhex_system::{Controller, Error, State};
use std::sync::atomic::Ordering;
use std::time::Duration;

pub use outcome::{Ending, Outcome};
pub use signals::Signals;
pub use timing::{Clock, Histogram};

use given::Given;

use crate::bus::Bus;
use crate::config::{Config, AXES};
use crate::live::Board;
use crate::motion::{Mechanics, Mover};
use crate::realtime::now_ns;
use crate::record::Sink;
use crate::safety::{Disabling, Safety};
use crate::tasks::Task;
use crate::wire::Link;
use crate::workspace::Workspace;

/// Cycles without any reply after which a reaction ends: the watchdog of the drives has acted before.
const UNANSWERED_LIMIT: u32 = 40;
const NANOSECONDS: f64 = 1e9;
/// Longest wait at the end for a step in a thread of its own.
const FAREWELL: Duration = Duration::from_secs(1);

/// Options of a run.
#[derive(Clone, Copy, Debug)]
pub struct RunOptions {
    pub cycles: i64,
    pub dry_run: bool,
    pub lockstep: bool,
    pub reset_faults: bool,
}

/// Lifting, landing and everything between are judged by the same rules (`safety`).
enum Phase {
    Arming(u64),
    Lifting(Mover),
    Running,
    Landing(Mover),
    Disabling(Disabling),
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

/// What computes: the FMUs, their signals, lift-off and landing, the platform.
pub type Parts = (Controller, Signals, Mechanics, Option<Workspace>);

/// The FMUs after a run, which are still open.
pub struct Fmus {
    controller: Controller,
    _workspace: Option<Workspace>,
}

impl Fmus {
    /// What the components with a thread of their own have learned, or why that is not known.
    pub fn states(&self) -> Vec<Result<State, Error>> {
        self.controller.save(FAREWELL)
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
    board: &'a Board,
    phase: Phase,
    row: Vec<f64>,
    out: Outcome,
    sent: [f64; AXES],
    unanswered: u32,
    inputs: inputs::Inputs,
    /// Values of the signals with limits of the pose.
    pose: Vec<f64>,
    /// Inputs of the controller in the cycle before.
    previous: inputs::Values,
    skipped_before: u64,
    mechanics: Mechanics,
    /// None: no kinematics, or the encoders are not homed.
    workspace: Option<Workspace>,
    /// Where the machine rested before it was enabled [rad].
    rest: [f64; AXES],
    given: Given,
    task: Task,
    /// Encoders that are not homed show 0 where the machine rests.
    zeroed: bool,
    /// Cycles of lift-off and landing so far.
    moved: u64,
    /// Cycles since cycle 0 that the clock skipped and the controller did not compute afterwards.
    missed: u64,
    /// Cycles for which some drives, but not all, have been enabled.
    partly_enabled: u32,
    stopped_for: u32,
    panicked: bool,
}

impl<'a, L: Link> ControlLoop<'a, L> {
    pub fn new(
        config: &'a Config,
        (options, task): (RunOptions, Task),
        bus: Bus<L>,
        (controller, signals, mechanics, workspace): Parts,
        (sink, out): (Sink, Preallocated),
        (board, base_step): (&'a Board, f64),
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
            pose: vec![0.0; signals.pose.len()],
            previous: inputs::Values::default(),
            skipped_before: 0,
            mechanics,
            workspace: workspace.filter(|_| task.is_homed()),
            rest: [0.0; AXES],
            given: Given::default(),
            zeroed: task.is_homed(),
            task,
            moved: 0,
            missed: 0,
            partly_enabled: 0,
            stopped_for: 0,
            panicked: false,
            config,
            options,
            bus,
            controller,
            signals,
            sink,
            board,
        }
    }

    /// The whole run, from disabled drives to disabled drives. What calls the FMUs again is left to be done when it
    /// has been reported.
    pub fn run(mut self) -> (Outcome, Fmus) {
        self.board.beating.store(true, Ordering::Relaxed);
        while !self.guarded_cycle() {
            self.board.beats.fetch_add(1, Ordering::Relaxed);
        }
        self.board.beating.store(false, Ordering::Relaxed);
        self.out.cycles = self.controller.now();
        self.out.skipped = self.clock.skipped;
        self.out.late_threads = self.controller.late();
        self.out.frozen = self.controller.frozen();
        self.out.shares = self.shares();
        self.out.overflowed = self.sink.overflowed();
        let left = self.bus.leave(self.out.open_questions(), &self.out.disabled);
        self.out.take(left);
        self.out.task = self.task;
        (self.out, Fmus { controller: self.controller, _workspace: self.workspace })
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
        let late_ns = late_ns + self.clock.skip(self.bus.stalled());
        if let Some(phase) = reply.phase_ns {
            self.clock.steer(phase);
        }
        self.unanswered = if reply.answered { 0 } else { self.unanswered + 1 };
        if let Phase::Arming(tries) = self.phase {
            if !self.armed(&reply, tries) {
                return false;
            }
        }
        match self.phase {
            Phase::Disabling(_) => return self.disabling(&reply),
            Phase::Lifting(mover) | Phase::Landing(mover) => {
                self.moving(&reply, mover, (late_ns, round_trip));
                return false;
            }
            _ => {}
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
}
