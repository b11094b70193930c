//! `jog`: moves by the keyboard, between lift-off and landing.

use clap::Args;
use flexhex_system::System;
use serde_json::json;
use std::fmt::{self, Display, Formatter};
use std::io::BufRead;
use std::sync::mpsc::{sync_channel, SyncSender};

use crate::arguments::ConfigArgs;
use crate::arrivals;
use crate::config::{Config, AXES};
use crate::exit::Exit;
use crate::obstacle::Obstacle;
use crate::option_error::OptionError;
use crate::platform::{Platform, PlatformError};
use crate::poses::{angles, of_platform, within, PoseError};
use crate::report::Reporter;
use crate::run;
use crate::session::PowerArgs;
use crate::tasks::{self, Order, Task, ORDERS};
use crate::workspace::Workspace;

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway jog gateway/machines/akd.toml --enable
  flexhex-gateway jog gateway/machines/akd.toml --enable --largest 0.01 --page 4850

Lines that it takes, each with Enter:
  3 0.01           axis 3 by 0.01 rad, at most --largest
  to 0,0,0,0,0,0   to this pose
  pose 0,0,310mm,0,2deg,0   to this pose of the platform, as in `move --pose`
  q                land, when the lines before it are done; so does the end of the input
Ctrl-C lands at once.
It says when it has arrived, with the angles that were measured there.

It begins in the neutral pose. Speed, torque and gains are those of [landing], the limits those of a run.";

#[derive(Args)]
pub struct Jog {
    #[command(flatten)]
    config: ConfigArgs,
    #[command(flatten)]
    options: PowerArgs,
    /// Largest step of an axis in rad.
    #[arg(long, value_name = "RAD", default_value_t = 0.05, allow_negative_numbers = true)]
    largest: f64,
}

/// Why a line is no order that is followed.
#[derive(Debug, PartialEq)]
enum LineError {
    Unknown(String),
    /// Larger than `--largest` [rad].
    Large {
        by: f64,
        largest: f64,
    },
    Pose(PoseError),
}

impl Display for LineError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            LineError::Unknown(line) => {
                write!(
                    f,
                    "{line:?}: write `3 0.01`, `to 0,0,0,0,0,0`, `pose 0,0,310mm,0,0,0` or `q`"
                )
            }
            LineError::Large { by, largest } => {
                write!(f, "{by} rad: allowed at most {largest} rad (--largest)")
            }
            LineError::Pose(why) => why.fmt(f),
        }
    }
}

/// Lift off, move as the lines of standard input say, land; the exit code of the command.
pub fn jog(args: &Jog) -> Exit {
    let (reporter, largest) = (args.config.reporter(), args.largest);
    let make = move |config: &Config, system: &System| {
        if !(largest > 0.0 && largest <= 1.0) {
            return Err(OptionError::Largest(largest).into());
        }
        let (sender, orders) = sync_channel(ORDERS);
        let config = config.clone();
        let opened = Workspace::open(&config, system, "-ways");
        let mut workspace = opened.map_err(|why| PoseError::Way(Obstacle::Failed(why)))?;
        go(workspace.as_mut(), &[0.0; AXES])?;
        let arrivals = arrivals::reported(reporter, (&config, system), ORDERS);
        let arrivals = arrivals.map_err(|why| PoseError::Way(Obstacle::Failed(why)))?;
        // a machine without it is moved by angles
        let platform = Platform::open(&config, system);
        // it ends with the process: a read of the keyboard cannot be cut short
        std::thread::spawn(move || {
            listen(reporter, (&config, workspace, platform), largest, &sender)
        });
        Ok(Task::Jog(tasks::Jog::new([0.0; AXES], orders, arrivals)))
    };
    run::instead((&args.config, args.options), false, make, |_, _, _, _| Ok(()))
}

fn go(workspace: Option<&mut Workspace>, pose: &[f64; AXES]) -> Result<(), PoseError> {
    workspace.map_or(Ok(()), |workspace| workspace.go(pose).map_err(PoseError::Way))
}

