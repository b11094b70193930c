//! `run`: from a configuration to a finished run. All that can fail is done before power.

use clap::Args;
use flexhex_system::System;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use crate::arguments::ConfigArgs;
use crate::attend::{attend, Watched};
use crate::bus::{self, BringUpOptions};
use crate::config::{Config, AXES};
use crate::cycle::{signals, ControlLoop, Outcome, Preallocated, RunOptions, Signals};
use crate::exit::{Exit, Refusal};
use crate::learned;
use crate::live::Board;
use crate::mismatch::Mismatch;
use crate::option_error::OptionError;
use crate::plan::plan;
use crate::planned;
use crate::preparing::Preparing;
use crate::realtime;
use crate::record::{self, ring, Columns, Writer, Written};
use crate::report::Reporter;
use crate::rights;
use crate::session::{self, PowerArgs};
use crate::tasks::Task;
use crate::watch;
use crate::wire::{Cable, Replay, Socket};
use crate::workspace::Workspace;

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
    config: ConfigArgs,
    #[command(flatten)]
    options: PowerArgs,
    /// Read the drives and compute, but command zero torque and enable no drive.
    #[arg(long, conflicts_with = "enable")]
    dry_run: bool,
    /// Duration of the run in seconds.
    #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true)]
    duration: f64,
    /// Record every cycle to this CSV file, which must not exist. Without it only the seconds around a trip are kept.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Start from what the estimator learned in an earlier run, for example --resume a-estimate.json.
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Add a line `# KEY: VALUE` at the head of the recording, for example --meta trajectory=a; may
    /// be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    meta: Vec<String>,
    /// Take the replies from a capture (pcap) of an earlier run, in the place of the drives: what would these limits,
    /// or this version, have done? Give the options that it had.
    #[arg(long, value_name = "FILE")]
    replay: Option<PathBuf>,
    /// The offsets of the encoders need not be known, and `homing.file` need not fit.
    #[arg(skip)]
    unhomed: bool,
}

/// Prepare, run, report; the exit code of the command.
pub fn run(args: &Run) -> Exit {
    guided(args, |_, _| Ok(Task::Control), |_, _, _, _| Ok(()))
}

/// A task in the place of the controller, as `make` makes it of configuration and system; `tell` gets what it found,
/// if it ended as wanted.
pub fn instead(
    (config, options): (&ConfigArgs, PowerArgs),
    unhomed: bool,
    make: impl Fn(&Config, &System) -> Result<Task, Refusal>,
    tell: impl Fn(Reporter, &Config, &System, &Outcome) -> Result<(), Refusal>,
) -> Exit {
    let args = Run {
        config: config.clone(),
        options,
        dry_run: false,
        duration: 1.0,
        record: None,
        resume: None,
        meta: Vec::new(),
        replay: None,
        unhomed,
    };
    guided(&args, make, tell)
}

fn guided(
    args: &Run,
    make: impl Fn(&Config, &System) -> Result<Task, Refusal>,
    tell: impl Fn(Reporter, &Config, &System, &Outcome) -> Result<(), Refusal>,
) -> Exit {
    let reporter = args.config.reporter();
    let done = prepare_and_run(args, reporter, make).and_then(|(config, system, out)| {
        if out.good() {
            tell(reporter, &config, &system, &out)?;
        }
        Ok(if out.good() { Exit::Good } else { Exit::Failed })
    });
    done.unwrap_or_else(|why| {
        match why.exit {
            Exit::Good => reporter.mark(true, &why.to_string()),
            _ => reporter.refused(&why),
        }
        why.exit
    })
}

fn check_arguments(args: &Run) -> Result<(), OptionError> {
    if !args.options.enable && !args.dry_run {
        return Err(OptionError::NoMode);
    }
    if !(args.duration > 0.0 && args.duration < 1e7) {
        return Err(OptionError::Duration(args.duration));
    }
    Ok(())
}

