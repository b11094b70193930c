//! `home`: offsets of absolute encoders from a pose in which the machine is held.

use clap::{ArgGroup, Args};
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use crate::arguments::ConfigArgs;
use crate::bus::drives::Drives;
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
  flexhex-gateway home gateway/machines/akd.toml                        # show those of the neutral pose
  flexhex-gateway home gateway/machines/akd.toml --at 0,0,0,0,0,0 --write akd-homing.toml
  flexhex-gateway home gateway/machines/akd.toml --rest --write akd-homing.toml  # then let go of it

  flexhex-gateway home gateway/machines/akd.toml --stops --enable --write h.toml

With --stops the machine rests free, and the drives are enabled. Otherwise hold the machine in a known pose first, in a jig or on its stops. Then name the file in the
configuration: [homing] file = \"akd-homing.toml\". Let go of the machine, and keep where it rests (--rest): from then on an
offset that is wrong is seen before power. An old file is kept beside it, as akd-homing-old-1.toml.";

#[derive(Args)]
#[group(skip)]
#[command(group(ArgGroup::new("what").args(["at", "stops", "rest"])))]
pub struct Home {
    #[command(flatten)]
    config: ConfigArgs,
    #[command(flatten)]
    options: PowerArgs,
    /// Lead each axis to its end stop at low torque (homing.torque_N_m), twice, and take its angle from there.
    #[arg(long, requires = "enable", conflicts_with = "at")]
    stops: bool,
    /// Angles of the pose in which the machine is held, six numbers in rad.
    #[arg(long, value_name = "RAD,...", value_delimiter = ',', allow_hyphen_values = true)]
    at: Option<Vec<f64>>,
    /// Read where the homed machine rests without power, and add it to the homing file.
    #[arg(long, conflicts_with_all = ["at", "stops"])]
    rest: bool,
    /// Write the offsets to this file; of a pose that is named (--at), of the end stops (--stops) or with --rest.
    #[arg(long, value_name = "FILE", requires = "what")]
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
    /// `--rest` without a homing file in the configuration.
    NotHomed,
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
            HomeError::NotHomed => f.write_str(
                "--rest: the offsets are not known: home the machine first, and name the file in homing.file",
            ),
        }
    }
}

impl Ends for HomeError {
    fn exit(&self) -> Exit {
        match self {
            HomeError::NoPose(_) | HomeError::NotHomed => Exit::Usage,
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
    let config = if args.rest { args.config.read()? } else { args.config.read_unhomed()? };
    let before = config.homed.clone().filter(|_| args.rest);
    if args.rest && before.is_none() {
        return Err(HomeError::NotHomed.into());
    }
    let at = args.at.clone().unwrap_or(vec![0.0; AXES]);
    let pose = <[f64; AXES]>::try_from(at.as_slice());
    let pose = pose.ok().filter(|pose| pose.iter().all(|angle| angle.abs() <= 10.0));
    let pose = pose.ok_or(HomeError::NoPose(at))?;
    let socket = Socket::open(&config.bus.interface)?;
    let encoders =
        bus::positions(&config, socket, READINGS, &mut |devices| reporter.devices(devices))?;
    let homed = match before {
        Some(before) => {
            let rest = rest(&config, &encoders)?;
            reporter.line("rest", &format!("{rest:.4?} rad"));
            Homed { rest_rad: Some(rest), ..before }
        }
        None => find(&config, &encoders, pose, now())?,
    };
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
        let wanted = f64::from(drive.direction) * pose[k] / step;
        let offset_counts = still(k, encoder, step, wanted)?;
        axes.push(HomedAxis { serial: encoder.serial, offset_counts });
    }
    let method = "pose".to_owned();
    Ok(Homed { date, method, pose_rad: pose, rest_rad: None, sum: None, axis: axes })
}

/// Angles of a homed machine that stands still [rad].
fn rest(config: &Config, encoders: &[Encoder; AXES]) -> Result<[f64; AXES], HomeError> {
    let (drives, mut angles) = (Drives::new(config), [0.0; AXES]);
    for (k, encoder) in encoders.iter().enumerate() {
        angles[k] = drives.angle(k, still(k, encoder, config.theta_step(), 0.0)?);
    }
    Ok(angles)
}

/// Mean counts of an encoder that stands still, less so many.
fn still(k: usize, encoder: &Encoder, step: f64, less: f64) -> Result<i32, HomeError> {
    let first = encoder.counts.first().ok_or(HomeError::NotRead(k))?;
    // counts wrap: their distances from the first do not
    let moved = encoder.counts.iter().map(|c| f64::from(c.wrapping_sub(*first)));
    let (low, high) = moved.clone().fold((0.0f64, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
    let spread = (high - low) * step;
    if spread > STILL {
        return Err(HomeError::Moved(k, spread));
    }
    let mean = moved.sum::<f64>() / encoder.counts.len() as f64;
    Ok(first.wrapping_add((mean - less).round() as i64 as i32))
}

#[cfg(test)]
mod tests {
    use super::*;
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
