//! Inverse kinematics: the angles that belong to a pose of the platform, by the FMU that computes the reference angles of
//! a motion given in poses (`pose.fmu`).

use std::path::Path;
use std::sync::Arc;

use crate::error::Error;
use crate::folder::Folder;
use crate::inline::Inline;
use crate::kinematics::{POSITION, QUATERNION};
use crate::layout::Layout;
use crate::pose::Pose;
use crate::system::System;
use crate::value::Value;
use crate::AXES;

/// Largest angle that the FMU shows [rad]: its own default is the stroke, which the limits of the axes replace. So an
/// angle beyond them can be named.
const STROKE: f64 = 1.5;

/// The FMU alone, with rates and accelerations of zero.
pub struct Inverse {
    inline: Inline,
    layout: Layout,
    /// Inputs: position and quaternion.
    pose: [usize; 7],
    r: [usize; AXES],
    reachable: [usize; AXES],
    period: i64,
    now: i64,
    _folder: Arc<Folder>,
}

impl Inverse {
    /// An FMU without these variables is refused.
    pub fn open(path: &Path) -> Result<Inverse, Error> {
        let lacks = |variable: &str| {
            Error::new(format!("has no variable {variable}: it is not pose.fmu")).at(path.display())
        };
        let alone = System::alone(path, "pose")?;
        let stroke = ("pose.stroke".to_owned(), Value::Number(STROKE));
        let system = alone.with(&[stroke]).map_err(|_| lacks("stroke"))?;
        let component = &system.components()[0];
        let layout = Layout::new(&system, &[component]);
        let slot = |variable: &str| layout.find("pose", variable).ok_or_else(|| lacks(variable));
        let (mut pose, mut r, mut reachable) = ([0; 7], [0; AXES], [0; AXES]);
        for (place, variable) in pose.iter_mut().zip(POSITION.iter().chain(&QUATERNION)) {
            *place = slot(variable)?;
        }
        for axis in 0..AXES {
            r[axis] = slot(&format!("r[{}]", axis + 1))?;
            reachable[axis] = slot(&format!("reachable[{}]", axis + 1))?;
        }
        let inline = Inline::open(&system, &[component], &layout)?;
        let (period, folder) = (component.period(), system.folder());
        let mut inverse =
            Inverse { inline, layout, pose, r, reachable, period, now: 0, _folder: folder };
        // at time zero FMUs show their start values, whatever they are given
        inverse.tick()?;
        Ok(inverse)
    }

    /// The angles [rad] of a pose, or the axes, from 0, whose arms do not reach it or are at their dead point.
    pub fn angles(&mut self, pose: &Pose) -> Result<Result<[f64; AXES], Vec<usize>>, Error> {
        let values = pose.position.into_iter().chain(pose.quaternion());
        let bus = self.inline.bus_mut();
        for (slot, value) in self.pose.iter().zip(values) {
            bus[*slot] = value;
        }
        self.tick()?;
        let bus = self.inline.bus();
        let not: Vec<_> = (0..AXES).filter(|axis| bus[self.reachable[*axis]] == 0.0).collect();
        Ok(if not.is_empty() { Ok(self.r.map(|slot| bus[slot])) } else { Err(not) })
    }

    /// One period of the FMU with the inputs on the bus.
    fn tick(&mut self) -> Result<(), Error> {
        for _ in 0..self.period {
            self.inline.step(self.now, None).map_err(|t| Error::new(t.message))?;
            self.now += 1;
        }
        let published = self.inline.publish(self.now, &self.layout);
        published.map_err(|t| Error::new(t.message))
    }
}
