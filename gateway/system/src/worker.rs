//! One FMU in a thread of its own. It is fed at its tick and steps while the cycles go on; its
//! outputs are taken one period later, so the timing rule holds whatever time the step takes.
//!
//! The hand-over is one atomic number that says whose turn it is: the cycle's side allocates
//! nothing, never blocks and makes no system call (waking a thread takes 20 us on some machines, so
//! the thread looks for itself). The mutex is never contended, as only the side whose turn it is
//! locks it: it is there so that the compiler checks the claim.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::error::Error;
use crate::executor::Executor;
use crate::snapshot;
use crate::unit::Unit;

/// Called in a new thread before it does anything, with the component's name: priority, CPU.
pub type ThreadHook = Arc<dyn Fn(&str) + Send + Sync>;

/// The cycle's turn: no step requested yet, or the step is done.
const DONE: u8 = 0;
/// The thread's turn.
const STEP: u8 = 1;
/// The cycle's turn: the FMU refused a call.
const FAILED: u8 = 2;
/// The thread is to end.
const END: u8 = 3;
/// Pause between two polls while waiting for a late thread.
const PAUSE: Duration = Duration::from_micros(20);
/// Polls of an idle thread in one period of its FMU.
const LOOKS: f64 = 32.0;
/// Longest wait for a thread that hangs in its FMU before it is abandoned.
const FAREWELL: Duration = Duration::from_secs(2);

/// State shared between cycle and thread.
struct Shared {
    turn: AtomicU8,
    state: Mutex<State>,
}

/// Belongs to whose turn it is.
struct State {
    executor: Executor,
    /// Base steps that the FMU has done: its own time, as ticks may be left out.
    now: i64,
    period: i64,
}

pub(crate) enum Outcome {
    Done,
    Failed(String),
    Late,
}

/// Handle of the cycle's side.
pub(crate) struct Worker {
    pub name: String,
    pub period: i64,
    /// Slots of the common bus that feed it.
    sources: Vec<usize>,
    /// Slots of the common bus that it writes.
    pub slots: std::ops::Range<usize>,
    /// It is fed from this base step on.
    first: i64,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// unit: with slots of the common bus; inside, the FMU has a small bus of its own.
    /// resume: state and base steps done of an earlier run; before `first` it then shows its outputs
    /// of that run and is not fed.
    pub fn open(
        mut unit: Unit,
        base: f64,
        hook: Option<ThreadHook>,
        resume: Option<(&[u8], i64)>,
        first: i64,
    ) -> Result<Worker, Error> {
        let own_slots = (0..unit.sources.len()).collect();
        let sources = std::mem::replace(&mut unit.sources, own_slots);
        let slots = unit.slot..unit.slot + unit.outputs.len();
        let (name, period) = (unit.name.clone(), unit.period);
        unit.slot = sources.len();
        let n_slots = sources.len() + unit.outputs.len();
        let mut executor = Executor::open(vec![unit], n_slots, base)?;
        if let Some((bytes, _)) = resume {
            snapshot::restore(&mut executor, 0, bytes).map_err(|e| e.at(&name))?;
        }
        let now = resume.map_or(0, |(_, steps)| steps);
        let shared = Arc::new(Shared {
            turn: AtomicU8::new(DONE),
            state: Mutex::new(State { executor, now, period }),
        });
        if !lock(&shared).executor.publish(0, now) {
            return Err(Error::new(lock(&shared).executor.message()));
        }
        let (theirs, title) = (Arc::clone(&shared), name.clone());
        let pause = Duration::from_secs_f64(period as f64 * base / LOOKS);
        let thread = thread::Builder::new()
            .name(format!("fmu {name}"))
            .spawn(move || {
                if let Some(hook) = hook {
                    hook(&title);
                }
                serve(&theirs, pause);
            })
            .map_err(|e| Error::new(format!("{name}: a thread cannot be started ({e})")))?;
        Ok(Worker { name, period, sources, slots, first, shared, thread: Some(thread) })
    }

    /// Whether the last step is over, within `wait`.
    pub fn finished(&self, wait: Duration) -> Outcome {
        let mut turn = self.shared.turn.load(Ordering::Acquire);
        if turn == STEP && !wait.is_zero() {
            let begin = Instant::now();
            while turn == STEP && begin.elapsed() < wait {
                thread::sleep(PAUSE);
                turn = self.shared.turn.load(Ordering::Acquire);
            }
        }
        match turn {
            STEP => Outcome::Late,
            FAILED => Outcome::Failed(lock(&self.shared).executor.message()),
            _ => Outcome::Done,
        }
    }

    /// Outputs to the common bus unless `refused` finds a reason; only when finished.
    pub fn take<T>(&self, bus: &mut [f64], refused: impl FnOnce(&[f64]) -> Option<T>) -> Option<T> {
        let state = lock(&self.shared);
        let values = &state.executor.bus()[self.sources.len()..];
        let why = refused(values);
        if why.is_none() {
            bus[self.slots.clone()].copy_from_slice(values);
        }
        why
    }

    /// Inputs of n from the common bus, and off it goes; does nothing while it is late, or before it is
    /// to begin.
    pub fn start(&self, n: i64, bus: &[f64]) {
        if n < self.first || self.shared.turn.load(Ordering::Acquire) != DONE {
            return;
        }
        let mut state = lock(&self.shared);
        let inputs = state.executor.bus_mut().iter_mut();
        for (input, source) in inputs.zip(&self.sources) {
            *input = bus[*source];
        }
        drop(state);
        self.shared.turn.store(STEP, Ordering::Release);
    }
}

impl Worker {
    /// State of the FMU as bytes, and the base steps that it has done; None while it steps.
    pub fn save(&self) -> Option<Result<(Vec<u8>, i64), Error>> {
        if self.shared.turn.load(Ordering::Acquire) != DONE {
            return None;
        }
        let mut state = lock(&self.shared);
        let now = state.now;
        Some(snapshot::save(&mut state.executor, 0).map(|bytes| (bytes, now)))
    }

    /// Its outputs; only when finished.
    pub fn outputs(&self) -> Vec<f64> {
        lock(&self.shared).executor.bus()[self.sources.len()..].to_vec()
    }
}

impl Drop for Worker {
    /// Ends the thread. A thread that hangs in its FMU is abandoned with all that it uses.
    fn drop(&mut self) {
        let Some(thread) = self.thread.take() else {
            return;
        };
        self.shared.turn.store(END, Ordering::Release);
        let begin = Instant::now();
        while !thread.is_finished() && begin.elapsed() < FAREWELL {
            thread::sleep(PAUSE);
        }
        if thread.is_finished() {
            let _ = thread.join();
        }
    }
}

/// The thread's side: steps when it is its turn, looks whether it is after every pause.
fn serve(shared: &Shared, pause: Duration) {
    loop {
        match shared.turn.load(Ordering::Acquire) {
            STEP => {
                let done = lock(shared).step();
                let next = if done { DONE } else { FAILED };
                // END may have been asked for meanwhile: then it stays
                let _ =
                    shared.turn.compare_exchange(STEP, next, Ordering::AcqRel, Ordering::Acquire);
            }
            END => return,
            _ => thread::sleep(pause),
        }
    }
}

impl State {
    fn step(&mut self) -> bool {
        let (now, next) = (self.now, self.now + self.period);
        self.now = next;
        let executor = &mut self.executor;
        executor.feed(0, now) && executor.advance(0, now) && executor.publish(0, next)
    }
}

fn lock(shared: &Shared) -> MutexGuard<'_, State> {
    shared.state.lock().unwrap_or_else(PoisonError::into_inner)
}
