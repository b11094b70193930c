//! `run`: from a configuration to a finished run, with everything that can fail done before power.

use clap::Args;
use flexhex_system::System;
use serde_json::json;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::bus::{self, Wish};
use crate::check;
use crate::config::Config;
use crate::cycle::{signals, Blank, Ending, Machine, Pulse, Signals, Wanted};
use crate::realtime;
use crate::record::{ring, Columns, Plan, Writer, Written};
use crate::report::Teller;
use crate::wire::Socket;
use crate::Exit;

const SHOWN_EVERY: Duration = Duration::from_millis(500);

#[derive(Args)]
pub struct Run {
    #[command(flatten)]
    from: check::From,
    /// Power the drives. Without it nothing is ever enabled.
    #[arg(long, conflicts_with = "dry_run")]
    enable: bool,
    /// Read the drives and compute, but send zero torque and never enable.
    #[arg(long)]
    dry_run: bool,
    /// How long, in seconds.
    #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true)]
    duration: f64,
    /// One frame is one cycle of the plant; nobody waits for a clock (emulated drives only).
    #[arg(long)]
    lockstep: bool,
    /// Reset faults of the drives before enabling.
    #[arg(long)]
    reset_faults: bool,
    /// Record to this file; without it, only what a trip keeps is written.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// A line `# key: value` at the head of the recording, as `--meta trajectory=a`.
    #[arg(long, value_name = "KEY=VALUE")]
    meta: Vec<String>,
}

/// Carry it out.
pub fn run(args: &Run) -> Exit {
    let teller = args.from.teller();
    match prepared(args, teller) {
        Ok(exit) => exit,
        Err((exit, why)) => {
            teller.refused(&why);
            exit
        }
    }
}

type Refusal = (Exit, String);

fn prepared(args: &Run, teller: Teller) -> Result<Exit, Refusal> {
    if !args.enable && !args.dry_run {
        let why = "nothing to do: --enable powers the drives, --dry-run only reads them";
        return Err((Exit::Usage, why.to_owned()));
    }
    if !(args.duration > 0.0 && args.duration < 1e7) {
        let why = format!("--duration {}: seconds, above 0 and below 1e7", args.duration);
        return Err((Exit::Usage, why));
    }
    let bad = |why| (Exit::BadInput, why);
    let config = args.from.read().map_err(bad)?;
    teller.title("flexhex-gateway");
    let system = check::system(&config, teller).map_err(bad)?;
    let controller = signals::open(&config, &system, args.lockstep).map_err(bad)?;
    let found = Signals::find(&config, &controller).map_err(bad)?;
    let more = check::more(&config, &controller);
    let columns = Columns::with(&more);
    let (sink, source) = ring(config.recorder.buffer_cycles, columns.len());
    let width = columns.len();
    let plan = plan(args, &config, &system, columns).map_err(bad)?;
    let writer = Writer::start(plan, source).map_err(bad)?;

    let failed = |why| (Exit::Failed, why);
    if args.lockstep && Socket::is_hardware(&config.bus.interface) {
        let name = &config.bus.interface;
        let why = format!("--lockstep: {name} is a real port; only emulated drives keep no time");
        return Err((Exit::Usage, why));
    }
    let socket = Socket::open(&config.bus.interface).map_err(failed)?;
    let wish = Wish {
        cycle: Duration::from_secs_f64(system.base_step()),
        lockstep: args.lockstep,
        reset_faults: args.reset_faults,
    };
    realtime::stop::listen();
    let wanted = Wanted {
        cycles: (args.duration / system.base_step()).round() as i64,
        dry_run: args.dry_run,
        lockstep: args.lockstep,
        reset_faults: args.reset_faults,
    };
    let pulse = Pulse::default();
    let base_step = system.base_step();
    let out = shown(teller, &pulse, base_step, || {
        // from OP on the drives count on a frame every cycle: all else is done before
        for note in privileges(&config, args.lockstep) {
            teller.line("note", &note);
        }
        let blank = Blank::new(width);
        let bus = bus::bring_up(&config, socket, wish, &mut |found| teller.found(found))?;
        let parts = (controller, found);
        Ok(Machine::new(&config, wanted, bus, parts, (sink, blank), (&pulse, base_step)).run())
    });
    let out = out.map_err(failed)?;
    let trip = match &out.ending {
        Ending::Tripped(trip, said) => Some(format!("{}: {trip} {said}", trip.reason.key())),
        _ => None,
    };
    // whatever became of the recording, how the run ended is told first
    let finished = writer.finish(trip);
    teller.outcome(&out, finished.as_ref().unwrap_or(&Written::default()));
    finished.map_err(failed)?;
    Ok(match out.ending {
        Ending::Done | Ending::Asked => Exit::Good,
        _ => Exit::Failed,
    })
}

