//! `calibrate torque`: the torque constant from what a known mass adds to the holding torques.

use clap::Args;
use flexhex_system::{Plant, System, Value};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

use crate::arguments::ConfigArgs;
use crate::arrivals;
use crate::config::{Config, AXES};
use crate::cycle::Outcome;
use crate::exit::{Exit, Refusal};
use crate::file_error::FileError;
use crate::motion::Mover;
use crate::record::now;
use crate::report::Reporter;
use crate::run;
use crate::saved::save;
use crate::session::{self, PowerArgs};
use crate::tasks::{Arrivals, Poses, Seen, Step, Task};
use crate::torque_error::TorqueError;

/// The pose is reached from either side by this way [rad], so that friction cancels.
const AROUND: f64 = 0.02;
/// Poses that it goes to.
const POSES: usize = 4;
/// Time for which a pose is held [s].
const HOLD: f64 = 2.0;
/// Smallest torque [N m] that a mass must add to an axis, for a ratio that means something.
const ENOUGH: f64 = 0.05;

#[derive(Args)]
pub struct Torque {
    #[command(flatten)]
    config: ConfigArgs,
    #[command(flatten)]
    options: PowerArgs,
    /// Known mass in kg, bolted where the machine file says (c_payload). 0: the run without it.
    #[arg(long, value_name = "KG", default_value_t = 0.0)]
    mass: f64,
    /// What the run without the mass wrote.
    #[arg(long, value_name = "FILE")]
    against: Option<PathBuf>,
    /// Write what was measured to this file.
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
}

/// The file of a run.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Record {
    date: String,
    mass_kg: f64,
    /// Torque constant or rated torque under which the torques were read.
    scale: f64,
    serial: [u32; AXES],
    /// Means of a rising and a falling approach to the neutral pose.
    #[serde(rename = "holding_N_m")]
    holding: [f64; AXES],
    /// Torque constant, or rated torque, by axis; only of a run with a mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    scales: Option<[f64; AXES]>,
}

/// Hold the neutral pose and compare; the exit code of the command.
pub fn find(args: &Torque) -> Exit {
    let make = |config: &Config, system: &System| {
        usage(args)?;
        let arrivals = arrivals::reported(args.config.reporter(), (config, system), POSES)?;
        Ok(Task::Poses(poses(system, arrivals)))
    };
    let tell = |reporter: Reporter, config: &Config, system: &System, out: &Outcome| {
        measure(args, reporter, (config, system), out)
    };
    run::instead((&args.config, args.options), false, make, tell)
}

fn usage(args: &Torque) -> Result<(), TorqueError> {
    if !(0.0..=50.0).contains(&args.mass) {
        return Err(TorqueError::Mass(args.mass));
    }
    if (args.mass > 0.0) != args.against.is_some() {
        return Err(TorqueError::Alone);
    }
    args.against.as_deref().map_or(Ok(()), |file| read(file).map(|_| ()))
}

fn read(file: &Path) -> Result<Record, TorqueError> {
    let text = std::fs::read_to_string(file).map_err(FileError::of(file));
    let record: Record = toml::from_str(&text.map_err(TorqueError::Unreadable)?)
        .map_err(|why| TorqueError::NoRecord(file.to_owned(), why))?;
    match record.mass_kg {
        0.0 => Ok(record),
        mass => Err(TorqueError::Loaded(file.to_owned(), mass)),
    }
}

fn measure(
    args: &Torque,
    reporter: Reporter,
    (config, system): (&Config, &System),
    out: &Outcome,
) -> Result<(), Refusal> {
    let Task::Poses(poses) = &out.task else { return Ok(()) };
    let holding = holding(poses);
    let (name, scale) = config.profile.scale.named();
    let mut record = Record {
        date: now(),
        mass_kg: args.mass,
        scale,
        serial: out.serials,
        holding,
        scales: None,
    };
    let mut measured = None;
    reporter.line("holding", &format!("{holding:.3?} N m"));
    if let Some(file) = &args.against {
        let empty = read(file)?;
        let added = added(config, system, args.mass)?;
        let scales = compare(&record, &empty, &added)?;
        let mean = scales.iter().sum::<f64>() / AXES as f64;
        let spread = scales.iter().fold(0.0, |far: f64, c| far.max((c / mean - 1.0).abs()));
        reporter.line("by axis", &format!("{scales:.4?}"));
        reporter.line(
            "mean",
            &format!(
                "{name} = {mean:.4} (configuration: {scale}), axes within {:.1} %",
                100.0 * spread
            ),
        );
        reporter.event(
            "torque_constant",
            json!({"scales": scales, "mean": mean, "spread": spread, "added": added}),
        );
        (record.scales, measured) = (Some(scales), Some(mean));
    }
    if let Some(path) = &args.write {
        let head =
            "Holding torques of the neutral pose, written by `flexhex-gateway calibrate torque`.";
        save(path, head, &record)?;
    }
    match measured {
        Some(mean) if !config.profile.scale.agrees(mean) => {
            Err(TorqueError::OtherScale { name, mean, scale }.into())
        }
        _ => Ok(()),
    }
}

