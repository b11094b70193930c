//! `move`: lifts off, moves through poses, and lands, by the feedback of the lift-off alone.

use clap::Args;
use flexhex_system::System;
use std::fmt::{self, Display, Formatter};

use crate::arrivals;
use crate::config::{Config, AXES};
use crate::exit::{Ends, Exit};
use crate::obstacle::Obstacle;
use crate::platform::{self, Platform, PlatformError};
use crate::report::Reporter;
use crate::tasks::{self, Task};
use crate::workspace::Workspace;

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway move gateway/machines/akd.toml --enable                     # to the neutral pose
  flexhex-gateway move gateway/machines/akd.toml --enable --axis 3 --by 0.02  # nudge one axis there
  flexhex-gateway move gateway/machines/akd.toml --enable --hold 5 \\
      --to 0,0,0,0,0,0 --to 0.1,0.1,0.1,0.1,0.1,0.1
  flexhex-gateway move gateway/machines/akd.toml --enable --pose 0,0,310mm,0,2deg,0   # of the platform

A pose of the platform is its position from the base and its rotation vector, as in files of motions; its angles are those of
system.pose_fmu. The way from pose to pose is straight in the angles, and its limits ([limits], [[pose]]) are checked before
power, with the way of the landing.

Speed, torque and gains are those of [landing], the limits those of a run. Ctrl-C lands. It says when it has arrived,
and at the end the mean angle and measured torque of each pose: compare them with and without a known
weight, and the direction of a nudge with the drawing.";

/// Poses of the command line.
#[derive(Args, Clone, Debug)]
pub struct Poses {
    /// Angles of a pose, six numbers in rad; may be repeated. Left out: the neutral pose.
    #[arg(long, value_name = "RAD,...", allow_hyphen_values = true)]
    to: Vec<String>,
    /// Pose of the platform: position from the base (m, mm, um) and rotation vector (rad, mrad, deg), each value with its
    /// unit or in m and rad; may be repeated.
    #[arg(long, value_name = "X,Y,Z,RX,RY,RZ", allow_hyphen_values = true, conflicts_with = "to")]
    pose: Vec<String>,
    /// Nudge this axis in the last pose, and go back.
    #[arg(long, value_name = "K", requires = "by")]
    axis: Option<usize>,
    /// Angle of the nudge in rad.
    #[arg(long, value_name = "RAD", requires = "axis", allow_negative_numbers = true)]
    by: Option<f64>,
    /// Time in seconds for which each pose is held.
    #[arg(long, value_name = "S", default_value_t = 2.0)]
    pub hold: f64,
}

/// Why a pose cannot be taken.
#[derive(Clone, Debug, PartialEq)]
pub enum PoseError {
    Hold(f64),
    /// `--axis`, from 1.
    NoAxis(usize),
    /// A text that is not six angles.
    NoAngles(String),
    /// An angle of an axis, from 0, and its limits.
    Outside {
        axis: usize,
        angle: f64,
        low: f64,
        high: f64,
    },
    /// The platform cannot take it.
    Way(Obstacle),
    /// A pose of the platform has no angles.
    Platform(PlatformError),
    /// Why the pose of a text cannot be taken.
    Of(String, Box<PoseError>),
}

impl Display for PoseError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            PoseError::Hold(time) => write!(f, "--hold {time}: allowed 0.1 to 3600 s"),
            PoseError::NoAxis(axis) => write!(f, "--axis {axis}: allowed 1 to {AXES}"),
            PoseError::NoAngles(text) => {
                write!(f, "{text}: write {AXES} angles in rad, with commas")
            }
            PoseError::Outside { axis, angle, low, high } => write!(
                f,
                "axis {}: {angle} rad, allowed {low} to {high} rad (limits.position_min_rad, \
                 position_max_rad)",
                axis + 1
            ),
            PoseError::Way(why @ (Obstacle::Failed(_) | Obstacle::Weight { .. })) => why.fmt(f),
            PoseError::Way(why) => write!(f, "on the way, {why}: take another way"),
            PoseError::Platform(why) => why.fmt(f),
            PoseError::Of(text, why) => write!(f, "pose {text}: {why}"),
        }
    }
}

impl From<PlatformError> for PoseError {
    fn from(why: PlatformError) -> PoseError {
        PoseError::Platform(why)
    }
}

impl Ends for PoseError {
    fn exit(&self) -> Exit {
        match self {
            PoseError::Platform(why) => why.exit(),
            PoseError::Of(_, why) => why.exit(),
            PoseError::Way(Obstacle::Weight { .. }) => Exit::BadInput,
            _ => Exit::Usage,
        }
    }
}

