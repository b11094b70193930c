//! The kinematics of the reference alone: the platform that belongs to six angles.

use std::sync::Arc;

use crate::component::Component;
use crate::error::Error;
use crate::folder::Folder;
use crate::inline::Inline;
use crate::layout::Layout;
use crate::pose::Pose;
use crate::system::System;
use crate::AXES;

/// Position and quaternion of the platform, as the FMU names them, without their rates' prefix.
pub(crate) const POSITION: [&str; 3] = ["x_E.x", "x_E.y", "x_E.z"];
pub(crate) const QUATERNION: [&str; 4] = ["lam_E[1]", "lam_E[2]", "lam_E[3]", "lam_E[4]"];
/// Rate of the axis whose gain is computed [rad/s]: so slow that what it predicts of the next pose is right.
const RATE: f64 = 1e-3;

/// The component that the reference feeds with its angles and rates, and that has the platform's pose.
pub struct Kinematics {
    inline: Inline,
    layout: Layout,
    name: String,
    theta: [usize; AXES],
    thetad: [usize; AXES],
    position: [usize; 3],
    quaternion: [usize; 4],
    fault: usize,
    period: i64,
    now: i64,
    _folder: Arc<Folder>,
}

/// How fast the platform moves while an axis turns: of its position [m/rad], of its orientation [rad/rad].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gain {
    pub position: f64,
    pub orientation: f64,
}

impl Gain {
    /// The larger of both, one by one.
    pub fn or_more(&self, other: &Gain) -> Gain {
        Gain {
            position: self.position.max(other.position),
            orientation: self.orientation.max(other.orientation),
        }
    }
}

impl Kinematics {
    /// `reference`: the signal of the wanted angles, "reference.r". `purpose`: end of the instance's name, which no other
    /// has. None: nothing computes the platform from it.
    pub fn of(
        system: &System,
        reference: &str,
        purpose: &str,
    ) -> Result<Option<Kinematics>, Error> {
        let Some(component) = fed(system, reference) else { return Ok(None) };
        let layout = Layout::new(system, &[component]);
        let inline = Inline::beside(system, &[component], &layout, &format!("gain{purpose}"))?;
        let name = component.name().to_owned();
        let output = |variable: &str| {
            let slot = layout.find(&name, &format!("xd.{variable}"));
            slot.ok_or_else(|| Error::new(format!("{name}: has no output xd.{variable}")))
        };
        let (mut position, mut quaternion) = ([0; 3], [0; 4]);
        for (slot, variable) in position.iter_mut().zip(POSITION) {
            *slot = output(variable)?;
        }
        for (slot, variable) in quaternion.iter_mut().zip(QUATERNION) {
            *slot = output(variable)?;
        }
        let fault = layout.find(&name, "fault");
        let fault = fault.ok_or_else(|| Error::new(format!("{name}: has no output fault")))?;
        let input = |variable| wired(system, &layout, &name, variable);
        let (theta, thetad, period) = (input("theta")?, input("thetad")?, component.period());
        let folder = system.folder();
        let mut kinematics = Kinematics {
            inline,
            layout,
            name,
            theta,
            thetad,
            position,
            quaternion,
            fault,
            period,
            now: 0,
            _folder: folder,
        };
        // at time zero FMUs show their start values, whatever they are given
        kinematics.tick(&[0.0; AXES], &[0.0; AXES])?;
        Ok(Some(kinematics))
    }

    /// The largest gain of an axis at these angles [rad]; None: the platform cannot reach them.
    pub fn gain(&mut self, theta: &[f64; AXES]) -> Result<Option<Gain>, Error> {
        let mut most = Gain::default();
        for axis in 0..AXES {
            let Some(gain) = self.gain_of(axis, theta)? else { return Ok(None) };
            most = most.or_more(&gain);
        }
        Ok(Some(most))
    }

    /// The gain of one axis there; it allocates nothing.
    pub fn gain_of(&mut self, axis: usize, theta: &[f64; AXES]) -> Result<Option<Gain>, Error> {
        let mut thetad = [0.0; AXES];
        thetad[axis] = RATE;
        self.tick(theta, &thetad)?;
        if self.inline.bus()[self.fault] != 0.0 {
            return Ok(None);
        }
        // of a unit quaternion: the rate of the orientation is twice its own
        let position = self.size(&self.position) / RATE;
        let orientation = 2.0 * self.size(&self.quaternion) / RATE;
        Ok(Some(Gain { position, orientation }))
    }

    /// The platform's pose at these angles [rad]; None: it cannot reach them.
    pub fn pose(&mut self, theta: &[f64; AXES]) -> Result<Option<Pose>, Error> {
        // what one tick may leave of the residual, a second one from there squares
        self.tick(theta, &[0.0; AXES])?;
        self.tick(theta, &[0.0; AXES])?;
        let at = |variable: &str| self.value(&format!("x.{variable}")).unwrap_or(f64::NAN);
        let pose = Pose::of(POSITION.map(at), QUATERNION.map(at));
        Ok((self.inline.bus()[self.fault] == 0.0).then_some(pose))
    }

    /// An output of the component after the newest call.
    pub fn value(&self, variable: &str) -> Option<f64> {
        self.layout.find(&self.name, variable).map(|slot| self.inline.bus()[slot])
    }

    fn size(&self, slots: &[usize]) -> f64 {
        slots.iter().map(|slot| self.inline.bus()[*slot].powi(2)).sum::<f64>().sqrt()
    }

    /// One period of the component with these inputs.
    fn tick(&mut self, theta: &[f64; AXES], thetad: &[f64; AXES]) -> Result<(), Error> {
        let bus = self.inline.bus_mut();
        for axis in 0..AXES {
            bus[self.theta[axis]] = theta[axis];
            bus[self.thetad[axis]] = thetad[axis];
        }
        for _ in 0..self.period {
            self.inline.step(self.now, None).map_err(|t| Error::new(t.message))?;
            self.now += 1;
        }
        let published = self.inline.publish(self.now, &self.layout);
        published.map_err(|t| Error::new(t.message))
    }
}

/// The component that the reference feeds, and that has the platform's pose.
pub(crate) fn fed<'a>(system: &'a System, reference: &str) -> Option<&'a Component> {
    let first = format!("{reference}[1]");
    let fed = system
        .wires()
        .iter()
        .filter(|w| format!("{}.{}", w.source, w.output) == first && w.input == "theta[1]");
    fed.filter_map(|w| system.component(&w.target))
        .find(|c| c.variable(&format!("x.{}", POSITION[0])).is_some())
}

/// Slots of what feeds an input of all axes.
pub(crate) fn wired(
    system: &System,
    layout: &Layout,
    name: &str,
    variable: &str,
) -> Result<[usize; AXES], Error> {
    let mut slots = [0; AXES];
    for (axis, slot) in slots.iter_mut().enumerate() {
        let input = format!("{variable}[{}]", axis + 1);
        let wire = system.wires().iter().find(|w| w.target == name && w.input == input);
        let found = wire.and_then(|w| layout.find(&w.source, &w.output));
        *slot = found.ok_or_else(|| Error::new(format!("{name}.{input}: not connected")))?;
    }
    Ok(slots)
}
