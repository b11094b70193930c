//! `check`: all that can be refused before there is power.

use clap::Args;
use flexhex_system::{Controller, System};
use serde_json::json;
use std::path::PathBuf;
use std::time::Duration;

use crate::bus::{self, Wish};
use crate::config::{self, Config, AXES};
use crate::cycle::{signals, Signals};
use crate::report::Teller;
use crate::wire::Socket;
use crate::Exit;

/// Where a configuration comes from, and what the command line puts in its place.
#[derive(Args)]
pub struct From {
    /// Configuration of the machine (TOML).
    config: PathBuf,
    /// Network interface, in place of bus.interface.
    #[arg(long, value_name = "NAME")]
    interface: Option<String>,
    /// System description, in place of system.ssp.
    #[arg(long, value_name = "FILE")]
    ssp: Option<PathBuf>,
    /// One value of the configuration, as `--set safety.overrun_us=20000`.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// One JSON object a line on stdout, words on stderr.
    #[arg(long)]
    json: bool,
}

impl From {
    pub fn teller(&self) -> Teller {
        Teller::new(self.json)
    }

    /// The checked configuration.
    pub fn read(&self) -> Result<Config, String> {
        let mut config = config::read(&self.config, &self.set)?;
        if let Some(interface) = &self.interface {
            config.bus.interface.clone_from(interface);
        }
        if let Some(ssp) = &self.ssp {
            config.system.ssp.clone_from(ssp);
        }
        Ok(config)
    }
}

#[derive(Args)]
pub struct Check {
    #[command(flatten)]
    from: From,
    /// Also look at the drives: who they are, in which order, in which state. Nothing is enabled.
    #[arg(long)]
    bus: bool,
}

/// Carry it out.
pub fn check(args: &Check) -> Exit {
    let teller = args.from.teller();
    teller.title("flexhex-gateway check");
    match without_power(args, teller) {
        Ok(()) => {
            teller.mark(true, "nothing speaks against it");
            teller.event("checked", json!({ "good": true }));
            Exit::Good
        }
        Err((exit, why)) => {
            teller.refused(&why);
            exit
        }
    }
}

fn without_power(args: &Check, teller: Teller) -> Result<(), (Exit, String)> {
    let bad = |why| (Exit::BadInput, why);
    let config = args.from.read().map_err(bad)?;
    teller.mark(true, "configuration");
    let system = system(&config, teller).map_err(bad)?;
    let controller = signals::open(&config, &system, true).map_err(bad)?;
    Signals::find(&config, &controller).map_err(bad)?;
    teller.mark(true, "every FMU loads and starts");
    for note in crate::run::privileges(&config, false) {
        teller.line("note", &note);
    }
    let failed = |why| (Exit::Failed, why);
    let socket = Socket::open(&config.bus.interface).map_err(failed)?;
    teller.mark(true, &format!("interface {}", config.bus.interface));
    if args.bus {
        let wish = Wish {
            cycle: Duration::from_secs_f64(system.base_step()),
            lockstep: true,
            reset_faults: false,
        };
        let found = bus::inspect(&config, socket, wish).map_err(failed)?;
        teller.found(&found);
        bus::compare(&config, &found).map_err(failed)?;
        bus::refuse_energised(&config, &found, false).map_err(failed)?;
        teller.mark(true, "the drives are those that the configuration names, without power");
    }
    Ok(())
}

/// Read the system description and compare it with what the drives need of it.
pub fn system(config: &Config, teller: Teller) -> Result<System, String> {
    let path = config.system.ssp.display();
    let system = System::open(&config.system.ssp).map_err(|why| why.to_string())?;
    let host = &config.system.host;
    let names = || system.components().iter().map(|c| c.name()).collect::<Vec<_>>();
    let Some(component) = system.component(host) else {
        return Err(format!(
            "{path}: no component {host:?}, it has {:?}: set system.host",
            names()
        ));
    };
    for variable in ["theta", "tau_meas", "tau"] {
        for axis in 1..=AXES {
            let name = format!("{variable}[{axis}]");
            if component.variable(&name).is_none() {
                return Err(format!("{path}: {host} has no variable {name}: is it the machine?"));
            }
        }
    }
    let named = config.system.own_thread.iter().map(|name| ("system.own_thread", name));
    let told = config.safety.told_faults.keys().map(|name| ("safety.told_faults", name));
    for (key, name) in named.chain(told) {
        if system.component(name).is_none() {
            return Err(format!("{key}: no component {name:?}, there are {:?}", names()));
        }
    }
    let (wait, step_us) = (config.bus.reply_timeout_us, system.base_step() * 1e6);
    if f64::from(wait) >= step_us {
        return Err(format!(
            "bus.reply_timeout_us = {wait}, allowed less than {step_us:.0}, one cycle of {path}"
        ));
    }
    for component in system.components() {
        let Some(most) = component.parameter("tau_max") else {
            continue;
        };
        if component.name() == host.as_str() {
            continue;
        }
        let key = format!("{}.tau_max", component.name());
        let most = config.system.parameters.get(&key).copied().unwrap_or(most);
        for axis in 0..AXES {
            let limit = config.limits(axis).torque;
            if most > limit {
                return Err(format!(
                    "limits.torque_N_m = {limit} of axis {}: {key} = {most} may ask for more: \
                     lower it in [system.parameters] or raise the limit",
                    axis + 1
                ));
            }
        }
    }
    teller.mark(true, &format!("{path}: {} components, {step_us:.0} us a cycle", names().len()));
    Ok(system)
}

/// Signals that the recording adds, with their units.
pub fn more(config: &Config, controller: &Controller) -> Vec<(String, String)> {
    let unit = |name: &String| {
        let slot = controller.slot(name);
        slot.map_or("1".to_owned(), |slot| controller.units()[slot].clone())
    };
    config.recorder.signals.iter().map(|name| (name.clone(), unit(name))).collect()
}

/// Which signal of the system each channel is, and every how many base steps it changes:
/// `theta=plant.theta:1 ...`, for programs that compare a recording with a simulation.
pub fn named(config: &Config, system: &System) -> String {
    let (s, host) = (&config.system, &config.system.host);
    let mut channels = vec![
        ("theta".to_owned(), format!("{host}.theta")),
        ("tau_meas".to_owned(), format!("{host}.tau_meas")),
        ("r".to_owned(), s.reference.clone()),
        ("tau_ff".to_owned(), s.feedforward.clone()),
        ("e".to_owned(), s.following_error.clone()),
    ];
    for name in &config.recorder.signals {
        let whole = name.split('[').next().unwrap_or(name).to_owned();
        if !channels.iter().any(|(channel, _)| *channel == whole) {
            channels.push((whole.clone(), whole));
        }
    }
    let period = |signal: &str| {
        let component = signal.split('.').next().and_then(|name| system.component(name));
        component.map_or(1, |c| c.period())
    };
    let named =
        |(channel, signal): &(String, String)| format!("{channel}={signal}:{}", period(signal));
    channels.iter().map(named).collect::<Vec<_>>().join(" ")
}
