//! `check`: finds what is wrong before the drives have power.

use clap::Args;
use serde_json::json;
use std::time::Duration;

use crate::bus::{self, BringUpOptions};
use crate::cycle::{signals, Signals};
use crate::exit::Exit;
use crate::report::Reporter;
use crate::session::{self, ConfigArgs};
use crate::wire::Socket;

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway check gateway/machines/akd.toml
  flexhex-gateway check gateway/machines/akd.toml --interface eth1 --bus";

#[derive(Args)]
pub struct Check {
    #[command(flatten)]
    config: ConfigArgs,
    /// Also read identity, order and state of the drives; nothing is enabled.
    #[arg(long)]
    bus: bool,
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
        Err((exit, why)) => {
            reporter.refused(&why);
            exit
        }
    }
}

fn without_power(args: &Check, reporter: Reporter) -> Result<(), (Exit, String)> {
    let bad = |why| (Exit::BadInput, why);
    let config = args.config.read().map_err(bad)?;
    reporter.mark(true, "configuration");
    let system = session::open_system(&config, reporter).map_err(bad)?;
    let controller = signals::open(&config, &system, true).map_err(bad)?;
    Signals::find(&config, &controller).map_err(bad)?;
    session::mechanics(&config, &system).map_err(bad)?;
    reporter.mark(true, "every FMU loads and initialises");
    for note in session::request_real_time(&config, false) {
        reporter.line("note", &note);
    }
    let failed = |why| (Exit::Failed, why);
    let socket = Socket::open(&config.bus.interface).map_err(failed)?;
    reporter.mark(true, &format!("interface {}", config.bus.interface));
    if args.bus {
        let options = BringUpOptions {
            cycle: Duration::from_secs_f64(system.base_step()),
            lockstep: true,
            reset_faults: false,
        };
        let devices = bus::inspect(&config, socket, options).map_err(failed)?;
        reporter.devices(&devices);
        bus::compare(&config, &devices).map_err(failed)?;
        bus::refuse_energised(&config, &devices, false).map_err(failed)?;
        reporter.mark(true, "the drives match the configuration and have no power");
    }
    Ok(())
}
