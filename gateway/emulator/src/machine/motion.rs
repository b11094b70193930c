//! One step of the plant under the torques of the drives, and what the drives measure of it.
use super::Machine;
use crate::error::Error;
use crate::event::EventKind;
use crate::plant::AXES;

impl Machine {
    /// Base steps in a time [s].
    pub fn steps(&self, time: f64) -> u64 {
        (time / self.dt).round() as u64
    }

    /// Lets go of the plant: it moves without torque for `steps` base steps, and from then on.
    pub fn rest(&mut self, steps: u64) -> Result<(), Error> {
        self.waits = false;
        for _ in 0..steps {
            self.push()?;
            self.measure(Some(self.dt));
        }
        self.extremes.note(&self.theta, self.dt);
        Ok(())
    }

    pub(super) fn push(&mut self) -> Result<(), Error> {
        let mut tau = [0.0; AXES];
        for (position, axis) in self.order.clone().into_iter().enumerate() {
            let Some(axis) = axis else { continue };
            tau[axis] = self.devices[position].torque();
            let pushes = self.devices[position].is_enabled();
            if self.pushed[axis] && !pushes {
                self.record(EventKind::TorqueZero { position });
            }
            self.pushed[axis] = pushes;
        }
        if let Some(cycle) = self.cycle {
            self.trajectory.note(cycle, &self.theta, &self.tau_meas, &tau)?;
        }
        for (position, axis) in self.order.clone().into_iter().enumerate() {
            let Some(axis) = axis else { continue };
            // the plant has no other input for it; the drive does not measure it
            self.pushed_from_outside[axis] = self.pushed_by(position, axis);
            tau[axis] += self.pushed_from_outside[axis];
        }
        self.plant.step(&tau)
    }

    pub(super) fn measure(&mut self, dt: Option<f64>) {
        self.plant.read(&mut self.theta, &mut self.tau_meas);
        for (tau, push) in self.tau_meas.iter_mut().zip(&self.pushed_from_outside) {
            *tau -= push;
        }
        for (device, axis) in self.devices.iter_mut().zip(&self.order) {
            let Some(axis) = axis else { continue };
            device.drive_mut().measure(self.theta[*axis], self.tau_meas[*axis], dt);
            device.show_inputs();
        }
    }
}

#[cfg(test)]
#[path = "motion_tests.rs"]
mod tests;
