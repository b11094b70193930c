//! Signals between the machine and the other components: angles, torques, commands.

use crate::component::Component;
use crate::error::Error;
use crate::layout::Layout;
use crate::system::System;
use crate::variables::{Causality, Kind};

/// Slots by axis: the outputs `theta` and `tau_meas`, and the sources of the inputs `tau`.
pub(crate) struct Drives {
    pub theta: Vec<usize>,
    pub tau_meas: Vec<usize>,
    pub tau: Vec<usize>,
}

impl Drives {
    pub fn new(system: &System, machine: &Component, layout: &mut Layout) -> Result<Drives, Error> {
        let name = machine.name();
        let mut outputs = |variable: &str| -> Result<Vec<usize>, Error> {
            let names = array(machine, variable, Causality::Output)?;
            Ok(names.iter().map(|n| layout.add(machine, n)).collect())
        };
        let (theta, tau_meas) = (outputs("theta")?, outputs("tau_meas")?);
        let mut tau = Vec::new();
        for input in array(machine, "tau", Causality::Input)? {
            let mut wires = system.wires().iter();
            let wire = wires.find(|w| w.target == name && w.input == input);
            let slot = wire.and_then(|w| layout.find(&w.source, &w.output));
            let text = format!("{name}.{input}: not connected; connect an output to it");
            tau.push(slot.ok_or_else(|| Error::new(text))?);
        }
        if theta.len() != tau.len() || tau_meas.len() != tau.len() {
            return Err(Error::new(format!(
                "{name}: {} tau, {} theta, {} tau_meas: must be one of each for every axis",
                tau.len(),
                theta.len(),
                tau_meas.len()
            )));
        }
        Ok(Drives { theta, tau_meas, tau })
    }
}

/// Names `theta[1]` ... of an array variable, as many as the component has of that causality.
pub(crate) fn array(
    component: &Component,
    name: &str,
    causality: Causality,
) -> Result<Vec<String>, Error> {
    let names: Vec<String> = (1..)
        .map(|k| format!("{name}[{k}]"))
        .take_while(|n| {
            let variable = component.variable(n);
            variable.is_some_and(|v| v.causality == causality && v.kind == Kind::Real)
        })
        .collect();
    if names.is_empty() {
        return Err(Error::new(format!(
            "{0}: has no {causality} {name}[1]: the component of the machine must have \
             the inputs tau and the outputs theta and tau_meas",
            component.name()
        )));
    }
    Ok(names)
}
