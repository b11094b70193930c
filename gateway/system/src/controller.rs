//! All components except the host, the component of the machine that the drives replace.

use std::sync::Arc;
use std::time::Duration;

use crate::component::Component;
use crate::drives::Drives;
use crate::error::Error;
use crate::folder::Folder;
use crate::inline::{check_finite, Inline};
use crate::layout::Layout;
use crate::options::{Late, Options};
use crate::state::State;
use crate::system::System;
use crate::threaded::{self, Threaded};
use crate::trip::Trip;
use crate::wiring::find;
use crate::worker::Outcome;

/// All components except the host. May be opened in one thread and cycled in another.
pub struct Controller {
    inline: Inline,
    workers: Vec<Threaded>,
    layout: Layout,
    drives: Drives,
    /// Component and slot of every output `fault`.
    faults: Vec<(Component, usize)>,
    command: Vec<f64>,
    now: i64,
    late: u64,
    tripped: Option<Trip>,
    options: Options,
    _folder: Arc<Folder>,
}

impl Controller {
    /// `host`: the component of the machine; the drives replace it.
    pub fn open(system: &System, host: &str, options: Options) -> Result<Controller, Error> {
        let system = system.with(&options.parameters)?;
        let machine = find(system.components(), host)?;
        for name in &options.own_thread {
            let component = find(system.components(), name)?;
            if component.name() == host {
                let text = format!("{name}: is the component of the machine, which the drives replace: it has no thread");
                return Err(Error::new(text));
            }
        }
        let all = system.components().iter();
        let members: Vec<&Component> = all.filter(|c| c.name() != host).collect();
        let mut layout = Layout::new(&system, &members);
        let drives = Drives::new(&system, machine, &mut layout)?;
        drives_suffice(&system, host)?;
        let threaded = |m: &&Component| options.own_thread.iter().any(|n| n == m.name());
        let (own, inside): (Vec<&Component>, Vec<_>) = members.iter().copied().partition(threaded);
        let inline = Inline::open(&system, &inside, &layout)?;
        let with = (&options.on_thread, options.resume.as_slice(), options.bounds);
        let workers = threaded::open_all(&system, &own, &layout, with)?;
        let faults = members.iter().filter_map(|m| {
            let slot = layout.find(m.name(), "fault")?;
            Some(((*m).clone(), slot))
        });
        let mut controller = Controller {
            faults: faults.collect(),
            command: vec![0.0; drives.tau.len()],
            inline,
            workers,
            layout,
            drives,
            now: 0,
            late: 0,
            tripped: None,
            options,
            _folder: system.folder(),
        };
        controller.publish().map_err(|t| Error::new(t.message))?;
        Ok(controller)
    }

    /// Base steps n.
    pub fn now(&self) -> i64 {
        self.now
    }

    /// `tau[1..6]` that the host gets at `now` [N m].
    pub fn command(&self) -> &[f64] {
        &self.command
    }

    /// Host outputs of n (angles [rad], torques [N m]) go on the bus, all components due take
    /// their inputs and step; then n + 1 is published. Allocates nothing unless it trips.
    pub fn cycle(&mut self, theta: &[f64], tau_meas: &[f64]) -> Result<(), Trip> {
        if let Some(trip) = &self.tripped {
            return Err(trip.clone());
        }
        let done = self.advance(theta, tau_meas);
        if let Err(trip) = &done {
            self.tripped = Some(trip.clone());
        }
        done
    }

    fn advance(&mut self, theta: &[f64], tau_meas: &[f64]) -> Result<(), Trip> {
        let bus = self.inline.bus_mut();
        for (slots, values) in [(&self.drives.theta, theta), (&self.drives.tau_meas, tau_meas)] {
            for (slot, value) in slots.iter().zip(values) {
                bus[*slot] = *value;
            }
        }
        for threaded in &self.workers {
            if threaded.is_fed(self.now) {
                threaded.worker.start(self.now, bus);
            }
        }
        self.inline.step(self.now, self.options.step_limit)?;
        self.now += 1;
        self.publish()
    }

