//! Components with a thread of their own: opened afresh or from a saved state, and saved.

use std::time::Duration;

use crate::component::Component;
use crate::error::Error;
use crate::guard::{Bounds, Frozen, Guard};
use crate::layout::Layout;
use crate::state::{parameters, State};
use crate::system::System;
use crate::wiring::find;
use crate::worker::{Outcome, ThreadHook, Worker};

/// A parameter of this name is the time [s] before which a component does not adapt: filters settle
/// until then. A resumed one, whose own time is beyond it, is fed from this time of the run on.
const BEGIN: &str = "t_start";

/// A component in a thread of its own.
pub(crate) struct Threaded {
    pub worker: Worker,
    component: Component,
    /// Ticks in a row at which it was late, and at which it gets no inputs.
    pub left_out: u32,
    guard: Guard,
    /// Largest shares of the bounds so far: of the estimates, and of the innovations.
    pub nearest: [f64; 2],
    /// It has left its bounds: its last outputs within them stay.
    pub frozen: Option<Frozen>,
}

/// What opens them: hook of their threads, states of an earlier run, bounds of their estimates.
pub(crate) type With<'a> = (&'a Option<ThreadHook>, &'a [State], Option<Bounds>);

pub(crate) fn open_all(
    system: &System,
    own: &[&Component],
    layout: &Layout,
    with: With,
) -> Result<Vec<Threaded>, Error> {
    for state in with.1 {
        find(system.components(), &state.component)?;
        if !own.iter().any(|c| c.name() == state.component) {
            let text =
                "a component without a thread of its own is not resumed: name it in own_thread";
            return Err(Error::new(text).at(&state.component));
        }
    }
    own.iter().map(|component| open(system, component, layout, with)).collect()
}

fn open(
    system: &System,
    component: &Component,
    layout: &Layout,
    (hook, resume, bounds): With,
) -> Result<Threaded, Error> {
    let (unit, base) = (layout.unit(system, component)?, system.base_step());
    let state = resume.iter().find(|s| s.component == component.name());
    if let Some(state) = state {
        state.check(component)?;
    }
    let begin = component.parameter(BEGIN).filter(|_| state.is_some()).unwrap_or(0.0);
    let from = state.map(|s| (s.bytes.as_slice(), s.steps));
    let first = (begin / base).ceil() as i64;
    let worker = Worker::open(unit, base, hook.clone(), from, first)?;
    let names = names(component, &layout.names[worker.slots.clone()]);
    let guard = Guard::new(component, &names, bounds);
    let (component, left_out, frozen) = (component.clone(), 0, None);
    let threaded = Threaded { worker, component, left_out, guard, nearest: [0.0; 2], frozen };
    if let Some(state) = state {
        state.check_outputs(&threaded.outputs(layout))?;
    }
    Ok(threaded)
}

/// Names of outputs without that of their component.
fn names(component: &Component, signals: &[String]) -> Vec<String> {
    signals.iter().map(|name| name[component.name().len() + 1..].to_owned()).collect()
}

impl Threaded {
    fn outputs(&self, layout: &Layout) -> Vec<(String, f64)> {
        let names = names(&self.component, &layout.names[self.worker.slots.clone()]);
        names.into_iter().zip(self.worker.outputs()).collect()
    }

    /// It gets inputs at its tick.
    pub fn is_fed(&self, now: i64) -> bool {
        now % self.worker.period == 0 && self.left_out == 0 && self.frozen.is_none()
    }

    /// New outputs to the bus, unless one has left its bounds: then those on the bus stay for good.
    pub fn take(&mut self, bus: &mut [f64], now: i64) {
        let guard = &self.guard;
        let nearest = &mut self.nearest;
        self.frozen = self.worker.take(bus, |values| {
            let shares = guard.shares(values);
            *nearest = [0, 1].map(|k| nearest[k].max(shares[k]));
            guard.outside(values, now)
        });
    }

    /// The state, or why there is none. `wait`: longest wait for a step that is not over.
    pub fn save(&self, layout: &Layout, wait: Duration) -> Result<State, Error> {
        let (component, worker) = (&self.component, &self.worker);
        let refuse = |text: &str| Error::new(text).at(component.name());
        if let Some(frozen) = &self.frozen {
            return Err(refuse(&self.described(frozen, layout)));
        }
        if let Outcome::Failed(message) = worker.finished(wait) {
            return Err(Error::new(message));
        }
        let saved = worker.save().ok_or_else(|| refuse("its step does not end"))?;
        let (bytes, steps) = saved.map_err(|e| e.at(component.name()))?;
        let outputs = self.outputs(layout);
        if let Some((name, value)) = outputs.iter().find(|(_, value)| !value.is_finite()) {
            return Err(refuse(&format!("{name} = {value}")));
        }
        Ok(State {
            component: component.name().to_owned(),
            guid: component.fmu().guid.clone(),
            steps,
            parameters: parameters(component),
            outputs,
            bytes,
        })
    }

    /// What froze it, in words.
    pub fn described(&self, frozen: &Frozen, layout: &Layout) -> String {
        let signal = &layout.names[self.worker.slots.start + frozen.output];
        let Frozen { value, low, high, now, .. } = frozen;
        format!(
            "{signal} = {value:.6} at base step {now}, allowed {low:.6} to {high:.6}: the last estimate within \
             the bounds was kept"
        )
    }
}
