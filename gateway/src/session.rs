//! What `check` and `run` both prepare: configuration, system description, rights of the process.

use clap::Args;
use flexhex_system::{Component, Controller, System};
use serde_json::json;

use crate::cautions;
use crate::config::{Config, AXES};
use crate::limits;
use crate::mismatch::Mismatch;
use crate::motion::{Gains, Mechanics, Pace, Path};
use crate::report::Reporter;

/// Options of every command that gives torque.
#[derive(Args, Clone, Copy, Debug)]
pub struct PowerArgs {
    /// Enable the drives and run closed loop. Without it no drive is enabled.
    #[arg(long)]
    pub enable: bool,
    /// Let each frame advance the plant by one cycle instead of the clock (emulated drives only).
    #[arg(long)]
    pub lockstep: bool,
    /// Reset faults of the drives before enabling.
    #[arg(long)]
    pub reset_faults: bool,
    /// Show the run in a browser at http://127.0.0.1:PORT/, on this computer alone and read-only.
    #[arg(long, value_name = "PORT", value_parser = clap::value_parser!(u16).range(1..))]
    pub page: Option<u16>,
}

/// Read the system description, set the configuration's parameters and check that both fit.
pub fn open_system(config: &Config, reporter: Reporter) -> Result<System, Mismatch> {
    let system = System::open(&config.system.ssp).map_err(Mismatch::System)?;
    let parameters: Vec<_> = config.system.parameters.clone().into_iter().collect();
    let system = system.with(&parameters).map_err(Mismatch::Parameters)?;
    check_host(config, &system)?;
    check_names(config, &system)?;
    check_timeout(config, &system)?;
    check_torque_limits(config, &system)?;
    limits::check(config, &system)?;
    let (path, step_us) = (config.system.ssp.display(), system.base_step() * 1e6);
    let count = system.components().len();
    reporter.mark(true, &format!("{path}: {count} components, cycle time {step_us:.0} us"));
    for caution in cautions::of(config) {
        reporter.line("caution", &caution.to_string());
        reporter.event("caution", json!({ "message": caution.to_string() }));
    }
    Ok(system)
}

/// The component that the drives replace has their signals for every axis.
fn check_host(config: &Config, system: &System) -> Result<(), Mismatch> {
    let host = &config.system.host;
    let Some(component) = system.component(host) else {
        return Err(Mismatch::no_component("system.host", host, system));
    };
    let axes =
        ["theta", "tau_meas", "tau"].into_iter().flat_map(|v| (1..=AXES).map(move |k| (v, k)));
    for variable in axes.map(|(variable, axis)| format!("{variable}[{axis}]")) {
        if component.variable(&variable).is_none() {
            return Err(Mismatch::NoVariable {
                ssp: config.system.ssp.clone(),
                component: host.clone(),
                variable,
                mend: "set system.host to the component of the machine",
            });
        }
    }
    Ok(())
}

/// Every component that the configuration names exists.
fn check_names(config: &Config, system: &System) -> Result<(), Mismatch> {
    let threads = config.system.own_thread.iter().map(|name| ("system.own_thread", name));
    let faults = config.safety.non_trip_faults.keys().map(|n| ("safety.non_trip_faults", n));
    match threads.chain(faults).find(|(_, name)| system.component(name).is_none()) {
        Some((key, name)) => Err(Mismatch::no_component(key, name, system)),
        None => Ok(()),
    }
}

fn check_timeout(config: &Config, system: &System) -> Result<(), Mismatch> {
    let (timeout, step_us) = (config.bus.reply_timeout_us, system.base_step() * 1e6);
    if f64::from(timeout) < step_us {
        return Ok(());
    }
    let ssp = config.system.ssp.clone();
    Err(Mismatch::Timeout { timeout, cycle: step_us, ssp })
}