    /// Publishes the outputs of `now` on the bus.
    fn publish(&mut self) -> Result<(), Trip> {
        let now = self.now;
        self.inline.publish(now, &self.layout)?;
        for threaded in &mut self.workers {
            let worker = &threaded.worker;
            if now % worker.period != 0 || threaded.frozen.is_some() {
                continue;
            }
            match worker.finished(self.options.wait) {
                Outcome::Done => {
                    threaded.left_out = 0;
                    threaded.take(self.inline.bus_mut(), now);
                    let (worker, bus) = (&threaded.worker, self.inline.bus());
                    check_finite(&worker.name, now, worker.slots.clone(), bus, &self.layout)?;
                }
                Outcome::Failed(message) => return Err(Trip::refused(&worker.name, now, message)),
                Outcome::Late if self.options.late == Late::Hold => {
                    threaded.left_out += 1;
                    self.late += 1;
                    if self.options.late_limit.is_some_and(|most| threaded.left_out > most) {
                        let (name, ticks) = (&worker.name, threaded.left_out);
                        return Err(Trip::hung(name, now, worker.period, ticks));
                    }
                }
                Outcome::Late => return Err(Trip::late(&worker.name, now, worker.period)),
            }
        }
        let bus = self.inline.bus();
        for (command, slot) in self.command.iter_mut().zip(&self.drives.tau) {
            *command = bus[*slot];
        }
        if self.options.fault_trips {
            let mut faults = self.faults();
            if let Some((component, fault)) = faults.next() {
                return Err(Trip::fault(component, now, fault));
            }
        }
        Ok(())
    }

    /// Place of "K.p.actuator[1].o" on the bus.
    pub fn slot(&self, signal: &str) -> Option<usize> {
        self.layout.slot(signal)
    }

    pub fn bus(&self) -> &[f64] {
        self.inline.bus()
    }

    /// Names "component.variable" in the order of the bus.
    pub fn signals(&self) -> &[String] {
        &self.layout.names
    }

    /// Unit of each signal, in the order of the bus.
    pub fn units(&self) -> &[String] {
        &self.layout.units
    }

    /// Component and value of every `fault` output that is not zero at `now`.
    pub fn faults(&self) -> impl Iterator<Item = (&Component, f64)> {
        let bus = self.inline.bus();
        let all = self.faults.iter().map(|(component, slot)| (component, bus[*slot]));
        all.filter(|(_, fault)| *fault != 0.0)
    }

    /// The states of all components with a thread of their own, or why one has none. `wait`: longest
    /// wait for a step that is not over.
    pub fn save(&self, wait: Duration) -> Vec<Result<State, Error>> {
        self.workers.iter().map(|threaded| threaded.save(&self.layout, wait)).collect()
    }

    /// What each component that left its bounds was stopped by.
    pub fn frozen(&self) -> Vec<String> {
        let all = self.workers.iter();
        all.filter_map(|t| Some(t.described(t.frozen.as_ref()?, &self.layout))).collect()
    }

    /// Largest shares of their bounds that the estimates and the innovations took.
    pub fn nearest(&self) -> [f64; 2] {
        let most = |k: usize| self.workers.iter().fold(0.0, |most: f64, t| most.max(t.nearest[k]));
        [most(0), most(1)]
    }

    /// Ticks that threads of their own have left out so far (`Late::Hold`).
    pub fn late(&self) -> u64 {
        self.late
    }
}

/// Refuses a system that uses outputs of the machine which drives do not measure.
fn drives_suffice(system: &System, host: &str) -> Result<(), Error> {
    let given = |output: &str| output.starts_with("theta[") || output.starts_with("tau_meas[");
    let mut wires = system.wires().iter();
    match wires.find(|w| w.source == host && w.target != host && !given(&w.output)) {
        None => Ok(()),
        Some(wire) => Err(Error::new(format!(
            "connection {wire}: drives measure theta and tau_meas only: connect another output to {}.{}",
            wire.target, wire.input
        ))),
    }
}