fn prepare_and_run(
    args: &Run,
    reporter: Reporter,
    make: impl Fn(&Config, &System) -> Result<Task, Refusal>,
) -> Result<(Config, System, Outcome), Refusal> {
    realtime::stop::end_by_default();
    check_arguments(args)?;
    let lockstep = args.options.lockstep || args.replay.is_some();
    let read = if args.unhomed { args.config.read_unhomed() } else { args.config.read() };
    let mut config = read?;
    if args.resume.is_some() {
        config.estimate.resume.clone_from(&args.resume);
    }
    let config = config;
    args.record.as_deref().map_or(Ok(()), record::vacant)?;
    reporter.title("flexhex-gateway");
    let preparing = Preparing::begin(reporter);
    let system = session::open_system(&config, reporter)?;
    let resume = learned::resumed(&config)?;
    let controller = signals::open(&config, &system, lockstep, resume)?;
    let signals = Signals::find(&config, &controller)?;
    let mut mechanics = session::mechanics(&config, &system)?;
    let workspace = Workspace::open(&config, &system).map_err(Mismatch::System)?;
    // from here on a task may listen to the keyboard
    realtime::stop::listen();
    let task = make(&config, &system)?;
    let socket = open_cable(args, &config)?;
    if judged(args, &task) {
        let cycles = run_options(args, lockstep, system.base_step()).cycles;
        planned::judge(reporter, &config, &system, cycles)??;
    }
    if !task.is_homed() {
        // the line of the holding torque is through known poses
        mechanics.weight = [0.0; AXES];
    }
    let columns = Columns::with(&session::extra_columns(&config, &controller));
    let width = columns.len();
    let (sink, source) = ring(config.recorder.buffer_cycles, width);
    let plan = plan(args.record.as_deref(), &args.meta, &config, (&system, columns.clone()))?;
    let base_step = system.base_step();
    let board = Arc::new(Board::new(width));
    watch::serve(&config, (args.options.page, args.record.as_deref()), &board, &columns)?;
    if let Some(port) = args.options.page {
        reporter.line("page", &format!("http://127.0.0.1:{port}/"));
    }
    drop(preparing);
    let writer = Writer::start(plan, source)?;
    let (computing, closer) = (controller.watch(), writer.closer());
    let patience = watch::patience(lockstep, &config);
    let watched = Watched { reporter, board: &board, columns: &columns, patience };
    let out: Result<Outcome, Refusal> = attend(
        watched,
        || watch::hung(reporter, &computing, &closer, &args.config),
        || {
            // from OP on the drives expect a frame every cycle: all else is done before
            let notes = rights::request_real_time(&config, lockstep, args.options.enable);
            for note in notes? {
                reporter.line("note", &note.to_string());
            }
            let buffers = Preallocated::new(width);
            let bring_up = bring_up_options(args, lockstep, base_step);
            let mut serials = [0; AXES];
            let bus = bus::bring_up(&config, socket, bring_up, &mut |devices| {
                reporter.devices(devices);
                serials = bus::serials(&config, devices);
            })?;
            let (parts, sinks) = ((controller, signals, mechanics, workspace), (sink, buffers));
            let options = (run_options(args, lockstep, base_step), task);
            let control =
                ControlLoop::new(&config, options, bus, parts, sinks, (&board, base_step));
            Ok(Outcome { serials, ..control.run() })
        },
    );
    let trip = out.as_ref().ok().and_then(Outcome::trip_text);
    // a failed recording must not hide how the run ended
    let finished = writer.finish(trip);
    let out = out?;
    reporter.outcome(&out, finished.as_ref().unwrap_or(&Written::default()));
    finished?;
    if let (Some(recording), false) = (&args.record, args.dry_run) {
        learned::save(reporter, &out, recording, &config)?;
    }
    Ok((config, system, out))
}

/// Whether the motion is the controller's, with power: a capture has been run.
fn judged(args: &Run, task: &Task) -> bool {
    matches!(task, Task::Control) && args.options.enable && args.replay.is_none()
}

fn open_cable(args: &Run, config: &Config) -> Result<Cable, Refusal> {
    if let Some(file) = &args.replay {
        return Ok(Cable::Replayed(Replay::open(file)?));
    }
    let name = &config.bus.interface;
    if args.options.lockstep && Socket::is_hardware(name) {
        return Err(OptionError::Lockstep(name.clone()).into());
    }
    Ok(Cable::Live(Socket::open(name)?))
}

fn bring_up_options(args: &Run, lockstep: bool, base_step: f64) -> BringUpOptions {
    BringUpOptions {
        cycle: Duration::from_secs_f64(base_step),
        lockstep,
        reset_faults: args.options.reset_faults,
        replayed: args.replay.is_some(),
        cyclic: true,
    }
}

fn run_options(args: &Run, lockstep: bool, base_step: f64) -> RunOptions {
    RunOptions {
        cycles: (args.duration / base_step).round() as i64,
        dry_run: args.dry_run,
        lockstep,
        reset_faults: args.options.reset_faults,
    }
}
