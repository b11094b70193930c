//! `status`: what a running gateway does, asked from another shell.

use clap::Args;
use serde_json::Value;
use std::time::Duration;

use crate::arguments::ConfigArgs;
use crate::config::AXES;
use crate::exit::{Exit, Refusal};
use crate::live::{self, LiveFault};
use crate::report::Reporter;

const PERIOD: Duration = Duration::from_millis(500);
pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway status gateway/machines/akd.toml
  flexhex-gateway status gateway/machines/akd.toml --interface eth1 --follow
  flexhex-gateway status gateway/machines/akd.toml --json

It only reads: a run is stopped by Ctrl-C or `kill`. In a browser: `run --page 4850`. Exit code 1: no
gateway runs on this interface.";

#[derive(Args)]
pub struct Status {
    #[command(flatten)]
    config: ConfigArgs,
    /// Ask twice a second until the run ends.
    #[arg(long)]
    follow: bool,
}

/// Ask and print; the exit code of the command.
pub fn status(args: &Status) -> Exit {
    let reporter = args.config.reporter();
    shown(args, reporter).map_or_else(
        |why| {
            reporter.refused(&why);
            why.exit
        },
        |()| Exit::Good,
    )
}

fn shown(args: &Status, reporter: Reporter) -> Result<(), Refusal> {
    let interface = args.config.read_unhomed()?.bus.interface;
    let first = live::ask(&interface)?;
    let mut view = Some(first.ok_or_else(|| LiveFault::NotRunning.of(&interface))?);
    while let Some(shown) = view.take() {
        print(reporter, &shown);
        if args.follow {
            std::thread::sleep(PERIOD);
            view = live::ask(&interface)?;
        }
    }
    Ok(())
}

fn print(reporter: Reporter, view: &Value) {
    let number = |name: &str| view[name].as_f64().unwrap_or(f64::NAN);
    let phase = view["phase"].as_str().unwrap_or("?");
    reporter.title(&format!("{phase}, {:.2} s", number("time")));
    reporter.line("axis", "    theta [rad]  error [urad]   tau [N m]  tau_meas [N m]  state");
    for k in 0..AXES {
        let of = |name: &str| view[name][k].as_f64().unwrap_or(f64::NAN);
        let state = view["state"][k].as_str().unwrap_or("?");
        reporter.line(
            &format!("{}", k + 1),
            &format!(
                "{:>15.6}{:>14.2}{:>12.3}{:>16.3}  {state}",
                of("theta"),
                of("e") * 1e6,
                of("tau"),
                of("tau_meas")
            ),
        );
    }
    let us = ["wake_up", "round_trip", "compute"].map(|name| (name, number(name)));
    let times: Vec<_> = us.iter().map(|(name, us)| format!("{name} {us:.1} us")).collect();
    reporter.line("cycle", &times.join(", "));
    let counts = ["lost", "short", "skipped", "late_threads"].map(|name| (name, number(name)));
    let counts: Vec<_> = counts.iter().map(|(name, n)| format!("{name} {n}")).collect();
    reporter.line("counts", &counts.join(", "));
    reporter.event("live", view.clone());
}
