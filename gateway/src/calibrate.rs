//! `calibrate`: signs by a nudge of each axis, the torque constant by a known weight.

use clap::{Args, Subcommand};
use flexhex_system::System;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use crate::arguments::ConfigArgs;
use crate::config::{Config, AXES};
use crate::cycle::Outcome;
use crate::exit::{Ends, Exit, Refusal};
use crate::record::now;
use crate::report::Reporter;
use crate::run;
use crate::saved::save;
use crate::session::PowerArgs;
use crate::tasks::{Nudges, Task};
use crate::torque_constant;

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway calibrate signs gateway/machines/akd.toml --enable --write signs.toml
  flexhex-gateway calibrate torque gateway/machines/akd.toml --enable --write empty.toml
  flexhex-gateway calibrate torque gateway/machines/akd.toml --enable --mass 1.0 --against empty.toml \\
      --write loaded.toml

Both start from rest and end there. Offsets of the encoders are found by `home`.";

#[derive(Args)]
pub struct Calibrate {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Push each axis at rest, without feedback, until it moves 3 mrad, and back: its encoder must follow.
    #[command(after_help = EXAMPLES)]
    Signs(Signs),
    /// Hold the neutral pose without and with a known mass, and compare with the model of the machine.
    #[command(after_help = EXAMPLES)]
    Torque(torque_constant::Torque),
}

#[derive(Args)]
struct Signs {
    #[command(flatten)]
    config: ConfigArgs,
    #[command(flatten)]
    options: PowerArgs,
    /// Torque of the push in N m.
    #[arg(long, value_name = "N_M", default_value_t = 0.5)]
    torque: f64,
    /// Write what was found to this file.
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
}

/// The file of a calibration of signs.
#[derive(Debug, Serialize, Deserialize)]
struct Record {
    date: String,
    config_hash: String,
    #[serde(rename = "torque_N_m")]
    torque: f64,
    axis: Vec<Pushed>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Pushed {
    serial: u32,
    moved_rad: f64,
    fault: String,
}

/// Why signs are not found, or not trusted.
#[derive(Debug)]
enum SignsError {
    /// `--torque`, and the most that is allowed [N m].
    Torque {
        torque: f64,
        most: f64,
    },
    Wrong,
}

impl Display for SignsError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            SignsError::Torque { torque, most } => write!(
                f,
                "--torque {torque}: allowed above 0 and at most {most} N m (landing.torque_N_m, half of \
                 limits.torque_step_N_m)"
            ),
            SignsError::Wrong => f.write_str("not every axis follows its torque: do not run"),
        }
    }
}

impl Ends for SignsError {
    fn exit(&self) -> Exit {
        match self {
            SignsError::Torque { .. } => Exit::Usage,
            SignsError::Wrong => Exit::Failed,
        }
    }
}

/// The exit code of the command.
pub fn calibrate(args: &Calibrate) -> Exit {
    match &args.what {
        What::Signs(args) => signs(args),
        What::Torque(args) => torque_constant::find(args),
    }
}

fn signs(args: &Signs) -> Exit {
    let make = |config: &Config, system: &System| {
        let step = (0..AXES).map(|k| config.limits(k).torque_step).filter(|step| *step > 0.0);
        // it is reversed at once
        let most = step.fold(config.landing.torque, |most, step| most.min(0.5 * step));
        if !(args.torque > 0.0 && args.torque <= most) {
            return Err(SignsError::Torque { torque: args.torque, most }.into());
        }
        Ok(Task::Nudges(Box::new(Nudges::new(args.torque, system.base_step()))))
    };
    let tell = |reporter: Reporter, config: &Config, _: &System, out: &Outcome| {
        report_signs(args, reporter, config, out)
    };
    run::instead((&args.config, args.options), true, make, tell)
}

fn report_signs(
    args: &Signs,
    reporter: Reporter,
    config: &Config,
    out: &Outcome,
) -> Result<(), Refusal> {
    let Task::Nudges(nudges) = &out.task else { return Ok(()) };
    let mut axis = Vec::with_capacity(AXES);
    for (k, nudge) in nudges.done.iter().enumerate() {
        let (torque, moved_rad) = (args.torque, nudge.moved);
        let fault = nudge.fault().map_or(String::new(), |fault| fault.to_string());
        let text = format!("axis {}: {torque} N m moved it by {moved_rad:+.5} rad", k + 1);
        let sound = fault.is_empty();
        reporter.mark(sound, &if sound { text } else { format!("{text}: {fault}") });
        axis.push(Pushed { serial: out.serials[k], moved_rad, fault });
    }
    let wrong = axis.iter().any(|axis| !axis.fault.is_empty());
    reporter.event("signs", json!({ "axis": axis }));
    if let Some(path) = &args.write {
        let config_hash = format!("{:016x}", config.hash);
        let record = Record { date: now(), config_hash, torque: args.torque, axis };
        let head = "Signs of the axes, written by `flexhex-gateway calibrate signs`.";
        save(path, head, &record)?;
    }
    match wrong {
        true => Err(SignsError::Wrong.into()),
        false => {
            reporter.line(
                "next",
                "watch that each arm goes up: if not, change drive.direction of its axis",
            );
            Ok(())
        }
    }
}
