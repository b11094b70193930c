//! `check`: finds what is wrong before the drives have power.

use clap::Args;
use serde_json::json;
use std::time::Duration;

use crate::answering::Answering;
use crate::arguments::ConfigArgs;
use crate::bus::{self, BringUpOptions, Difference, Lists};
use crate::cycle::{signals, Signals};
use crate::exit::{Exit, Refusal};
use crate::learned;
use crate::planned;
use crate::report::Reporter;
use crate::rights;
use crate::session;
use crate::wire::Socket;

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway check gateway/machines/akd.toml
  flexhex-gateway check gateway/machines/akd.toml --interface eth1 --bus
  flexhex-gateway check gateway/machines/akd.toml --bus --diff     # what the drives hold instead
  flexhex-gateway check gateway/machines/akd.toml --bus --write    # write it and store it there";

#[derive(Args)]
pub struct Check {
    #[command(flatten)]
    config: ConfigArgs,
    /// Also read identity, order and state of the drives; nothing is enabled.
    #[arg(long)]
    bus: bool,
    /// Print every object of the start-up lists that differs in a drive.
    #[arg(long, requires = "bus")]
    diff: bool,
    /// Write the start-up lists to the drives and store them there (object 0x1010).
    #[arg(long, requires = "bus")]
    write: bool,
}

/// Run all checks and print each result.
pub fn check(args: &Check) -> Exit {
    let reporter = args.config.reporter();
    reporter.title("flexhex-gateway check");
    match without_power(args, reporter) {
        Ok(()) => {
            reporter.mark(true, "all checks passed");
            reporter.event("checked", json!({ "good": true }));
            Exit::Good
        }
        Err(why) => {
            reporter.refused(&why);
            why.exit
        }
    }
}

fn without_power(args: &Check, reporter: Reporter) -> Result<(), Refusal> {
    let config = args.config.read()?;
    reporter.mark(true, "configuration");
    let preparing = Answering::before_power(reporter);
    let system = session::open_system(&config, reporter)?;
    let resume = learned::resumed(&config)?;
    let controller = signals::open(&config, &system, true, resume)?;
    let signals = Signals::find(&config, &controller)?;
    session::mechanics(&config, &system)?;
    planned::judge_lift_off(&config, &system, &signals.r.map(|slot| controller.bus()[slot]))??;
    drop(controller);
    drop(preparing);
    reporter.mark(true, "every FMU loads and initialises");
    let pose_fmu = config.system.pose_fmu.as_ref().filter(|file| !file.is_file());
    if let Some(file) = pose_fmu {
        let text = format!(
            "{}: no such file (system.pose_fmu): `move --pose` needs it, and `pose` in `jog`: `flexhex build` makes it",
            file.display()
        );
        reporter.line("note", &text);
    }
    for note in rights::request_real_time(&config, false, false)? {
        reporter.line("note", &note.to_string());
    }
    let socket = Socket::open(&config.bus.interface)?;
    reporter.mark(true, &format!("interface {}", config.bus.interface));
    if args.bus {
        let options = BringUpOptions {
            cycle: Duration::from_secs_f64(system.base_step()),
            lockstep: true,
            reset_faults: false,
            replayed: false,
            cyclic: false,
        };
        let lists = if args.write { Lists::Write } else { Lists::Compare };
        let found = bus::inspect(&config, socket, options, lists, &mut |devices, links| {
            reporter.devices(devices);
            reporter.links(links);
        })?;
        for (axis, position, why) in &found.uncompared {
            reporter.line("note", &format!("drive {position}: axis {}: {why}", axis + 1));
            reporter.event(
                "uncompared",
                json!({ "axis": axis + 1, "position": position, "message": why }),
            );
        }
        startup_lists(args, reporter, &found.differences);
        reporter.mark(true, "the drives match the configuration and have no power");
    }
    Ok(())
}

/// What the start-up lists changed or would change.
fn startup_lists(args: &Check, reporter: Reporter, differences: &[(usize, u16, Difference)]) {
    for (axis, position, d) in differences.iter().filter(|_| args.diff) {
        let text = format!("{} is {}, expected {}", d.what, d.actual, d.expected);
        reporter.line(&format!("drive {position}"), &format!("axis {}: {text}", axis + 1));
        reporter.event(
            "difference",
            json!({ "axis": axis + 1, "position": position, "what": d.what, "actual": d.actual,
                "expected": d.expected }),
        );
    }
    let n = differences.len();
    if args.write {
        reporter.mark(true, &format!("start-up lists: {n} objects written; all are stored"));
    } else if n == 0 {
        reporter.mark(true, "start-up lists: every object is as configured");
    } else {
        let more = if args.diff { "" } else { " (--diff prints them)" };
        reporter.line(
            "note",
            &format!(
                "{n} objects of the start-up lists differ{more}: `run` writes \
            them each time, `check --bus --write` stores them"
            ),
        );
    }
}
