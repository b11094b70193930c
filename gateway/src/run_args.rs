//! Options of `run`, and what follows from them.

use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

use crate::arguments::ConfigArgs;
use crate::bus::BringUpOptions;
use crate::config::Config;
use crate::cycle::RunOptions;
use crate::exit::Refusal;
use crate::option_error::OptionError;
use crate::session::PowerArgs;
use crate::tasks::Task;
use crate::wire::{Cable, Replay, Socket};

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway run gateway/machines/akd.toml --dry-run --duration 60 --record dry.csv
  flexhex-gateway run gateway/machines/akd.toml --enable --duration 20 --record a.csv
  flexhex-gateway run gateway/machines/akd.toml --enable --record b.csv --resume a-estimate.json
  flexhex-gateway run gateway/machines/akd.toml --enable --page 4850
  flexhex-gateway run gateway/machines/akd.toml --enable --interface veth1 --lockstep

Ctrl-C ends a run: the machine lands and the drives are disabled. A second Ctrl-C takes the torque
at once.";

#[derive(Args)]
pub struct Run {
    #[command(flatten)]
    pub config: ConfigArgs,
    #[command(flatten)]
    pub options: PowerArgs,
    /// Read the drives and compute, but command zero torque and enable no drive.
    #[arg(long, conflicts_with = "enable")]
    pub dry_run: bool,
    /// Duration of the run in seconds.
    #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true)]
    pub duration: f64,
    /// Record every cycle to this CSV file, which must not exist. Without it only the seconds around a trip are kept.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Start from what the estimator learned in an earlier run, for example --resume a-estimate.json.
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
    /// Add a line `# KEY: VALUE` at the head of the recording, for example --meta trajectory=a; may
    /// be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    pub meta: Vec<String>,
    /// Take the replies from a capture (pcap) of an earlier run, in the place of the drives: what would these limits,
    /// or this version, have done? Give the options that it had.
    #[arg(long, value_name = "FILE")]
    pub replay: Option<PathBuf>,
    /// The offsets of the encoders need not be known, and `homing.file` need not fit.
    #[arg(skip)]
    pub unhomed: bool,
}

impl Run {
    /// A task in the place of the controller.
    pub fn instead((config, options): (&ConfigArgs, PowerArgs), unhomed: bool) -> Run {
        Run {
            config: config.clone(),
            options,
            dry_run: false,
            duration: 1.0,
            record: None,
            resume: None,
            meta: Vec::new(),
            replay: None,
            unhomed,
        }
    }

    pub fn check(&self) -> Result<(), OptionError> {
        if !self.options.enable && !self.dry_run {
            return Err(OptionError::NoMode);
        }
        if !(self.duration > 0.0 && self.duration < 1e7) {
            return Err(OptionError::Duration(self.duration));
        }
        Ok(())
    }

    /// Emulated drives take a cycle with each frame, and so do those of a capture.
    pub fn lockstep(&self) -> bool {
        self.options.lockstep || self.replay.is_some()
    }

    /// Whether the motion is the controller's, with power: a capture has been run.
    pub fn judged(&self, task: &Task) -> bool {
        matches!(task, Task::Control) && self.options.enable && self.replay.is_none()
    }

    pub fn open_cable(&self, config: &Config) -> Result<Cable, Refusal> {
        if let Some(file) = &self.replay {
            return Ok(Cable::Replayed(Replay::open(file)?));
        }
        let name = &config.bus.interface;
        if self.options.lockstep && Socket::is_hardware(name) {
            return Err(OptionError::Lockstep(name.clone()).into());
        }
        Ok(Cable::Live(Socket::open(name)?))
    }

    pub fn bring_up(&self, base_step: f64) -> BringUpOptions {
        BringUpOptions {
            cycle: Duration::from_secs_f64(base_step),
            lockstep: self.lockstep(),
            reset_faults: self.options.reset_faults,
            replayed: self.replay.is_some(),
            cyclic: true,
        }
    }

    pub fn of_loop(&self, base_step: f64) -> RunOptions {
        RunOptions {
            cycles: (self.duration / base_step).round() as i64,
            dry_run: self.dry_run,
            lockstep: self.lockstep(),
            reset_faults: self.options.reset_faults,
        }
    }
}
