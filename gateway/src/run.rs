//! `run`: from a configuration to a finished run. All that can fail is done before power.

use flexhex_system::System;
use std::sync::Arc;

use crate::answering::Answering;
use crate::arguments::ConfigArgs;
use crate::attend::{attend, Watched};
use crate::bus;
use crate::config::{Config, AXES};
use crate::cycle::{signals, ControlLoop, Outcome, Preallocated, Signals};
use crate::exit::{Exit, Refusal};
use crate::learned;
use crate::live::Board;
use crate::mismatch::Mismatch;
use crate::plan::plan;
use crate::planned;
use crate::realtime;
use crate::record::{self, ring, Columns, Writer, Written};
use crate::report::Reporter;
use crate::rights;
use crate::run_args::Run;
use crate::session::{self, PowerArgs};
use crate::tasks::Task;
use crate::watch;
use crate::workspace::Workspace;

/// Prepare, run, report; the exit code of the command.
pub fn run(args: &Run) -> Exit {
    guided(args, |_, _| Ok(Task::Control), |_, _, _, _| Ok(()))
}

/// A task in the place of the controller, as `make` makes it of configuration and system; `tell` gets what it found,
/// if it ended as wanted.
pub fn instead(
    common: (&ConfigArgs, PowerArgs),
    unhomed: bool,
    make: impl Fn(&Config, &System) -> Result<Task, Refusal>,
    tell: impl Fn(Reporter, &Config, &System, &Outcome) -> Result<(), Refusal>,
) -> Exit {
    guided(&Run::instead(common, unhomed), make, tell)
}

fn guided(
    args: &Run,
    make: impl Fn(&Config, &System) -> Result<Task, Refusal>,
    tell: impl Fn(Reporter, &Config, &System, &Outcome) -> Result<(), Refusal>,
) -> Exit {
    let reporter = args.config.reporter();
    let done = prepare_and_run(args, reporter, make).and_then(|(config, system, out)| {
        if out.good() {
            let _answering = Answering::after_power(reporter);
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

fn prepare_and_run(
    args: &Run,
    reporter: Reporter,
    make: impl Fn(&Config, &System) -> Result<Task, Refusal>,
) -> Result<(Config, System, Outcome), Refusal> {
    realtime::stop::end_by_default();
    args.check()?;
    let lockstep = args.lockstep();
    let read = if args.unhomed { args.config.read_unhomed() } else { args.config.read() };
    let mut config = read?;
    if args.resume.is_some() {
        config.estimate.resume.clone_from(&args.resume);
    }
    let config = config;
    args.record.as_deref().map_or(Ok(()), record::vacant)?;
    reporter.title("flexhex-gateway");
    let preparing = Answering::before_power(reporter);
    let system = session::open_system(&config, reporter)?;
    let resume = learned::resumed(&config)?;
    let controller = signals::open(&config, &system, lockstep, resume)?;
    let signals = Signals::find(&config, &controller)?;
    let mut mechanics = session::mechanics(&config, &system)?;
    let workspace = Workspace::open(&config, &system, "").map_err(Mismatch::System)?;
    // from here on a task may listen to the keyboard
    realtime::stop::listen();
    let task = make(&config, &system)?;
    let socket = args.open_cable(&config)?;
    if args.judged(&task) {
        let start = signals.r.map(|slot| controller.bus()[slot]);
        planned::judge_lift_off(&config, &system, &start)??;
        let cycles = args.of_loop(system.base_step()).cycles;
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
    let closer = writer.closer();
    let patience = watch::patience(lockstep, &config);
    let watched = Watched { reporter, board: &board, columns: &columns, patience };
    let (out, beside): (Result<_, Refusal>, _) = attend(
        watched,
        |component| watch::hung(reporter, component, &closer, &args.config),
        || {
            // from OP on the drives expect a frame every cycle: all else is done before
            let notes = rights::request_real_time(&config, lockstep, args.options.enable);
            for note in notes? {
                reporter.line("note", &note.to_string());
            }
            let buffers = Preallocated::new(width);
            let bring_up = args.bring_up(base_step);
            let mut serials = [0; AXES];
            let bus = bus::bring_up(&config, socket, bring_up, &mut |devices| {
                reporter.devices(devices);
                serials = bus::serials(&config, devices);
            })?;
            let (parts, sinks) = ((controller, signals, mechanics, workspace), (sink, buffers));
            let options = (args.of_loop(base_step), task);
            let control =
                ControlLoop::new(&config, options, bus, parts, sinks, (&board, base_step));
            let (out, fmus) = control.run();
            Ok((Outcome { serials, ..out }, fmus))
        },
    );
    let trip = out.as_ref().ok().and_then(|(out, _)| out.trip_text());
    // a failed recording must not hide how the run ended
    let finished = writer.finish(trip);
    let (out, fmus) = out?;
    reporter.outcome(&out, finished.as_ref().unwrap_or(&Written::default()));
    // nothing of the above waits for the FMUs, which are called again from here on
    let ending = Answering::after_power(reporter);
    let states = fmus.states();
    drop(fmus);
    drop(ending);
    finished?;
    if let (Some(recording), false) = (&args.record, args.dry_run) {
        learned::save(reporter, (&out, states), recording, &config)?;
    }
    if let Some(hung) = beside {
        return Err(hung.into());
    }
    Ok((config, system, out))
}
