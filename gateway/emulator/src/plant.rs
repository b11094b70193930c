//! The plant that the drives move: an FMU of the system description, or simple flywheels.
use crate::error::Error;
use flexhex_system as system;
pub use flexhex_system::AXES;

pub trait Plant {
    /// `theta[1..6]` [rad] and `tau_meas[1..6]` [N m] now.
    fn read(&self, theta: &mut [f64; AXES], tau: &mut [f64; AXES]);
    /// One base step under the torques `tau` [N m].
    fn step(&mut self, tau: &[f64; AXES]) -> Result<(), Error>;
}

impl Plant for system::Plant {
    fn read(&self, theta: &mut [f64; AXES], tau: &mut [f64; AXES]) {
        system::Plant::read(self, theta, tau);
    }

    fn step(&mut self, tau: &[f64; AXES]) -> Result<(), Error> {
        Ok(system::Plant::step(self, tau)?)
    }
}

/// Six independent flywheels with viscous friction: for tests without an FMU.
pub struct Flywheels {
    pub dt: f64,
    /// `[kg m2]`
    pub inertia: f64,
    /// `[N m s/rad]`
    pub friction: f64,
    theta: [f64; AXES],
    speed: [f64; AXES],
    tau: [f64; AXES],
}

impl Flywheels {
    pub fn new(dt: f64) -> Flywheels {
        let zero = [0.0; AXES];
        Flywheels { dt, inertia: 0.05, friction: 0.2, theta: zero, speed: zero, tau: zero }
    }
}

impl Plant for Flywheels {
    fn read(&self, theta: &mut [f64; AXES], tau: &mut [f64; AXES]) {
        *theta = self.theta;
        *tau = self.tau;
    }

    fn step(&mut self, tau: &[f64; AXES]) -> Result<(), Error> {
        self.tau = *tau;
        for ((theta, speed), tau) in self.theta.iter_mut().zip(&mut self.speed).zip(tau) {
            *speed += self.dt * (tau - self.friction * *speed) / self.inertia;
            *theta += self.dt * *speed;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flywheels_reach_the_speed_where_friction_takes_the_torque() {
        let mut plant = Flywheels::new(0.00025);
        let (mut theta, mut tau) = ([0.0; AXES], [0.0; AXES]);
        for _ in 0..8000 {
            plant.step(&[0.1; AXES]).unwrap();
        }
        plant.read(&mut theta, &mut tau);
        // 0.1 / 0.2 rad/s for 2 s, less the start with the time constant 0.25 s:
        // 0.5 * (2 - 0.25) rad; explicit steps are off by about half a step
        assert!((theta[3] - 0.875).abs() < 5e-4, "{}", theta[3]);
        assert_eq!(tau, [0.1; AXES]);
    }
}