/// No component may command more torque than the limit of any axis.
fn check_torque_limits(config: &Config, system: &System) -> Result<(), Mismatch> {
    let others = system.components().iter().filter(|c| c.name() != config.system.host);
    for component in others {
        let Some(tau_max) = component.parameter("tau_max") else {
            continue;
        };
        let key = format!("{}.tau_max", component.name());
        for axis in 0..AXES {
            let limit = config.limits(axis).torque;
            if tau_max > limit {
                return Err(Mismatch::Torque { axis, limit, key, commands: tau_max });
            }
        }
    }
    Ok(())
}

/// Names and units of the signals that the configuration adds to a recording.
pub fn extra_columns(config: &Config, controller: &Controller) -> Vec<(String, String)> {
    let unit = |name: &String| {
        let slot = controller.slot(name);
        slot.map_or("1".to_owned(), |slot| controller.units()[slot].clone())
    };
    config.recorder.signals.iter().map(|name| (name.clone(), unit(name))).collect()
}

/// Signal of the system behind each channel of a recording and its period in base steps,
/// `theta=plant.theta:1 ...`, for programs that compare a recording with a simulation.
pub fn channel_map(config: &Config, system: &System) -> String {
    let (s, host) = (&config.system, &config.system.host);
    let mut channels = vec![
        ("theta".to_owned(), format!("{host}.theta")),
        ("tau_meas".to_owned(), format!("{host}.tau_meas")),
        ("r".to_owned(), s.reference.clone()),
        ("tau_ff".to_owned(), s.feedforward.clone()),
        ("e".to_owned(), s.following_error.clone()),
    ];
    for name in &config.recorder.signals {
        let array = name.split('[').next().unwrap_or(name).to_owned();
        if !channels.iter().any(|(channel, _)| *channel == array) {
            channels.push((array.clone(), array));
        }
    }
    let period = |signal: &str| {
        let component = signal.split('.').next().and_then(|name| system.component(name));
        component.map_or(1, Component::period)
    };
    let entry =
        |(channel, signal): &(String, String)| format!("{channel}={signal}:{}", period(signal));
    channels.iter().map(entry).collect::<Vec<_>>().join(" ")
}

/// What lift-off and landing take from the system description: gains, weight, cycle time.
pub fn mechanics(config: &Config, system: &System) -> Result<Mechanics, Mismatch> {
    let landing = &config.landing;
    let name = &landing.feedback;
    let missing = |variable: &str| Mismatch::NoVariable {
        ssp: config.system.ssp.clone(),
        component: name.clone(),
        variable: variable.to_owned(),
        mend: "set landing.feedback to the feedback",
    };
    let component = system.component(name);
    let component =
        component.ok_or_else(|| Mismatch::no_component("landing.feedback", name, system))?;
    let value = |name: &str| component.parameter(name).ok_or_else(|| missing(name));
    let (mut kp, mut weight) = ([0.0; AXES], [0.0; AXES]);
    for axis in 0..AXES {
        let gain = format!("kp[{}]", axis + 1);
        kp[axis] = value(&gain)?;
        if kp[axis] <= 0.0 {
            return Err(Mismatch::NoGain(format!("{name}.{gain}"), kp[axis]));
        }
        let input = format!("tau_ff[{}]", axis + 1);
        let start = component.variable(&input).and_then(|v| v.start);
        weight[axis] = start.ok_or_else(|| missing(&input))?;
    }
    let gains = Gains { kp, t_i: value("t_i")?, t_d: value("t_d")?, t_f: value("t_f")? };
    Ok(Mechanics {
        gains,
        weight,
        torque: landing.torque,
        pace: Pace::of(landing, system.base_step()),
    })
}

/// Cycles of a landing through the whole range of angles.
pub fn longest_landing(config: &Config, system: &System) -> usize {
    let axes = (0..AXES).map(|k| config.limits(k));
    let low = axes.clone().map(|l| l.position_min).fold(f64::INFINITY, f64::min);
    let high = axes.map(|l| l.position_max).fold(f64::NEG_INFINITY, f64::max);
    let pace = Pace::of(&config.landing, system.base_step());
    let path = Path::new([high; AXES], [1e-9; AXES], [low; AXES], pace);
    path.cycles() as usize
}
