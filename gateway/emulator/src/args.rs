//! The command line: flags that replace values of an options file.
use crate::drive::kind::Kind;
use crate::error::Error;
use crate::options::Options;
use std::path::{Path, PathBuf};

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway emulate --interface veth0 --system out/hexapod.ssp
  flexhex-gateway emulate --interface veth0 --system out/hexapod.ssp --fmu out/fmus/machine.fmu \
--drives cst --lockstep --json --cycles 40000

Without --system six flywheels replace the machine. Ctrl-C ends the emulation.";

/// Flags; each replaces a value of the options file.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Args {
    /// Network interface of the emulated drives: one end of a veth pair or a free port
    #[arg(long, short, value_name = "NAME")]
    pub interface: Option<String>,
    /// Options file (TOML): drives, plant, faults
    #[arg(long, short, value_name = "FILE")]
    pub options: Option<PathBuf>,
    /// System description (.ssp) whose component `plant` is the machine
    #[arg(long, value_name = "FILE")]
    pub system: Option<PathBuf>,
    /// FMU that replaces the component `plant`, for example out/fmus/machine.fmu
    #[arg(long, value_name = "FILE")]
    pub fmu: Option<PathBuf>,
    /// Type of all drives: akd (Kollmorgen AKD, torque mode) or cst (CiA 402, cyclic synchronous torque)
    #[arg(long, value_name = "TYPE")]
    pub drives: Option<String>,
    /// Let each process-data frame advance the plant by one base step instead of the clock
    #[arg(long)]
    pub lockstep: bool,
    /// Write one JSON object for each event
    #[arg(long)]
    pub json: bool,
    /// Write every plant cycle to this CSV file, in the form of a measured log
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// End after this number of plant cycles (0.25 ms each for the hexapod)
    #[arg(long, value_name = "N")]
    pub cycles: Option<u64>,
}

impl Args {
    /// The options of the file with the flags applied.
    pub fn options(&self) -> Result<Options, Error> {
        let mut options = match &self.options {
            Some(path) => read(path)?,
            None => Options::default(),
        };
        if let Some(name) = &self.drives {
            options.drives.kind = match name.as_str() {
                "akd" => Kind::Akd,
                "cst" => Kind::Cst,
                _ => return Err(Error::new(format!("--drives {name}: allowed akd or cst"))),
            };
        }
        let Args { interface, system, fmu, log, cycles, .. } = self.clone();
        options.interface = interface.unwrap_or(options.interface);
        options.plant.system = system.or(options.plant.system);
        options.plant.fmu = fmu.or(options.plant.fmu);
        options.log = log.or(options.log);
        options.cycles = cycles.or(options.cycles);
        options.lockstep |= self.lockstep;
        options.json |= self.json;
        options.check()?;
        Ok(options)
    }
}

/// Reads the options file; paths of the plant are relative to its folder.
fn read(path: &Path) -> Result<Options, Error> {
    let wrong = |what: String| Error::new(format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
    let mut options: Options = toml::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    for file in [&mut options.plant.system, &mut options.plant.fmu].into_iter().flatten() {
        *file = folder.join(&*file);
    }
    Ok(options)
}
