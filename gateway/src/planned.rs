//! The motion of a run, judged before power: its lift-off, its poses, and every stop that may begin on the way.

use flexhex_system::{Planned, System};
use serde_json::json;
use std::fmt::{self, Display, Formatter};
use std::time::{Duration, Instant};

use crate::config::{Config, AXES};
use crate::exit::{Ends, Exit};
use crate::mismatch::Mismatch;
use crate::obstacle::Obstacle;
use crate::realtime::stop;
use crate::report::Reporter;
use crate::workspace::Workspace;

/// Stops that are judged begin as often in the time of a brake: what they take hardly changes between two of them.
const PER_BRAKE: f64 = 8.0;

/// A run waits no longer than this for its judgement: that of half a day takes about a minute.
const LONGEST: Duration = Duration::from_secs(60);

/// Time between two reports of how far it is, and before the first.
const REPORT: Duration = Duration::from_secs(1);

/// A run that is not begun: when [s] the motion meets what.
#[derive(Debug)]
pub struct Unfit {
    time: f64,
    obstacle: Obstacle,
}

/// A lift-off that the machine cannot do.
#[derive(Debug)]
pub struct NoLift(Obstacle);

/// Err where the torque of a lift-off does not carry the machine to the start of the motion [rad]. Without a model in the
/// system the lift-off alone judges it.
pub fn judge_lift_off(
    config: &Config,
    system: &System,
    start: &[f64; AXES],
) -> Result<Result<(), NoLift>, Mismatch> {
    let workspace = Workspace::open(config, system, "-lift").map_err(Mismatch::System)?;
    Ok(workspace.map_or(Ok(()), |mut workspace| workspace.lifts(start).map_err(NoLift)))
}

/// Err with the first pose or stop that the machine cannot take. A motion that is not known before is said to be.
/// Signals end the program meanwhile, also one that waits for an FMU that hangs: no drive has power.
pub fn judge(
    reporter: Reporter,
    config: &Config,
    system: &System,
    cycles: i64,
) -> Result<Result<(), Unfit>, Mismatch> {
    stop::end_by_default();
    let judged = judge_cycles(reporter, config, system, cycles);
    stop::listen();
    judged
}

fn judge_cycles(
    reporter: Reporter,
    config: &Config,
    system: &System,
    cycles: i64,
) -> Result<Result<(), Unfit>, Mismatch> {
    let workspace = Workspace::open(config, system, "-ahead").map_err(Mismatch::System)?;
    let planned = Planned::of(system, &config.system.host, &config.system.reference);
    let (Some(mut workspace), Some(mut planned)) = (workspace, planned.map_err(Mismatch::System)?)
    else {
        reporter.line("note", "the motion cannot be judged before power: the run alone judges it");
        return Ok(Ok(()));
    };
    let brake = f64::from(config.landing.brake_ms) * 1e-3;
    let every = ((brake / PER_BRAKE / system.base_step()) as i64).max(1);
    let (mut last, mut progress) = (None, Progress::new(reporter, system.base_step(), cycles));
    for cycle in 0..cycles {
        let motion = planned.motion();
        if cycle % every == 0 && !progress.goes_on(cycle) {
            break;
        }
        // a reference that holds is judged once
        if cycle % every == 0 && last != Some(motion) {
            if let Err(obstacle) = workspace.stops_from(&motion) {
                let time = cycle as f64 * system.base_step();
                return Ok(Err(Unfit { time, obstacle }));
            }
            last = Some(motion);
        }
        planned.step().map_err(Mismatch::System)?;
    }
    Ok(Ok(()))
}

/// How far the judgement is, where it takes long.
struct Progress {
    reporter: Reporter,
    base_step: f64,
    cycles: i64,
    begin: Instant,
    reports: u32,
}

impl Progress {
    fn new(reporter: Reporter, base_step: f64, cycles: i64) -> Progress {
        Progress { reporter, base_step, cycles, begin: Instant::now(), reports: 0 }
    }

    /// Reports once a second; false where it has taken too long.
    fn goes_on(&mut self, cycle: i64) -> bool {
        let taken = self.begin.elapsed();
        if taken < REPORT * (self.reports + 1) {
            return true;
        }
        self.reports += 1;
        let (time, all) = (cycle as f64 * self.base_step, self.cycles as f64 * self.base_step);
        if self.reports == 1 {
            let text = format!("the motion of {all:.0} s, before power: Ctrl-C ends it");
            self.reporter.line("judging", &text);
        }
        self.reporter.live("judging", &format!("{time:.0} of {all:.0} s"));
        self.reporter.event("judging", json!({ "time_s": time, "of_s": all }));
        if taken < LONGEST {
            return true;
        }
        let most = LONGEST.as_secs();
        let text = format!(
            "only the first {time:.0} s of the motion were judged before power, as that took {most} s: the run \
             alone judges the rest"
        );
        self.reporter.live_over();
        self.reporter.line("note", &text);
        self.reporter.event("note", json!({ "message": text }));
        false
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if self.reports > 0 {
            self.reporter.live_over();
        }
    }
}

impl Display for Unfit {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let Unfit { time, obstacle } = self;
        write!(f, "the motion of the run, {time:.3} s after its begin: ")?;
        match obstacle {
            Obstacle::Singular { .. } | Obstacle::Position { .. } => {
                write!(f, "if it is stopped then: {obstacle}: make the motion slower or smaller there")
            }
            Obstacle::Torque { .. } => write!(
                f,
                "if it is stopped then: {obstacle}: make the motion slower there, or raise landing.brake_ms or \
                 landing.torque_N_m"
            ),
            _ => write!(f, "{obstacle}: correct the motion"),
        }
    }
}

impl Display for NoLift {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "lift-off to the start of the motion: {}", self.0)
    }
}

impl Ends for NoLift {
    fn exit(&self) -> Exit {
        Exit::BadInput
    }
}

impl Ends for Unfit {
    fn exit(&self) -> Exit {
        Exit::BadInput
    }
}
