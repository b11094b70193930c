//! The command `move`.

use clap::Args;
use flexhex_system::System;

use crate::arguments::ConfigArgs;
use crate::config::Config;
use crate::exit::Exit;
use crate::poses::Poses;
use crate::run;
use crate::session::PowerArgs;

#[derive(Args)]
pub struct Move {
    #[command(flatten)]
    config: ConfigArgs,
    #[command(flatten)]
    poses: Poses,
    #[command(flatten)]
    options: PowerArgs,
}

/// Move through the poses and land; the exit code of the command.
pub fn through(args: &Move) -> Exit {
    let reporter = args.config.reporter();
    let make = |config: &Config, system: &System| Ok(args.poses.task(reporter, config, system)?);
    run::instead((&args.config, args.options), false, make, |_, _, _, _| Ok(()))
}
