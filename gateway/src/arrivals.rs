//! Says where the machine has arrived, while the control loop goes on.

use flexhex_system::{Error, Kinematics, System};
use serde_json::json;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::thread;
use std::time::Duration;

use crate::config::Config;
use crate::report::Reporter;
use crate::tasks::{Arrivals, Arrived};

/// Time between two looks: the loop must not wake anybody, which takes a system call.
const LOOK: Duration = Duration::from_millis(20);

/// What a task tells its arrivals to: another thread reports them. `capacity`: as many as may come between two looks.
pub fn reported(
    reporter: Reporter,
    (config, system): (&Config, &System),
    capacity: usize,
) -> Result<Arrivals, Error> {
    let kinematics = Kinematics::of(system, &config.system.reference, "-arrivals")?;
    let (arrivals, told) = Arrivals::new(capacity);
    // it ends with the task
    thread::spawn(move || listen(reporter, kinematics, &told));
    Ok(arrivals)
}

fn listen(reporter: Reporter, mut kinematics: Option<Kinematics>, told: &Receiver<Arrived>) {
    loop {
        match told.try_recv() {
            Ok(arrived) => tell(reporter, kinematics.as_mut(), &arrived),
            Err(TryRecvError::Empty) => thread::sleep(LOOK),
            Err(TryRecvError::Disconnected) => return,
        }
    }
}

fn tell(reporter: Reporter, kinematics: Option<&mut Kinematics>, arrived: &Arrived) {
    let Arrived { pose, theta } = arrived;
    let (axis, off) = farthest(pose, theta);
    let shown: Vec<_> = theta.iter().map(|angle| format!("{angle:9.5}")).collect();
    let text =
        format!("{} rad, axis {} is off by {off:+.5} rad, the most", shown.join(" "), axis + 1);
    reporter.live_over();
    reporter.line("arrived", &text);
    let mut value = json!({ "pose": pose, "theta": theta, "axis": axis + 1, "off_rad": off });
    // where the kinematics fail, the angles are told all the same
    let platform = kinematics.map(|k| [pose, theta].map(|angles| k.pose(angles).ok().flatten()));
    if let Some([Some(wanted), Some(is)]) = platform {
        reporter.line("platform", &is.to_string());
        value["x_E_ref"] = json!(wanted.position);
        value["phi_E_ref"] = json!(wanted.rotation);
        value["x_E"] = json!(is.position);
        value["phi_E"] = json!(is.rotation);
    }
    reporter.event("arrived", value);
}

/// The axis, from 0, whose angle differs most from the one that is wanted, and by how much.
fn farthest<const N: usize>(pose: &[f64; N], theta: &[f64; N]) -> (usize, f64) {
    let off = theta.iter().zip(pose).map(|(is, wanted)| is - wanted);
    let most = off.enumerate().max_by(|(_, one), (_, other)| one.abs().total_cmp(&other.abs()));
    most.unwrap_or((0, f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_that_is_off_most_is_told_with_its_sign() {
        assert_eq!(farthest(&[0.0, 0.5, 1.0], &[0.125, 0.25, 1.0]), (1, -0.25));
    }
}
