//! The emulated machine by itself; `flexhex-gateway emulate` is the same.
use clap::Parser;
use std::process::ExitCode;

/// Emulates six servo drives on EtherCAT with the machine's FMU behind them
#[derive(Parser)]
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