impl Poses {
    /// The task, or why a pose cannot be taken.
    pub fn task(
        &self,
        reporter: Reporter,
        config: &Config,
        system: &System,
    ) -> Result<Task, PoseError> {
        let open = || Platform::open(config, system);
        let list = self.list(config, open)?;
        let failed = |why| PoseError::Way(Obstacle::Failed(why));
        let opened = Workspace::open(config, system, "-ways");
        if let Some(mut workspace) = opened.map_err(failed)? {
            list.iter().try_for_each(|pose| workspace.go(pose)).map_err(PoseError::Way)?;
        }
        let arrivals = arrivals::reported(reporter, (config, system), list.len());
        let arrivals = arrivals.map_err(failed)?;
        Ok(Task::Poses(tasks::Poses::new(list, self.hold, system.base_step(), arrivals)))
    }

    fn list(
        &self,
        config: &Config,
        open: impl FnOnce() -> Result<Platform, PlatformError>,
    ) -> Result<Vec<[f64; AXES]>, PoseError> {
        if !(self.hold >= 0.1 && self.hold <= 3600.0) {
            return Err(PoseError::Hold(self.hold));
        }
        let mut poses = self.to.iter().map(|text| angles(text)).collect::<Result<Vec<_>, _>>()?;
        if !self.pose.is_empty() {
            let mut platform = open()?;
            for text in &self.pose {
                poses.push(of_platform(text, &mut platform, config)?);
            }
        }
        if poses.is_empty() {
            poses.push([0.0; AXES]);
        }
        if let (Some(axis), Some(by), Some(last)) = (self.axis, self.by, poses.last().copied()) {
            if !(1..=AXES).contains(&axis) {
                return Err(PoseError::NoAxis(axis));
            }
            let mut nudged = last;
            nudged[axis - 1] += by;
            poses.extend([nudged, last]);
        }
        poses.iter().try_for_each(|pose| within(pose, config))?;
        Ok(poses)
    }
}

/// Whether the position limits allow a pose.
pub fn within(pose: &[f64; AXES], config: &Config) -> Result<(), PoseError> {
    for (axis, angle) in pose.iter().enumerate() {
        let l = config.limits(axis);
        let (low, high) = (l.position_min, l.position_max);
        if !(low..=high).contains(angle) {
            return Err(PoseError::Outside { axis, angle: *angle, low, high });
        }
    }
    Ok(())
}

/// The angles of the platform's pose in a text, which the position limits allow.
pub fn of_platform(
    text: &str,
    platform: &mut Platform,
    config: &Config,
) -> Result<[f64; AXES], PoseError> {
    let mut angles = || {
        let wanted = platform::pose(text)?;
        let angles = platform.angles(&wanted)?;
        within(&angles, config)?;
        platform.judge(&angles, &wanted)?;
        Ok(angles)
    };
    angles().map_err(|why| PoseError::Of(text.to_owned(), Box::new(why)))
}

/// The angles of a pose in a text.
pub fn angles(text: &str) -> Result<[f64; AXES], PoseError> {
    let numbers = text.split(',').map(|number| number.trim().parse::<f64>());
    let numbers = numbers.collect::<Result<Vec<_>, _>>().unwrap_or_default();
    numbers.try_into().map_err(|_| PoseError::NoAngles(text.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    fn listed(
        to: &[&str],
        axis: Option<usize>,
        by: Option<f64>,
        hold: f64,
    ) -> Result<Vec<[f64; AXES]>, PoseError> {
        let config = parse(include_str!("../machines/akd.toml")).unwrap();
        let to = to.iter().map(|text| (*text).to_owned()).collect();
        Poses { to, pose: vec![], axis, by, hold }.list(&config, || Err(PlatformError::NoFmu))
    }

    #[test]
    fn a_nudge_goes_there_and_back() {
        assert_eq!(listed(&[], None, None, 1.0), Ok(vec![[0.0; AXES]]));
        let nudged = listed(&["0.1,0,0,0,0,-0.2"], Some(6), Some(0.05), 1.0).unwrap();
        assert_eq!(
            nudged.iter().map(|pose| pose[5]).collect::<Vec<_>>(),
            [-0.2, -0.15000000000000002, -0.2]
        );
        assert!(nudged.iter().all(|pose| pose[0] == 0.1));
    }

    #[test]
    fn what_cannot_be_taken_is_told() {
        let refusal =
            |to: &[&str], axis, by, hold| listed(to, axis, by, hold).unwrap_err().to_string();
        assert!(refusal(&["0,0"], None, None, 1.0).contains("write 6 angles"));
        assert!(refusal(&["0,0,0,0,0,x"], None, None, 1.0).contains("write 6 angles"));
        assert!(refusal(&["0,0,0,NaN,0,0"], None, None, 1.0).contains("axis 4: NaN rad"));
        assert!(
            refusal(&["0.521,0,0,0,0,0"], None, None, 1.0).contains("allowed -0.52 to 0.52 rad")
        );
        assert!(listed(&["0.52,0,0,0,0,-0.52"], None, None, 1.0).is_ok());
        assert!(refusal(&[], Some(7), Some(0.1), 1.0).contains("--axis 7: allowed 1 to 6"));
        assert!(refusal(&[], Some(1), Some(0.6), 1.0).contains("axis 1: 0.6 rad"));
        assert!(refusal(&[], None, None, f64::NAN).contains("--hold NaN"));
    }
}