/// Run `work` in this thread while another shows the pulse.
fn shown<T>(teller: Teller, pulse: &Pulse, base_step: f64, work: impl FnOnce() -> T) -> T {
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let shower = scope.spawn(|| {
            while !over.load(Ordering::Relaxed) {
                std::thread::park_timeout(SHOWN_EVERY);
                let cycle = pulse.cycle.load(Ordering::Relaxed);
                if cycle == 0 {
                    continue;
                }
                let time = cycle as f64 * base_step;
                let error = pulse.error_nrad.load(Ordering::Relaxed) as f64 / 1e3;
                let lost = pulse.lost.load(Ordering::Relaxed);
                teller.live(&format!("{time:8.2} s   error {error:9.2} urad   lost {lost}"));
                teller.event(
                    "status",
                    json!({"cycle": cycle, "time_s": time, "error_urad": error, "lost": lost}),
                );
            }
            teller.live_over();
        });
        let out = work();
        over.store(true, Ordering::Relaxed);
        shower.thread().unpark();
        out
    })
}

/// What of the real-time wishes was not given, each with what to do. Lockstep needs none.
pub fn privileges(config: &Config, lockstep: bool) -> Vec<String> {
    let r = &config.real_time;
    let mut notes = Vec::new();
    if lockstep {
        return notes;
    }
    if r.lock_memory {
        notes.extend(realtime::lock_memory().err());
    }
    if let Some(cpu) = r.cpu {
        notes.extend(realtime::pin_to(cpu).err());
    }
    if r.priority > 0 {
        notes.extend(realtime::set_fifo(r.priority).err());
    }
    notes
}

fn plan(args: &Run, config: &Config, system: &System, columns: Columns) -> Result<Plan, String> {
    let mut meta = vec![
        ("run".to_owned(), "gateway".to_owned()),
        ("system".to_owned(), config.system.ssp.display().to_string()),
        ("drives".to_owned(), config.profile.name.clone()),
        ("base_step_s".to_owned(), system.base_step().to_string()),
        ("signals".to_owned(), check::named(config, system)),
    ];
    for pair in &args.meta {
        let (key, value) =
            pair.split_once('=').ok_or_else(|| format!("--meta {pair}: wants KEY=VALUE"))?;
        meta.retain(|(k, _)| k != key);
        meta.push((key.to_owned(), value.to_owned()));
    }
    let folder = args.record.as_deref().and_then(|f| f.parent()).unwrap_or(&config.recorder.folder);
    let stem = args.record.as_deref().and_then(|f| f.file_stem()).map_or_else(
        || format!("run-{}", std::process::id()),
        |stem| stem.to_string_lossy().into_owned(),
    );
    Ok(Plan {
        columns,
        meta,
        recording: args.record.clone(),
        before_trip: folder.join(format!("{stem}-trip.csv")),
        keep: (config.recorder.keep_s / system.base_step()).round() as usize,
        reaction: (f64::from(config.safety.ramp_ms) * 1e-3 / system.base_step()) as usize + 400,
    })
}
