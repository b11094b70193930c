//! `home`: offsets of absolute encoders from a pose in which the machine is held.

use clap::Args;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use crate::arguments::ConfigArgs;
use crate::bus::{self, Encoder};
use crate::config::{Config, Homed, HomedAxis, AXES};
use crate::exit::{Ends, Exit, Refusal};
use crate::record::now;
use crate::referencing;
use crate::report::Reporter;
use crate::session::PowerArgs;
use crate::wire::Socket;

/// Readings of each encoder, and their largest spread [rad].
const READINGS: usize = 50;
const STILL: f64 = 1e-3;
pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway home gateway/machines/akd.toml                        # only show
  flexhex-gateway home gateway/machines/akd.toml --write akd-homing.toml
  flexhex-gateway home gateway/machines/akd.toml --at 0.1,0.1,0.1,0.1,0.1,0.1 --write h.toml

  flexhex-gateway home gateway/machines/akd.toml --stops --enable --write h.toml

With --stops the machine rests free, and the drives are enabled. Otherwise hold the machine in a known pose first, in a jig or on its stops. Then name the file in the
configuration: [homing] file = \"akd-homing.toml\". An old file is kept beside it, as akd-homing-old-1.toml.";

#[derive(Args)]
pub struct Home {
    #[command(flatten)]
    config: ConfigArgs,
    #[command(flatten)]
    options: PowerArgs,
    /// Lead each axis to its end stop at low torque (homing.torque_N_m), twice, and take its angle from there.
    #[arg(long, requires = "enable", conflicts_with = "at")]
    stops: bool,
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

/// Why no offset is found in a pose.
#[derive(Debug)]
enum HomeError {
    /// `--at` with these angles [rad].
    NoPose(Vec<f64>),
    /// Axes, from 0.
    NotRead(usize),
    /// An axis moved by this angle while it was read [rad].
    Moved(usize, f64),
}

impl Display for HomeError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            HomeError::NoPose(at) => {
                write!(f, "--at {at:?}: write {AXES} angles in rad, -10 to 10")
            }
            HomeError::NotRead(axis) => {
                write!(f, "axis {}: its encoder was not read: check the cable", axis + 1)
            }
            HomeError::Moved(axis, by) => write!(
                f,
                "axis {}: it moved by {by:.6} rad while it was read, allowed {STILL} rad: hold the \
                 machine still",
                axis + 1
            ),
        }
    }
}

impl Ends for HomeError {
    fn exit(&self) -> Exit {
        match self {
            HomeError::NoPose(_) => Exit::Usage,
            _ => Exit::Failed,
        }
    }
}

/// Find the offsets of the encoders and tell, or write, them; the exit code of the command.
pub fn home(args: &Home) -> Exit {
    if args.stops {
        return referencing::at_stops(&args.config, args.options, args.write.as_deref());
    }
    let reporter = args.config.reporter();
    match offsets(args, reporter) {
        Ok(()) => Exit::Good,
        Err(why) => {
            reporter.refused(&why);
            why.exit
        }
    }
}

fn offsets(args: &Home, reporter: Reporter) -> Result<(), Refusal> {
    let config = args.config.read_unhomed()?;
    let pose = <[f64; AXES]>::try_from(args.at.as_slice());
    let pose = pose.ok().filter(|pose| pose.iter().all(|angle| angle.abs() <= 10.0));
    let pose = pose.ok_or_else(|| HomeError::NoPose(args.at.clone()))?;
    let socket = Socket::open(&config.bus.interface)?;
    let encoders =
        bus::positions(&config, socket, READINGS, &mut |devices| reporter.devices(devices))?;
    let homed = find(&config, &encoders, pose, now())?;
    referencing::tell(reporter, &config, &homed, args.write.as_deref())?;
    Ok(())
}

/// The offsets with which encoders that stand still show this pose.
fn find(
    config: &Config,
    encoders: &[Encoder; AXES],
    pose: [f64; AXES],
    date: String,
) -> Result<Homed, HomeError> {
    let step = config.theta_step();
    let mut axes = Vec::with_capacity(AXES);
    for (k, (encoder, drive)) in encoders.iter().zip(&config.drive).enumerate() {
        let Some(first) = encoder.counts.first() else {
            return Err(HomeError::NotRead(k));
        };
        // counts wrap: their distances from the first do not
        let moved = encoder.counts.iter().map(|c| f64::from(c.wrapping_sub(*first)));
        let (low, high) = moved.clone().fold((0.0f64, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
        let spread = (high - low) * step;
        if spread > STILL {
            return Err(HomeError::Moved(k, spread));
        }
        let mean = moved.sum::<f64>() / encoder.counts.len() as f64;
        let wanted = f64::from(drive.direction) * pose[k] / step;
        let shift = (mean - wanted).round() as i64 as i32;
        axes.push(HomedAxis { serial: encoder.serial, offset_counts: first.wrapping_add(shift) });
    }
    Ok(Homed { date, method: "pose".to_owned(), pose_rad: pose, sum: None, axis: axes })
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
                let homed_at = find(&config, &encoders(&[counts]), pose, String::new()).unwrap();
                let mut homed = config.clone();
                for (drive, axis) in homed.drive.iter_mut().zip(&homed_at.axis) {
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
        let homed_at = |moved| find(&config, &near(moved), [0.0; AXES], String::new());
        assert_eq!(
            homed_at(683_565).unwrap().axis[0].offset_counts,
            i32::MAX.wrapping_add(227_855)
        );
        assert!(homed_at(683_566)
            .unwrap_err()
            .to_string()
            .contains("axis 1: it moved by 0.001000 rad"));
    }
}
