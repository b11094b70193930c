//! Controller and plant of a `.ssp` in one process, without a bus between them. Prints the time
//! of a cycle; with `--out`, writes the chosen signals of every base step as raw doubles.
//!
//! closed_loop FILE.ssp [--seconds 10] [--own-thread K]... [--wait 5] [--hold] [--fault-trips]
//!     [--step-limit SECONDS] [--plant FILE.fmu] [--set plant.tau_step=0.003]...
//!     [--host plant] [--signal K.p.actuator[1].o]... [--out FILE] [--pace]

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use flexhex_system::{Controller, Late, Options, Plant, System};

#[derive(Default)]
struct Arguments {
    ssp: PathBuf,
    seconds: f64,
    host: String,
    plant: Option<PathBuf>,
    signals: Vec<String>,
    out: Option<PathBuf>,
    /// Wait for the clock at every base step.
    pace: bool,
    options: Options,
}

fn main() -> ExitCode {
    match arguments().and_then(|a| run(&a)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            eprintln!("{text}");
            ExitCode::from(3)
        }
    }
}

fn arguments() -> Result<Arguments, String> {
    let mut arguments =
        Arguments { seconds: 10.0, host: "plant".to_owned(), ..Arguments::default() };
    arguments.options.wait = Duration::from_secs(5);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word}: value missing"));
        match word.as_str() {
            "--seconds" => arguments.seconds = number(&value()?)?,
            "--own-thread" => arguments.options.own_thread.push(value()?),
            "--wait" => arguments.options.wait = Duration::from_secs_f64(number(&value()?)?),
            "--hold" => arguments.options.late = Late::Hold,
            "--fault-trips" => arguments.options.fault_trips = true,
            "--step-limit" => {
                let limit = Duration::from_secs_f64(number(&value()?)?);
                arguments.options.step_limit = Some(limit);
            }
            "--plant" => arguments.plant = Some(value()?.into()),
            "--host" => arguments.host = value()?,
            "--signal" => arguments.signals.push(value()?),
            "--out" => arguments.out = Some(value()?.into()),
            "--pace" => arguments.pace = true,
            "--set" => {
                let text = value()?;
                let (name, text) =
                    text.split_once('=').ok_or("--set: write it as component.parameter=value")?;
                let pair = (name.to_owned(), text.parse().unwrap_or_else(|never| match never {}));
                arguments.options.parameters.push(pair);
            }
            _ => arguments.ssp = word.into(),
        }
    }
    Ok(arguments)
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("{text}: no number"))
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let text = |e: flexhex_system::Error| e.to_string();
    let system = System::open(&arguments.ssp).map_err(text)?;
    let options = arguments.options.clone();
    let parameters = options.parameters.clone();
    let mut controller = Controller::open(&system, &arguments.host, options).map_err(text)?;
    let fmu = arguments.plant.as_deref();
    let mut plant = Plant::open(&system, &arguments.host, fmu, &parameters).map_err(text)?;
    let mut slots = Vec::new();
    for signal in &arguments.signals {
        let slot = controller.slot(signal);
        slots.push(slot.ok_or(format!("{signal}: there is no such signal"))?);
    }
    let steps = (arguments.seconds / system.base_step()).round() as usize;
    let mut recorder = arguments.out.as_ref().map(|_| Vec::new());
    let n = controller.command().len();
    let (mut theta, mut tau_meas) = (vec![0.0; n], vec![0.0; n]);
    let mut times = Vec::with_capacity(steps);
    let base = Duration::from_secs_f64(system.base_step());
    let mut next = Instant::now();
    let mut trip = None;
    for _ in 0..steps {
        plant.read(&mut theta, &mut tau_meas);
        plant.step(controller.command()).map_err(text)?;
        let begin = Instant::now();
        let done = controller.cycle(&theta, &tau_meas);
        times.push(begin.elapsed());
        if let Err(reason) = done {
            trip = Some(reason);
            break;
        }
        if let Some(rows) = &mut recorder {
            rows.extend(theta.iter().chain(&tau_meas));
            rows.extend(controller.command());
            rows.extend(slots.iter().map(|s| controller.bus()[*s]));
        }
        if arguments.pace {
            next += base;
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
        }
    }
    if let (Some(rows), Some(path)) = (recorder, &arguments.out) {
        save(path, &rows).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    report(times, &controller);
    match trip {
        Some(trip) => Err(format!("trip {:?} at {}: {trip}", trip.what, trip.now)),
        None => Ok(()),
    }
}

fn save(path: &PathBuf, rows: &[f64]) -> std::io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    for value in rows {
        file.write_all(&value.to_le_bytes())?;
    }
    file.flush()
}

fn report(mut times: Vec<Duration>, controller: &Controller) {
    times.sort();
    let at = |share: f64| {
        let place = (share * (times.len() - 1) as f64).round() as usize;
        1e6 * times[place].as_secs_f64()
    };
    println!(
        "cycles {} late {} cycle [us] p50 {:.2} p99 {:.2} p99.9 {:.2} max {:.1}",
        times.len(),
        controller.late(),
        at(0.5),
        at(0.99),
        at(0.999),
        at(1.0)
    );
}
