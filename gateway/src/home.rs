//! `home`: offsets of absolute encoders from a pose in which the machine is held.

use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

use crate::arguments::ConfigArgs;
use crate::bus::{self, Encoder};
use crate::config::{Config, Homed, HomedAxis, AXES};
use crate::exit::Exit;
use crate::record::now;
use crate::report::Reporter;
use crate::wire::Socket;

/// Readings of each encoder, and their largest spread [rad].
const READINGS: usize = 50;
const STILL: f64 = 1e-3;
pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway home gateway/machines/akd.toml                        # only show
  flexhex-gateway home gateway/machines/akd.toml --write akd-homing.toml
  flexhex-gateway home gateway/machines/akd.toml --at 0.1,0.1,0.1,0.1,0.1,0.1 --write h.toml

Hold the machine in a known pose first, in a jig or on its stops. Then name the file in the
configuration: [homing] file = \"akd-homing.toml\". An old file is kept beside it, as akd-homing-old-1.toml.";

#[derive(Args)]
pub struct Home {
    #[command(flatten)]
    config: ConfigArgs,
    /// Angles of the pose in which the machine is held, six numbers in rad.
    #[arg(
        long,
        value_name = "RAD,...",
        value_delimiter = ',',
        allow_hyphen_values = true,
        default_value = "0,0,0,0,0,0"
    )]
    at: Vec<f64>,
    /// Write the offsets to this file.
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
}

/// Read the encoders and tell, or write, their offsets; the exit code of the command.
pub fn home(args: &Home) -> Exit {
    let reporter = args.config.reporter();
    match offsets(args, reporter) {
        Ok(()) => Exit::Good,
        Err((exit, why)) => {
            reporter.refused(&why);
            exit
        }
    }
}

fn offsets(args: &Home, reporter: Reporter) -> Result<(), (Exit, String)> {
    let config = args.config.read_unhomed().map_err(|why| (Exit::BadInput, why))?;
    let mut pose = [0.0; AXES];
    if args.at.len() != AXES || !args.at.iter().all(|angle| angle.abs() <= 10.0) {
        let why = format!("--at {:?}: write {AXES} angles in rad, -10 to 10", args.at);
        return Err((Exit::Usage, why));
    }
    pose.copy_from_slice(&args.at);
    let failed = |why| (Exit::Failed, why);
    let socket = Socket::open(&config.bus.interface).map_err(failed)?;
    let encoders =
        bus::positions(&config, socket, READINGS, &mut |devices| reporter.devices(devices))
            .map_err(failed)?;
    let homed = find(&config, &encoders, pose, now()).map_err(failed)?;
    for (k, axis) in homed.axis.iter().enumerate() {
        let (old, new) = (config.drive[k].offset_counts, axis.offset_counts);
        reporter.line(
            &format!("axis {}", k + 1),
            &format!("serial {:<10} offset_counts = {new} (configuration: {old})", axis.serial),
        );
    }
    reporter.event("homed", json!(homed));
    if let Some(path) = &args.write {
        write(path, &homed).map_err(failed)?;
        reporter.mark(true, &format!("{}: name it in [homing] file", path.display()));
    }
    Ok(())
}

/// The offsets with which encoders that stand still show this pose.
fn find(
    config: &Config,
    encoders: &[Encoder; AXES],
    pose: [f64; AXES],
    date: String,
) -> Result<Homed, String> {
    let step = config.theta_step();
    let mut axes = Vec::with_capacity(AXES);
    for (k, (encoder, drive)) in encoders.iter().zip(&config.drive).enumerate() {
        let Some(first) = encoder.counts.first() else {
            return Err(format!("axis {}: its encoder was not read", k + 1));
        };
        // counts wrap: their distances from the first do not
        let moved = encoder.counts.iter().map(|c| f64::from(c.wrapping_sub(*first)));
        let (low, high) = moved.clone().fold((0.0f64, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
        let spread = (high - low) * step;
        if spread > STILL {
            return Err(format!(
                "axis {}: it moved by {spread:.6} rad while it was read, allowed {STILL} rad: hold the \
                 machine still",
                k + 1
            ));
        }
        let mean = moved.sum::<f64>() / encoder.counts.len() as f64;
        let wanted = f64::from(drive.direction) * pose[k] / step;
        let shift = (mean - wanted).round() as i64 as i32;
        axes.push(HomedAxis { serial: encoder.serial, offset_counts: first.wrapping_add(shift) });
    }
    Ok(Homed { date, pose_rad: pose, axis: axes })
}

/// Writes the file; an older one is kept under a name with its time of change.
fn write(path: &Path, homed: &Homed) -> Result<(), String> {
    let failed = |why: std::io::Error| format!("{}: {why}: check the folder", path.display());
    let text = toml::to_string(homed).map_err(|why| why.to_string())?;
    if path.exists() {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let old = |n: u32| path.with_file_name(format!("{stem}-old-{n}.toml"));
        let free = (1..).map(old).find(|name| !name.exists()).unwrap_or_else(|| old(0));
        std::fs::rename(path, free).map_err(failed)?;
    }
    let head = "# Offsets of the encoders, written by `flexhex-gateway home`.\n";
    std::fs::write(path, format!("{head}{text}")).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::drives::Drives;
    use crate::config::parse;

    fn encoders(counts: &[i32]) -> [Encoder; AXES] {
        std::array::from_fn(|k| Encoder { serial: k as u32, counts: counts.to_vec() })
    }

    #[test]
    fn encoders_show_the_pose_afterwards_also_where_counts_wrap() {
        let mut config = parse(include_str!("../machines/akd.toml")).unwrap();
        config.drive[1].direction = -1;
        for counts in [0, 123_456_789, i32::MAX, i32::MIN, -1] {
            for pose in [[0.0; AXES], [0.3; AXES], [-0.34, 0.5, -0.5, 0.1, 0.2, -0.2]] {
                let found = find(&config, &encoders(&[counts]), pose, String::new()).unwrap();
                let mut homed = config.clone();
                for (drive, axis) in homed.drive.iter_mut().zip(&found.axis) {
                    drive.offset_counts = axis.offset_counts;
                }
                let drives = Drives::new(&homed);
                for (k, wanted) in pose.iter().enumerate() {
                    let off = drives.angle(k, counts) - wanted;
                    assert!(off.abs() <= 0.5 * config.theta_step(), "{k}: {off}");
                }
            }
        }
    }

    #[test]
    fn an_encoder_that_moves_is_refused_on_its_side_of_the_bound() {
        let config = parse(include_str!("../machines/akd.toml")).unwrap();
        // 1 mrad are 683 565 counts, here across the end of the range
        let near = |moved: i32| encoders(&[i32::MAX, i32::MAX.wrapping_add(moved), i32::MAX]);
        let found = |moved| find(&config, &near(moved), [0.0; AXES], String::new());
        assert_eq!(found(683_565).unwrap().axis[0].offset_counts, i32::MAX.wrapping_add(227_855));
        assert!(found(683_566).unwrap_err().contains("axis 1: it moved by 0.001000 rad"));
    }
}