/// Passes the orders of standard input on until its end.
fn listen(
    reporter: Reporter,
    (config, mut workspace, mut platform): (
        &Config,
        Option<Workspace>,
        Result<Platform, PlatformError>,
    ),
    largest: f64,
    orders: &SyncSender<Order>,
) {
    let mut pose = [0.0; AXES];
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        if line.trim().is_empty() {
            continue;
        }
        let wanted = order(&line, &pose, (config, &mut platform), largest).and_then(|order| {
            if let Order::To(next) = &order {
                go(workspace.as_mut(), next).map_err(LineError::Pose)?;
            }
            Ok(order)
        });
        match wanted {
            Ok(order) => {
                if let Order::To(next) = order {
                    pose = next;
                    reporter.line("to", &format!("{next:.4?} rad"));
                }
                if orders.send(order).is_err() || order == Order::Land {
                    return;
                }
            }
            Err(why) => {
                reporter.mark(false, &why.to_string());
                reporter.event("not_done", json!({ "line": line, "message": why.to_string() }));
            }
        }
    }
}

/// The order of a line, from a pose.
fn order(
    line: &str,
    pose: &[f64; AXES],
    (config, platform): (&Config, &mut Result<Platform, PlatformError>),
    largest: f64,
) -> Result<Order, LineError> {
    let unknown = || LineError::Unknown(line.to_owned());
    let mut words = line.split_whitespace();
    let (first, rest) = (words.next().unwrap_or(""), words.collect::<Vec<_>>().join(""));
    let next = match (first, rest.as_str()) {
        ("q", "") => return Ok(Order::Land),
        ("pose", text) => {
            let platform = platform.as_mut().map_err(|why| PoseError::Platform(why.clone()));
            let angles = platform.and_then(|platform| of_platform(text, platform, config));
            angles.map_err(LineError::Pose)?
        }
        ("to", text) => angles(text).map_err(LineError::Pose)?,
        (axis, by) => {
            let axis = axis.parse().ok().filter(|k| (1..=AXES).contains(k)).ok_or_else(unknown)?;
            let by: f64 = by.parse().map_err(|_| unknown())?;
            // also of what is no number
            let small = by.abs() <= largest;
            if !small {
                return Err(LineError::Large { by, largest });
            }
            let mut next = *pose;
            next[axis - 1] += by;
            next
        }
    };
    within(&next, config).map(|()| Order::To(next)).map_err(LineError::Pose)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    #[test]
    fn lines_are_orders_or_told_why_not() {
        let config = parse(include_str!("../machines/akd.toml")).unwrap();
        let pose = [0.0, 0.0, 0.5, 0.0, 0.0, 0.0];
        let at = |line: &str| order(line, &pose, (&config, &mut Err(PlatformError::NoFmu)), 0.05);
        assert_eq!(at(" 3  -0.05 "), Ok(Order::To([0.0, 0.0, 0.45, 0.0, 0.0, 0.0])));
        assert_eq!(at("to 0,0,0, 0,0,0.1"), Ok(Order::To([0.0, 0.0, 0.0, 0.0, 0.0, 0.1])));
        assert_eq!(at("q"), Ok(Order::Land));
        for (line, why) in [
            ("3 0.06", "allowed at most 0.05 rad"),
            ("3 NaN", "allowed at most 0.05 rad"),
            ("3 0.03", "axis 3: 0.53 rad, allowed -0.52 to 0.52 rad"),
            ("7 0.01", "write `3 0.01`"),
            ("3", "write `3 0.01`"),
            ("quit", "write `3 0.01`"),
            ("to 1,2", "write 6 angles in rad"),
            ("pose 0,0,0.3,0,0,0", "system.pose_fmu is missing"),
        ] {
            assert!(at(line).unwrap_err().to_string().contains(why), "{line}: {:?}", at(line));
        }
    }
}
