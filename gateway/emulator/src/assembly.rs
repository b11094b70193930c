//! From options to the emulated machine.
use crate::error::Error;
use crate::machine::Machine;
use crate::options::Options;
use crate::plant::{Flywheels, Plant};
use crate::trajectory::Trajectory;
use flexhex_system as system;

/// Base step of the flywheels [s].
const BASE_STEP: f64 = 0.00025;

/// The machine before the first frame, at rest if nothing holds it, and its base step [s].
pub fn assemble(options: &Options) -> Result<(Machine, f64), Error> {
    let (plant, dt) = plant(options)?;
    let devices = (0..options.devices()).map(|position| options.device(position)).collect();
    let trajectory = Trajectory::new(dt, options.log.as_deref())?;
    let (faults, timing) = (options.fault.clone(), (dt, options.lockstep));
    let mut machine = Machine::new(devices, options.order(), plant, faults, timing, trajectory);
    if let Some(time) = options.plant.resting_s {
        machine.rest(machine.steps(time))?;
    }
    Ok((machine, dt))
}

/// Plant and base step.
fn plant(options: &Options) -> Result<(Box<dyn Plant>, f64), Error> {
    let choice = &options.plant;
    let Some(path) = &choice.system else {
        return match &choice.fmu {
            Some(fmu) => Err(Error::new(format!(
                "plant {}: give its system description too (--system), which holds its connections",
                fmu.display()
            ))),
            None => Ok((Box::new(Flywheels::new(BASE_STEP)), BASE_STEP)),
        };
    };
    let system = system::System::open(path)?;
    let name = choice.component.as_deref().unwrap_or("plant");
    let setting = options.setting();
    let mut parameters = vec![
        (format!("{name}.tau_step"), system::Value::Number(setting.torque_step())),
        (format!("{name}.theta_step"), system::Value::Number(setting.angle_step())),
    ];
    parameters.extend(choice.parameters.clone());
    let plant = system::Plant::open(&system, name, choice.fmu.as_deref(), &parameters)?;
    Ok((Box::new(plant), system.base_step()))
}
