//! `off`: takes the drives out of operation from any state, for example after a crash.

use clap::Args;
use serde_json::json;
use std::os::unix::process::CommandExt;
use std::process::Command;

use crate::arguments::ConfigArgs;
use crate::bus::{self, cia402};
use crate::exit::{Exit, Refusal};
use crate::realtime;
use crate::report::Reporter;
use crate::wire::Socket;

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway off gateway/machines/akd.toml
  flexhex-gateway off gateway/machines/akd.toml --interface eth1 --json

It takes the torque away at once: the platform sinks. A running gateway is stopped by Ctrl-C instead.";

#[derive(Args)]
pub struct Off {
    #[command(flatten)]
    config: ConfigArgs,
    /// After a run that hung, which is no success whatever the drives say.
    #[arg(long, hide = true)]
    after_hang: bool,
}

/// Replaces this process, with all that hangs in it, by `off` with the same configuration. Returns why that
/// failed.
pub fn in_place_of_this(config: &ConfigArgs) -> std::io::Error {
    let mut command = Command::new("/proc/self/exe");
    command.arg("off").args(config.words()).arg("--after-hang").exec()
}

/// Take the drives out of operation; the exit code of the command.
pub fn off(args: &Off) -> Exit {
    let reporter = args.config.reporter();
    match without_power(args, reporter) {
        Ok(()) if args.after_hang => Exit::Failed,
        Ok(()) => Exit::Good,
        Err(why) => {
            reporter.refused(&why);
            why.exit
        }
    }
}

fn without_power(args: &Off, reporter: Reporter) -> Result<(), Refusal> {
    // Ctrl-C does not end it between two drives: it ends by itself
    realtime::stop::listen();
    let config = args.config.read_unhomed()?;
    let socket = Socket::open(&config.bus.interface)?;
    let devices = bus::off(&config, socket)?;
    reporter.devices(&devices);
    for d in devices.iter().filter(|d| d.statusword & cia402::FAULT_BIT != 0) {
        let code = d.error_code;
        reporter.line("note", &format!("position {}: fault {code:#06x} (0x603F)", d.position));
    }
    reporter.mark(true, "no drive is energised; all devices are in INIT");
    reporter.event("off", json!({ "devices": devices.len() }));
    Ok(())
}
