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
    /// One JSON object a line on stdout, words on stderr.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum Verb {
    /// Refuse now what can be refused before there is power.
    Check(check::Check),
    /// Run the controller against the drives.
    Run(run::Run),
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
    let teller = report::Teller::new(line.json);
    let exit = match &line.verb {
        Verb::Check(args) => check::check(args, teller),
        Verb::Run(args) => run::run(args, teller),
    };
    ExitCode::from(exit as u8)
}
