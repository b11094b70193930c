//! The command line: flags over an options file.
use crate::drive::kind::Kind;
use crate::error::Error;
use crate::options::Options;
use std::path::{Path, PathBuf};

/// Flags; each stands over what the options file says.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Args {
    /// Network interface the SubDevices hang on (one end of a veth pair, or a free port)
    #[arg(long, short)]
    pub interface: Option<String>,
    /// Options file (TOML): drives, plant, faults
    #[arg(long, short)]
    pub options: Option<PathBuf>,
    /// System description whose `plant` moves
    #[arg(long)]
    pub system: Option<PathBuf>,
    /// FMU in the place of the system's `plant` (plant.fmu or machine.fmu)
    #[arg(long)]
    pub fmu: Option<PathBuf>,
    /// Kind of all drives: akd or cst
    #[arg(long)]
    pub drives: Option<String>,
    /// One process-data frame is one base step; nobody sleeps
    #[arg(long)]
    pub lockstep: bool,
    /// One JSON line for each event
    #[arg(long)]
    pub json: bool,
    /// Write every plant cycle to this file (CSV, as a measured log)
    #[arg(long)]
    pub log: Option<PathBuf>,
    /// End after this many plant cycles
    #[arg(long)]
    pub cycles: Option<u64>,
}

impl Args {
    /// Reads the options file and lays the flags over it.
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

/// Paths of the plant are taken from the folder of the file.
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
