//! The reference alone, ahead of the run that follows it.

use std::sync::Arc;

use crate::component::Component;
use crate::dynamics::Motion;
use crate::error::Error;
use crate::folder::Folder;
use crate::inline::Inline;
use crate::kinematics::{fed, wired};
use crate::layout::Layout;
use crate::system::System;
use crate::AXES;

/// The components that the wanted motion comes from.
pub struct Planned {
    inline: Inline,
    layout: Layout,
    /// Angles, rates, accelerations.
    outputs: [[usize; AXES]; 3],
    now: i64,
    _folder: Arc<Folder>,
}

impl Planned {
    /// `reference`: the signal of the wanted angles. None: no kinematics shows which rates belong to it, or the motion
    /// depends on what the machine (`host`) does.
    pub fn of(system: &System, host: &str, reference: &str) -> Result<Option<Planned>, Error> {
        let Some(kinematics) = fed(system, reference) else { return Ok(None) };
        let wires = system.wires();
        let begin = wires.iter().filter(|w| w.target == kinematics.name());
        let mut names: Vec<&str> = begin.map(|w| w.source.as_str()).collect();
        let mut seen = 0;
        while let Some(name) = names.get(seen).copied() {
            let sources = wires.iter().filter(|w| w.target == name).map(|w| w.source.as_str());
            let new: Vec<&str> = sources.filter(|source| !names.contains(source)).collect();
            names.extend(new);
            seen += 1;
        }
        if names.contains(&host) {
            return Ok(None);
        }
        let listed = system.components().iter().filter(|c| names.contains(&c.name()));
        let members: Vec<&Component> = listed.collect();
        let layout = Layout::new(system, &members);
        let mut inline = Inline::beside(system, &members, &layout, "ahead")?;
        inline.publish(0, &layout).map_err(|t| Error::new(t.message))?;
        let mut outputs = [[0; AXES]; 3];
        for (slots, name) in outputs.iter_mut().zip(["theta", "thetad", "thetadd"]) {
            *slots = wired(system, &layout, kinematics.name(), name)?;
        }
        Ok(Some(Planned { inline, layout, outputs, now: 0, _folder: system.folder() }))
    }

    /// The motion that is wanted now.
    pub fn motion(&self) -> Motion {
        let bus = self.inline.bus();
        let [theta, thetad, thetadd] = self.outputs.map(|slots| slots.map(|slot| bus[slot]));
        Motion { theta, thetad, thetadd }
    }

    /// One base step on.
    pub fn step(&mut self) -> Result<(), Error> {
        self.inline.step(self.now, None).map_err(|t| Error::new(t.message))?;
        self.now += 1;
        let published = self.inline.publish(self.now, &self.layout);
        published.map_err(|t| Error::new(t.message))
    }
}
