//! The offsets of the encoders: told, written, and found at the end stops by a run at low torque.

use flexhex_system::{Component, System};
use serde_json::json;
use std::fmt::{self, Display, Formatter};
use std::path::Path;

use crate::arguments::ConfigArgs;
use crate::config::{Config, Homed, HomedAxis, AXES, STOPS};
use crate::cycle::Outcome;
use crate::exit::{Ends, Exit};
use crate::record::now;
use crate::report::Reporter;
use crate::run;
use crate::saved::{save, SaveError};
use crate::session::PowerArgs;
use crate::tasks::{Search, Stops, Task};

/// Why the end stops give no offsets.
#[derive(Debug)]
enum StopsError {
    NoStroke,
    /// Angles of an axis, from 0, at rest: by its stop, and those of the configuration [rad].
    OtherRest {
        axis: usize,
        measured: f64,
        rest: f64,
    },
}

impl Display for StopsError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            StopsError::NoStroke => f.write_str(
                "homing.stop_rad: the system description knows no stroke: set the angles of the end stops",
            ),
            StopsError::OtherRest { axis, measured, rest } => write!(
                f,
                "axis {}: by its stop it rested at {measured:.4} rad, landing.rest_rad = {rest} rad: something \
                 else stopped it, or homing.stop_rad is wrong",
                axis + 1
            ),
        }
    }
}

impl Ends for StopsError {
    fn exit(&self) -> Exit {
        match self {
            StopsError::NoStroke => Exit::BadInput,
            StopsError::OtherRest { .. } => Exit::Failed,
        }
    }
}

/// Run against the end stops; the exit code of the command.
pub fn at_stops(config: &ConfigArgs, options: PowerArgs, write: Option<&Path>) -> Exit {
    let make = |config: &Config, system: &System| {
        let h = &config.homing;
        let side = stops(config, system)?[0].signum();
        let base_step = system.base_step();
        let (torque, speed, within) = (h.torque, h.speed, h.within);
        Ok(Task::Stops(Stops::new(Search { torque, speed, within, side, base_step })))
    };
    let report = |reporter: Reporter, config: &Config, system: &System, out: &Outcome| {
        let Task::Stops(measured) = &out.task else { return Ok(()) };
        let homed = offsets(config, &stops(config, system)?, measured, out);
        for (k, spread) in measured.spread().iter().enumerate() {
            reporter.line(
                &format!("axis {}", k + 1),
                &format!("the two passes differ by {spread:.6} rad"),
            );
        }
        rest_pose(config, &homed)?;
        tell(reporter, config, &homed, write)?;
        Ok(())
    };
    run::instead((config, options), true, make, report)
}

/// Angles of the stops that are sought [rad].
fn stops(config: &Config, system: &System) -> Result<[f64; AXES], StopsError> {
    if let Some(stops) = config.homing.stop {
        return Ok(stops);
    }
    let host = system.component(&config.system.host);
    let stroke = host.and_then(|host: &Component| host.parameter("stroke"));
    stroke.map(|stroke| [-stroke; AXES]).ok_or(StopsError::NoStroke)
}

/// The offsets under which the axes stood at these angles.
fn offsets(config: &Config, stops: &[f64; AXES], measured: &Stops, out: &Outcome) -> Homed {
    let (step, at) = (config.theta_step(), measured.angles());
    let mut homed = Homed {
        date: now(),
        method: STOPS.to_owned(),
        pose_rad: [0.0; AXES],
        rest_rad: None,
        sum: None,
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
fn rest_pose(config: &Config, homed: &Homed) -> Result<(), StopsError> {
    let Some(rest) = config.landing.rest else { return Ok(()) };
    let off = |k: usize| (rest[k] - homed.pose_rad[k]).abs();
    match (0..AXES).find(|k| off(*k) > config.limits(*k).following_error) {
        Some(axis) => {
            let (measured, rest) = (homed.pose_rad[axis], rest[axis]);
            Err(StopsError::OtherRest { axis, measured, rest })
        }
        None => Ok(()),
    }
}

/// Tells the offsets, and writes them to a file.
pub fn tell(
    reporter: Reporter,
    config: &Config,
    homed: &Homed,
    file: Option<&Path>,
) -> Result<(), SaveError> {
    for (k, axis) in homed.axis.iter().enumerate() {
        let (old, new) = (config.drive[k].offset_counts, axis.offset_counts);
        reporter.line(
            &format!("axis {}", k + 1),
            &format!("serial {:<10} offset_counts = {new} (configuration: {old})", axis.serial),
        );
    }
    reporter.event("homed", json!(homed));
    let Some(path) = file else { return Ok(()) };
    save(path, "Offsets of the encoders, written by `flexhex-gateway home`.", &homed.summed())?;
    reporter.mark(true, &format!("{}: name it in [homing] file", path.display()));
    Ok(())
}
