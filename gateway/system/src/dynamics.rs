//! The inverse dynamics of the reference alone: the torques that belong to a motion.

use std::sync::Arc;

use crate::component::Component;
use crate::error::Error;
use crate::folder::Folder;
use crate::inline::Inline;
use crate::kinematics::{fed, wired};
use crate::layout::Layout;
use crate::system::System;
use crate::AXES;

/// Angles [rad], rates [rad/s] and accelerations [rad/s2] of all axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    pub theta: [f64; AXES],
    pub thetad: [f64; AXES],
    pub thetadd: [f64; AXES],
}

/// The kinematics of the reference and the feedforward that it feeds, with the parameters that the feedforward starts
/// with: nothing that an estimator learned.
pub struct Dynamics {
    inline: Inline,
    layout: Layout,
    /// Inputs: angles, rates, accelerations.
    inputs: [[usize; AXES]; 3],
    tau: [usize; AXES],
    faults: Vec<usize>,
    /// Base steps from inputs to torques.
    steps: i64,
    now: i64,
    _folder: Arc<Folder>,
}

impl Dynamics {
    /// `reference`, `feedforward`: the signals of the wanted angles and of the model's torques. `purpose`: end of the
    /// instances' names, which no others have. None: the one is not computed from the other by two components.
    pub fn of(
        system: &System,
        reference: &str,
        feedforward: &str,
        purpose: &str,
    ) -> Result<Option<Dynamics>, Error> {
        let model = feedforward.split_once('.').and_then(|(name, variable)| {
            let component = system.component(name)?;
            component.variable(&format!("{variable}[1]")).map(|_| (component, variable))
        });
        let (Some(kinematics), Some((model, variable))) = (fed(system, reference), model) else {
            return Ok(None);
        };
        let between = |w: &&crate::structure::Wire| {
            w.source == kinematics.name() && w.target == model.name() && w.input.starts_with("x.")
        };
        if !system.wires().iter().any(|w| between(&w)) {
            return Ok(None);
        }
        let members = [kinematics, model];
        let layout = Layout::new(system, &members);
        let purpose = format!("model{purpose}");
        let mut inline = Inline::beside(system, &members, &layout, &purpose)?;
        starts(system, model, kinematics, (&layout, inline.bus_mut()));
        let mut inputs = [[0; AXES]; 3];
        for (slots, name) in inputs.iter_mut().zip(["theta", "thetad", "thetadd"]) {
            *slots = wired(system, &layout, kinematics.name(), name)?;
        }
        let mut tau = [0; AXES];
        for (axis, slot) in tau.iter_mut().enumerate() {
            let name = format!("{variable}[{}]", axis + 1);
            let found = layout.find(model.name(), &name);
            let text = format!("{}: has no output {name}", model.name());
            *slot = found.ok_or_else(|| Error::new(text))?;
        }
        let faults = members.iter().filter_map(|m| layout.find(m.name(), "fault")).collect();
        // a component is fed at a multiple of its period, when what it takes is there
        let longest = kinematics.period().max(model.period());
        let (steps, folder) = (2 * longest, system.folder());
        let dynamics =
            Dynamics { inline, layout, inputs, tau, faults, steps, now: 0, _folder: folder };
        Ok(Some(dynamics))
    }

    /// The torques [N m] of a motion; None: the platform cannot be there. It allocates nothing.
    pub fn torque(&mut self, motion: &Motion) -> Result<Option<[f64; AXES]>, Error> {
        let values = [motion.theta, motion.thetad, motion.thetadd];
        let bus = self.inline.bus_mut();
        for (slots, values) in self.inputs.iter().zip(values) {
            for (slot, value) in slots.iter().zip(values) {
                bus[*slot] = value;
            }
        }
        for _ in 0..self.steps {
            self.inline.step(self.now, None).map_err(|t| Error::new(t.message))?;
            self.now += 1;
            let published = self.inline.publish(self.now, &self.layout);
            published.map_err(|t| Error::new(t.message))?;
        }
        let bus = self.inline.bus();
        let sound = self.faults.iter().all(|slot| bus[*slot] == 0.0);
        Ok(sound.then(|| self.tau.map(|slot| bus[slot])))
    }
}

/// What the model gets from elsewhere has its start values.
fn starts(
    system: &System,
    model: &Component,
    kinematics: &Component,
    (layout, bus): (&Layout, &mut [f64]),
) {
    let elsewhere = |w: &&crate::structure::Wire| {
        w.target == model.name() && w.source != kinematics.name() && w.source != model.name()
    };
    for wire in system.wires().iter().filter(elsewhere) {
        let start = model.variable(&wire.input).and_then(|v| v.start);
        if let (Some(slot), Some(start)) = (layout.find(&wire.source, &wire.output), start) {
            bus[slot] = start;
        }
    }
}
