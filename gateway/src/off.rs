//! `off`: takes the drives out of operation from any state, for example after a crash.

use clap::Args;
use serde_json::json;

use crate::bus::{self, cia402};
use crate::config::Config;
use crate::exit::Exit;
use crate::report::Reporter;
use crate::session::ConfigArgs;
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
}

/// Take the drives out of operation; the exit code of the command.
pub fn off(args: &Off) -> Exit {
    let reporter = args.config.reporter();
    let config = match args.config.read_unhomed() {
        Ok(config) => config,
        Err(why) => {
            reporter.refused(&why);
            return Exit::BadInput;
        }
    };
    match without_power(&config, reporter) {
        Ok(()) => Exit::Good,
        Err(why) => {
            reporter.refused(&why);
            Exit::Failed
        }
    }
}

fn without_power(config: &Config, reporter: Reporter) -> Result<(), String> {
    let socket = Socket::open(&config.bus.interface)?;
    let devices = bus::off(config, socket)?;
    reporter.devices(&devices);
    for d in devices.iter().filter(|d| d.statusword & cia402::FAULT_BIT != 0) {
        let code = d.error_code;
        reporter.line("note", &format!("position {}: fault {code:#06x} (0x603F)", d.position));
    }
    reporter.mark(true, "no drive is energised; all devices are in INIT");
    reporter.event("off", json!({ "devices": devices.len() }));
    Ok(())
}
