//! The emulator as a program of its own; `flexhex-gateway emulate` is the same.
use clap::Parser;
use std::process::ExitCode;

/// Emulate six servo drives on EtherCAT with an FMU as the machine that they move.
#[derive(Parser)]
#[command(name = "flexhex-emulator", after_help = flexhex_emulator::EXAMPLES)]
struct Command {
    #[command(flatten)]
    args: flexhex_emulator::Args,
}

fn main() -> ExitCode {
    let result = Command::parse().args.options().and_then(flexhex_emulator::run);
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
