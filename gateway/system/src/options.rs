//! What a controller is opened with.

use std::time::Duration;

use crate::guard::Bounds;
use crate::state::State;
use crate::value::Value;
use crate::worker::ThreadHook;

/// Reaction to a component in its own thread that has not finished at its tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Late {
    /// `cycle` returns a `Trip`.
    #[default]
    Trip,
    /// Its outputs are kept; the tick is skipped and counted (`Controller::late`).
    Hold,
}

/// Options of a controller.
#[derive(Clone, Default)]
pub struct Options {
    /// Components with a thread of their own, such as the estimator `K`.
    pub own_thread: Vec<String>,
    /// Longest wait for a late one: zero by the clock, seconds in lockstep.
    pub wait: Duration,
    pub late: Late,
    /// With `Late::Hold`: more ticks than this in a row that one leaves out trip. None: any number.
    pub late_limit: Option<u32>,
    /// States of an earlier run for components with a thread of their own.
    pub resume: Vec<State>,
    /// Bounds of their estimates; one that leaves them is frozen (`Controller::frozen`).
    pub bounds: Option<Bounds>,
    /// A component that takes longer for one step trips (`What::Overrun`); None: not measured.
    pub step_limit: Option<Duration>,
    /// Values that replace those of the `.ssp`: ("feedback.tau_step", 0.003). Those of the host are
    /// checked but have no effect, so that one list serves controller and plant.
    pub parameters: Vec<(String, Value)>,
    /// A `fault` output that is nonzero trips (`What::Fault`).
    pub fault_trips: bool,
    pub on_thread: Option<ThreadHook>,
}
