//! Runs the control FMUs of a `.ssp` against six servo drives on EtherCAT.

mod bus;
mod check;
mod config;
mod cycle;
mod realtime;
mod record;
mod report;
mod run;
mod safety;
mod wire;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "flexhex-gateway", version, about)]
struct Line {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Refuse now what can be refused before there is power.
    Check(check::Check),
    /// Run the controller against the drives.
    Run(run::Run),
    /// Six drives that are not there, with the FMU of the machine behind them.
    Emulate(flexhex_emulator::Args),
}

/// The exit codes of every flexhex command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    Good = 0,
    /// Tripped, or refused by what is on the cable.
    Failed = 1,
    Usage = 2,
    BadInput = 3,
}

fn main() -> ExitCode {
    let line = Line::parse();
    let exit = match &line.verb {
        Verb::Check(args) => check::check(args),
        Verb::Run(args) => run::run(args),
        Verb::Emulate(args) => emulate(args),
    };
    ExitCode::from(exit as u8)
}

fn emulate(args: &flexhex_emulator::Args) -> Exit {
    match args.options().and_then(flexhex_emulator::run) {
        Ok(()) => Exit::Good,
        Err(why) => {
            eprintln!("✗ {why}");
            Exit::BadInput
        }
    }
}
