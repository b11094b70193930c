//! Signals of the system description that the control loop uses.

use flexhex_system::{
    Bounds, Controller, Late, Options, State, System, Trip as Failure, Value, What,
};
use std::time::Duration;

use crate::config::{self, Config, PoseLimit, AXES};
use crate::mismatch::Mismatch;
use crate::rules::Reason;

/// Longest wait for a thread and longest FMU step in lockstep: no clock applies there, but a
/// component that hangs must be reported.
const LOCKSTEP_LIMIT: Duration = Duration::from_secs(1);

/// Slots of the signals by axis, and of the further signals of the recording.
pub struct Signals {
    pub r: [usize; AXES],
    pub e: [usize; AXES],
    pub tau_ff: [usize; AXES],
    /// Of the limits of the pose.
    pub pose: Vec<usize>,
    pub more: Vec<usize>,
}

impl Signals {
    /// Err names the key of the configuration whose signal does not exist, or is of another unit.
    pub fn find(config: &Config, controller: &Controller) -> Result<Signals, Mismatch> {
        let s = &config.system;
        let by_axis = |key: &str, name: &str, unit: &'static str| {
            let mut slots = [0; AXES];
            for (axis, entry) in slots.iter_mut().enumerate() {
                let signal = format!("{name}[{}]", axis + 1);
                *entry = slot(controller, key, &signal)?;
                check_unit(controller, key, *entry, unit)?;
            }
            Ok::<_, Mismatch>(slots)
        };
        Ok(Signals {
            r: by_axis("system.reference", &s.reference, "rad")?,
            e: by_axis("system.following_error", &s.following_error, "rad")?,
            tau_ff: by_axis("system.feedforward", &s.feedforward, "N m")?,
            pose: poses(config, controller)?,
            more: config
                .recorder
                .signals
                .iter()
                .map(|name| slot(controller, "recorder.signals", name))
                .collect::<Result<_, _>>()?,
        })
    }
}

/// Slots of the signals in `config.pose`; refused where the machine would start outside.
fn poses(config: &Config, controller: &Controller) -> Result<Vec<usize>, Mismatch> {
    let place = |(k, limit): (usize, &PoseLimit)| {
        let key = format!("pose[{k}].signal");
        let slot = slot(controller, &key, &limit.signal)?;
        let value = controller.bus()[slot];
        match limit.allows(value) {
            true => Ok(slot),
            false => {
                let signal = limit.signal.clone();
                Err(Mismatch::Start { key, signal, value, min: limit.min, max: limit.max })
            }
        }
    };
    config.pose.iter().enumerate().map(place).collect()
}

fn slot(controller: &Controller, key: &str, signal: &str) -> Result<usize, Mismatch> {
    controller.slot(signal).ok_or_else(|| {
        let names = controller.signals().iter().filter(|name| name.ends_with("[1]"));
        let near = names.take(8).map(ToString::to_string).collect();
        Mismatch::NoSignal { key: key.to_owned(), signal: signal.to_owned(), near }
    })
}

/// A signal of another unit is another quantity, and the rules would judge it as this one.
fn check_unit(
    controller: &Controller,
    key: &str,
    slot: usize,
    wanted: &'static str,
) -> Result<(), Mismatch> {
    let (names, units) = (controller.signals(), controller.units());
    if units[slot] == wanted {
        return Ok(());
    }
    let near =
        names.iter().zip(units).filter(|(name, unit)| *unit == wanted && name.ends_with("[1]"));
    let near = near.take(8).map(|(name, _)| name.trim_end_matches("[1]").to_owned()).collect();
    let (signal, unit) = (names[slot].clone(), units[slot].clone());
    Err(Mismatch::Unit { key: key.to_owned(), signal, unit, wanted, near })
}

/// The controller of a system, with the quantisation steps of the drives set in every component
/// that has these parameters.
/// resume: states of an earlier run.
pub fn open(
    config: &Config,
    system: &System,
    lockstep: bool,
    resume: Vec<State>,
) -> Result<Controller, Mismatch> {
    let steps =
        [("tau_step", config.profile.scale.tau_step()), ("theta_step", config.theta_step())];
    let mut parameters = Vec::new();
    for component in system.components() {
        for (name, value) in steps {
            if component.parameter(name).is_some() {
                parameters.push((format!("{}.{name}", component.name()), Value::Number(value)));
            }
        }
    }
    let priority = config.real_time.priority;
    let options = Options {
        own_thread: config.system.own_thread.clone(),
        wait: if lockstep { LOCKSTEP_LIMIT } else { Duration::ZERO },
        late: match config.system.late {
            config::Late::Hold => Late::Hold,
            config::Late::Trip => Late::Trip,
        },
        bounds: Some(Bounds {
            range: config.estimate.range,
            innovation: config.estimate.innovation,
        }),
        late_limit: Some(config.system.late_limit),
        resume,
        step_limit: if lockstep {
            Some(LOCKSTEP_LIMIT)
        } else {
            config.system.step_limit_us.map(|us| Duration::from_micros(us.into()))
        },
        parameters,
        fault_trips: false,
        on_thread: (priority > 1).then(|| {
            let below: flexhex_system::ThreadHook = std::sync::Arc::new(move |_: &str| {
                // without the right the thread has normal priority; the note of the control loop says so
                let _ = crate::realtime::set_fifo((priority - 20).max(1));
            });
            below
        }),
    };
    Controller::open(system, &config.system.host, options).map_err(Mismatch::System)
}

/// Reason and value of a failure of the controller.
pub fn reason(failure: &Failure) -> (Reason, f64) {
    match failure.what {
        What::Error => (Reason::FmuError, 0.0),
        What::NotFinite => (Reason::NotFinite, 0.0),
        What::Fault(value) => (Reason::FmuFault, value),
        What::Late => (Reason::LateThread, 0.0),
        What::Overrun(took) => (Reason::FmuOverrun, took.as_secs_f64() * 1e6),
    }
}
