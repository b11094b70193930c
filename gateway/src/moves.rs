//! The command `move`.

use clap::Args;

use crate::arguments::ConfigArgs;
use crate::exit::Exit;
use crate::poses::Poses;
use crate::run::{self, Run};
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
    run::run(&Run::through(args.config.clone(), args.poses.clone(), args.options))
}
