//! The offsets of the encoders: told, written, and found at the end stops by a run at low torque.

use flexhex_system::{Component, System};
use serde_json::json;
use std::path::Path;

use crate::arguments::ConfigArgs;
use crate::config::{Config, Homed, HomedAxis, AXES};
use crate::cycle::Outcome;
use crate::exit::{failed, Exit, Refusal};
use crate::record::now;
use crate::report::Reporter;
use crate::run;
use crate::session::PowerArgs;
use crate::tasks::{Search, Stops, Task};

/// Run against the end stops; the exit code of the command.
pub fn at_stops(config: &ConfigArgs, options: PowerArgs, write: Option<&Path>) -> Exit {
    let make = |config: &Config, system: &System| {
        let h = &config.homing;
        let side = stops(config, system)?[0].signum();
        let base_step = system.base_step();
        let (torque, speed, within) = (h.torque, h.speed, h.within);
        Ok(Task::Stops(Stops::new(Search { torque, speed, within, side, base_step })))
    };
    let told = |reporter: Reporter, config: &Config, system: &System, out: &Outcome| {
        let Task::Stops(found) = &out.task else { return Ok(()) };
        let homed = offsets(config, &stops(config, system)?, found, out);
        for (k, spread) in found.spread().iter().enumerate() {
            reporter.line(
                &format!("axis {}", k + 1),
                &format!("the two passes differ by {spread:.6} rad"),
            );
        }
        rest_pose(config, &homed)?;
        tell(reporter, config, &homed, write).map_err(failed)
    };
    run::instead((config, options), true, make, told)
}

/// Angles of the stops that are sought [rad].
fn stops(config: &Config, system: &System) -> Result<[f64; AXES], Refusal> {
    if let Some(stops) = config.homing.stop {
        return Ok(stops);
    }
    let host = system.component(&config.system.host);
    let stroke = host.and_then(|host: &Component| host.parameter("stroke"));
    let why =
        "homing.stop_rad: the system description knows no stroke: set the angles of the end stops";
    stroke.map(|stroke| [-stroke; AXES]).ok_or_else(|| (Exit::BadInput, why.to_owned()))
}

/// The offsets under which the axes stood at these angles.
fn offsets(config: &Config, stops: &[f64; AXES], found: &Stops, out: &Outcome) -> Homed {
    let (step, at) = (config.theta_step(), found.found());
    let mut homed = Homed {
        date: now(),
        method: "stops".to_owned(),
        pose_rad: [0.0; AXES],
        axis: Vec::with_capacity(AXES),
    };
    for k in 0..AXES {
        // the run began at angle 0, which is this one
        homed.pose_rad[k] = stops[k] - at[k];
        let counts = f64::from(config.drive[k].direction) * homed.pose_rad[k] / step;
        let offset_counts = out.offsets[k].wrapping_sub(counts.round() as i64 as i32);
        homed.axis.push(HomedAxis { serial: out.serials[k], offset_counts });
    }
    homed
}

/// Where the rest pose is known, it must be the one that was found.
fn rest_pose(config: &Config, homed: &Homed) -> Result<(), Refusal> {
    let Some(rest) = config.landing.rest else { return Ok(()) };
    let most = |k: usize| config.limits(k).following_error;
    let off = (0..AXES).find(|k| (rest[*k] - homed.pose_rad[*k]).abs() > most(*k));
    off.map_or(Ok(()), |k| {
        let why = format!(
            "axis {}: by its stop it rested at {:.4} rad, landing.rest_rad = {} rad: something else stopped \
             it, or homing.stop_rad is wrong",
            k + 1,
            homed.pose_rad[k],
            rest[k]
        );
        Err((Exit::Failed, why))
    })
}

/// Tells the offsets, and writes them to a file.
pub fn tell(
    reporter: Reporter,
    config: &Config,
    homed: &Homed,
    file: Option<&Path>,
) -> Result<(), String> {
    for (k, axis) in homed.axis.iter().enumerate() {
        let (old, new) = (config.drive[k].offset_counts, axis.offset_counts);
        reporter.line(
            &format!("axis {}", k + 1),
            &format!("serial {:<10} offset_counts = {new} (configuration: {old})", axis.serial),
        );
    }
    reporter.event("homed", json!(homed));
    let Some(path) = file else { return Ok(()) };
    write(path, "Offsets of the encoders, written by `flexhex-gateway home`.", homed)?;
    reporter.mark(true, &format!("{}: name it in [homing] file", path.display()));
    Ok(())
}

/// Writes the file; an older one is kept under a name with its time of change.
pub fn write(path: &Path, head: &str, content: &impl serde::Serialize) -> Result<(), String> {
    let failed = |why: std::io::Error| format!("{}: {why}: check the folder", path.display());
    let text = toml::to_string(content).map_err(|why| why.to_string())?;
    if path.exists() {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let old = |n: u32| path.with_file_name(format!("{stem}-old-{n}.toml"));
        let free = (1..).map(old).find(|name| !name.exists()).unwrap_or_else(|| old(0));
        std::fs::rename(path, free).map_err(failed)?;
    }
    std::fs::write(path, format!("# {head}\n{text}")).map_err(failed)
}
