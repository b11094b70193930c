//! Runs the control FMUs of a `.ssp` against six servo drives on EtherCAT.

mod answering;
mod arguments;
mod arrivals;
mod attend;
mod bus;
mod calibrate;
mod cautions;
mod check;
mod config;
mod cycle;
mod esi;
mod estimate;
mod exit;
mod file_error;
mod home;
mod jog;
mod learned;
mod limits;
mod live;
mod mismatch;
mod motion;
mod moves;
mod obstacle;
mod off;
mod option_error;
mod plan;
mod planned;
mod platform;
mod poses;
mod realtime;
mod record;
mod referencing;
mod report;
mod rights;
mod rules;
mod run;
mod run_args;
mod safety;
mod saved;
mod session;
mod status;
mod tasks;
mod torque_constant;
mod torque_error;
mod unknown_drive;
mod watch;
mod wire;
mod workspace;

use clap::{Parser, Subcommand};
use exit::Exit;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  flexhex-gateway check gateway/machines/akd.toml --bus
  flexhex-gateway home gateway/machines/akd.toml
  flexhex-gateway run gateway/machines/akd.toml --dry-run --duration 60
  flexhex-gateway run gateway/machines/akd.toml --enable --record a.csv
  flexhex-gateway move gateway/machines/akd.toml --enable --axis 3 --by 0.02
  flexhex-gateway move gateway/machines/akd.toml --enable --pose 0,0,310mm,0,2deg,0
  flexhex-gateway jog gateway/machines/akd.toml --enable
  flexhex-gateway calibrate signs gateway/machines/akd.toml --enable
  flexhex-gateway status gateway/machines/akd.toml
  flexhex-gateway off gateway/machines/akd.toml
  flexhex-gateway emulate --interface veth0 --system out/hexapod.ssp

Exit codes: 0 finished or stopped by Ctrl-C; 1 tripped, or refused because of the drives or the \
interface; 2 wrong usage; 3 wrong configuration, system description or FMU.";

/// Run the control FMUs of a system description against six servo drives on EtherCAT.
#[derive(Parser)]
#[command(name = "flexhex-gateway", version, after_help = EXAMPLES)]
struct Line {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Check configuration, system description, FMUs and (with --bus) the drives; enable nothing.
    #[command(after_help = check::EXAMPLES)]
    Check(check::Check),
    /// Run the controller against the drives.
    #[command(after_help = run_args::EXAMPLES)]
    Run(run_args::Run),
    /// Show what a running gateway does; only reads.
    #[command(after_help = status::EXAMPLES)]
    Status(status::Status),
    /// Move through poses by feedback alone, and land; nudge an axis.
    #[command(after_help = poses::EXAMPLES)]
    Move(moves::Move),
    /// Move by the keyboard, by feedback alone, and land.
    #[command(after_help = jog::EXAMPLES)]
    Jog(jog::Jog),
    /// Find the signs of the axes by a nudge, or the torque constant by a known weight.
    #[command(after_help = calibrate::EXAMPLES)]
    Calibrate(calibrate::Calibrate),
    /// Find the offsets of the encoders: in a known pose without power, or at the end stops.
    #[command(after_help = home::EXAMPLES)]
    Home(home::Home),
    /// Print the profile of a drive from the ESI file of its maker.
    #[command(after_help = unknown_drive::EXAMPLES)]
    Esi(unknown_drive::Esi),
    /// Take the drives out of operation from any state; the torque ends at once.
    #[command(after_help = off::EXAMPLES)]
    Off(off::Off),
    /// Emulate six servo drives on EtherCAT with an FMU as the machine that they move.
    #[command(after_help = flexhex_emulator::EXAMPLES)]
    Emulate(flexhex_emulator::Args),
}

fn main() -> ExitCode {
    let line = Line::parse();
    let exit = match &line.verb {
        Verb::Check(args) => check::check(args),
        Verb::Run(args) => run::run(args),
        Verb::Status(args) => status::status(args),
        Verb::Move(args) => moves::through(args),
        Verb::Jog(args) => jog::jog(args),
        Verb::Calibrate(args) => calibrate::calibrate(args),
        Verb::Home(args) => home::home(args),
        Verb::Esi(args) => unknown_drive::esi(args),
        Verb::Off(args) => off::off(args),
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