/// Torque constant of each axis: the mass adds `added`, the drives measured the difference of the records.
fn compare(
    loaded: &Record,
    empty: &Record,
    added: &[f64; AXES],
) -> Result<[f64; AXES], TorqueError> {
    if (loaded.serial, loaded.scale) != (empty.serial, empty.scale) {
        return Err(TorqueError::OtherDrives);
    }
    let mut scales = [0.0; AXES];
    for axis in 0..AXES {
        let (adds, measured) = (added[axis], loaded.holding[axis] - empty.holding[axis]);
        if adds.abs() < ENOUGH {
            return Err(TorqueError::Light { axis, adds, needed: ENOUGH });
        }
        scales[axis] = loaded.scale * adds / measured;
        if !(scales[axis] > 0.2 * loaded.scale && scales[axis] < 5.0 * loaded.scale) {
            return Err(TorqueError::Impossible { axis, adds, measured });
        }
    }
    Ok(scales)
}

/// What a mass adds to the torques that hold the neutral pose [N m], by the plant of the system description.
fn added(config: &Config, system: &System, mass: f64) -> Result<[f64; AXES], TorqueError> {
    let [without, with] = [0.0, mass].map(|mass| weigh(config, system, mass));
    let (without, with) = (without?, with?);
    Ok(std::array::from_fn(|k| with[k] - without[k]))
}

/// Torque that holds the neutral pose with a mass [N m]: the same poses in a simulation.
fn weigh(config: &Config, system: &System, mass: f64) -> Result<[f64; AXES], TorqueError> {
    let schedule = [("count", 1.0), ("time[1]", 0.0), ("mass[1]", mass)];
    let parameters =
        schedule.map(|(name, value)| (format!("reference.payload_{name}"), Value::Number(value)));
    let opened = Plant::open(system, &config.system.host, None, &parameters);
    let mut plant = opened.map_err(TorqueError::NoPlant)?;
    let mechanics = session::mechanics(config, system).map_err(TorqueError::Mismatch)?;
    let mut poses = poses(system, Arrivals::new(POSES).0);
    let (mut theta, mut tau) = ([0.0; AXES], [0.0; AXES]);
    let Some(first) = poses.begin(&theta) else { return Ok(tau) };
    let path = first.path(mechanics.pace);
    let mut mover = Mover::new(mechanics, path, [0.0; AXES], [false; AXES]);
    loop {
        plant.read(&mut theta, &mut tau);
        mover.step(&theta, 0);
        plant.step(&mover.tau).map_err(TorqueError::Plant)?;
        let (tau_meas, left) = (&tau, mover.left());
        let seen = Seen { complete: true, theta: &theta, tau_meas, r: &mover.r, left };
        match poses.step(&seen) {
            Step::Go(leg) => mover.follow(leg.path(mechanics.pace)),
            Step::Over => return Ok(holding(&poses)),
            _ => {}
        }
    }
}

/// The neutral pose, from below and from above.
fn poses(system: &System, arrivals: Arrivals) -> Poses {
    let list: [_; POSES] = [-AROUND, 0.0, AROUND, 0.0].map(|angle| [angle; AXES]);
    Poses::new(list.to_vec(), HOLD, system.base_step(), arrivals)
}

/// Mean torque of the two approaches [N m].
fn holding(poses: &Poses) -> [f64; AXES] {
    match poses.stood[..] {
        [_, up, _, down] => std::array::from_fn(|k| 0.5 * (up.tau_meas[k] + down.tau_meas[k])),
        _ => [f64::NAN; AXES],
    }
}
