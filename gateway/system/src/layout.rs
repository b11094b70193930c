//! The part of a system that this process runs: components, slots of their signals on the bus, and
//! signals from outside.

use std::collections::HashMap;

use crate::component::Component;
use crate::error::Error;
use crate::system::System;
use crate::unit::{Sorted, Unit};
use crate::variables::{Causality, Kind, Variable};

/// Signals "component.variable" in the order of the bus.
#[derive(Default)]
pub(crate) struct Layout {
    pub names: Vec<String>,
    pub units: Vec<String>,
    slots: HashMap<String, usize>,
}

impl Layout {
    /// Outputs of all members, component by component, then whatever else feeds them.
    pub fn new(system: &System, members: &[&Component]) -> Layout {
        let mut layout = Layout::default();
        for member in members {
            for output in outputs(member) {
                layout.add(member, &output.name);
            }
        }
        for wire in system.wires() {
            let fed = members.iter().any(|m| m.name() == wire.target);
            if let Some(source) = system.component(&wire.source).filter(|_| fed) {
                layout.add(source, &wire.output);
            }
        }
        layout
    }

    /// Slot of a signal; a new one if it has none.
    pub fn add(&mut self, component: &Component, variable: &str) -> usize {
        let name = format!("{}.{variable}", component.name());
        if let Some(slot) = self.slots.get(&name) {
            return *slot;
        }
        let unit = component.variable(variable).map(|v| v.unit.clone());
        self.units.push(unit.unwrap_or_default());
        self.slots.insert(name.clone(), self.names.len());
        self.names.push(name);
        self.names.len() - 1
    }

    pub fn slot(&self, signal: &str) -> Option<usize> {
        self.slots.get(signal).copied()
    }

    pub fn find(&self, component: &str, variable: &str) -> Option<usize> {
        self.slot(&format!("{component}.{variable}"))
    }

    /// A member in the form of the executor.
    pub fn unit(&self, system: &System, member: &Component) -> Result<Unit, Error> {
        let outputs = outputs(member);
        let first = outputs.first().map(|v| v.name.as_str());
        let wires = system.wires().iter().filter(|w| w.target == member.name());
        let inputs = wires.map(|w| {
            let slot = self.find(&w.source, &w.output);
            let slot = slot.ok_or_else(|| Error::new(format!("connection {w}: has no signal")))?;
            Ok((member.fmu().variable(&w.input)?, slot))
        });
        let values = member.values().iter();
        let values = values.map(|(name, value)| Ok((member.fmu().variable(name)?, *value)));
        let (inputs, sources) = sorted(inputs.collect::<Result<_, Error>>()?);
        let (parameters, values) = sorted(values.collect::<Result<_, Error>>()?);
        Ok(Unit {
            name: member.name().to_owned(),
            fmu: member.shared_fmu(),
            period: member.period(),
            parameters,
            values,
            inputs,
            sources,
            slot: first.and_then(|name| self.find(member.name(), name)).unwrap_or(0),
            outputs: Sorted::of(&outputs),
        })
    }
}

/// Outputs in the order of their types, as the executor wants them.
fn outputs(member: &Component) -> Vec<&Variable> {
    let mut listed: Vec<_> =
        member.of(Causality::Output).filter(|v| v.kind != Kind::String).collect();
    listed.sort_by_key(|v| v.kind);
    listed
}

/// Variables in the order of their types, and what belongs to each.
fn sorted<T>(mut listed: Vec<(&Variable, T)>) -> (Sorted, Vec<T>) {
    listed.sort_by_key(|(variable, _)| variable.kind);
    let (variables, rest): (Vec<_>, Vec<_>) = listed.into_iter().unzip();
    (Sorted::of(&variables), rest)
}
