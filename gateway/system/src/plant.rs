//! The machine as an FMU: one component and the sources of its inputs other than the torques.

use std::path::Path;
use std::sync::Arc;

use crate::component::Component;
use crate::drives::{array, Drives};
use crate::error::Error;
use crate::folder::Folder;
use crate::inline::Inline;
use crate::layout::Layout;
use crate::system::System;
use crate::value::Value;
use crate::variables::Causality;
use crate::wiring::find;

/// One component of the `.ssp`, or another FMU in its place.
pub struct Plant {
    inline: Inline,
    layout: Layout,
    drives: Drives,
    now: i64,
    _folder: Arc<Folder>,
}

impl Plant {
    /// `fmu`: replaces the component, with its own start values.
    /// parameters: as `Options::parameters`, with the component's name: ("plant.tau_step", 0.003).
    pub fn open(
        system: &System,
        name: &str,
        fmu: Option<&Path>,
        parameters: &[(String, Value)],
    ) -> Result<Plant, Error> {
        let system = match fmu {
            Some(path) => system.with_fmu(name, path)?.with(parameters)?,
            None => system.with(parameters)?,
        };
        let machine = find(system.components(), name)?;
        let torques = array(machine, "tau", Causality::Input)?;
        let members = members(&system, machine, &torques);
        let mut layout = Layout::new(&system, &members);
        let drives = Drives::new(&system, machine, &mut layout)?;
        let inline = Inline::open(&system, &members, &layout)?;
        let mut plant = Plant { inline, layout, drives, now: 0, _folder: system.folder() };
        plant.publish()?;
        Ok(plant)
    }

    /// `theta[1..6]` [rad] and `tau_meas[1..6]` [N m] at `now`.
    pub fn read(&self, theta: &mut [f64], tau_meas: &mut [f64]) {
        let bus = self.inline.bus();
        for (values, slots) in [(theta, &self.drives.theta), (tau_meas, &self.drives.tau_meas)] {
            for (value, slot) in values.iter_mut().zip(slots) {
                *value = bus[*slot];
            }
        }
    }

    /// One base step under the torques `tau` [N m].
    pub fn step(&mut self, tau: &[f64]) -> Result<(), Error> {
        let bus = self.inline.bus_mut();
        for (slot, torque) in self.drives.tau.iter().zip(tau) {
            bus[*slot] = *torque;
        }
        let stepped = self.inline.step(self.now, None);
        stepped.map_err(|t| Error::new(t.message))?;
        self.now += 1;
        self.publish()
    }

    /// Base steps n.
    pub fn now(&self) -> i64 {
        self.now
    }

    fn publish(&mut self) -> Result<(), Error> {
        let published = self.inline.publish(self.now, &self.layout);
        published.map_err(|t| Error::new(t.message))
    }
}

/// The machine and what feeds it, directly or not, other than through the torques.
fn members<'a>(
    system: &'a System,
    machine: &'a Component,
    torques: &[String],
) -> Vec<&'a Component> {
    let mut needed = vec![machine.name()];
    let mut k = 0;
    while k < needed.len() {
        let target = needed[k];
        for wire in system.wires().iter().filter(|w| w.target == target) {
            let torque = wire.target == machine.name() && torques.contains(&wire.input);
            if !torque && !needed.contains(&wire.source.as_str()) {
                needed.push(&wire.source);
            }
        }
        k += 1;
    }
    let all = system.components().iter();
    all.filter(|c| needed.contains(&c.name())).collect()
}
