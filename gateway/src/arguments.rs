//! The configuration of a command, as its arguments name it.

use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

use crate::config::{self, Config, ConfigError};
use crate::report::Reporter;

/// The configuration file and the values that the command line replaces in it.
#[derive(Args, Clone)]
pub struct ConfigArgs {
    /// Configuration of the machine (TOML), for example gateway/machines/akd.toml.
    config: PathBuf,
    /// Network interface of the drives, for example eth1; replaces bus.interface.
    #[arg(long, value_name = "NAME")]
    interface: Option<String>,
    /// System description (.ssp); replaces system.ssp.
    #[arg(long, value_name = "FILE")]
    ssp: Option<PathBuf>,
    /// Replace one value of the configuration, for example --set safety.overrun_us=20000; may be
    /// repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Write one JSON object a line to stdout and the text for people to stderr.
    #[arg(long)]
    json: bool,
}

impl ConfigArgs {
    /// The same as words of a command line.
    pub fn words(&self) -> Vec<OsString> {
        let mut words = vec![self.config.clone().into_os_string()];
        if let Some(name) = &self.interface {
            words.extend(["--interface".into(), name.into()]);
        }
        if let Some(file) = &self.ssp {
            words.extend(["--ssp".into(), file.into()]);
        }
        for change in &self.set {
            words.extend(["--set".into(), change.into()]);
        }
        words.extend(self.json.then(|| "--json".into()));
        words
    }

    pub fn reporter(&self) -> Reporter {
        Reporter::new(self.json)
    }

    /// The checked configuration, with the offsets of its homing file.
    pub fn read(&self) -> Result<Config, ConfigError> {
        let mut config = self.read_unhomed()?;
        config.home()?;
        Ok(config)
    }

    /// The same with the offsets that stand in the configuration itself.
    pub fn read_unhomed(&self) -> Result<Config, ConfigError> {
        let mut config = config::read(&self.config, &self.set)?;
        if let Some(interface) = &self.interface {
            config.bus.interface.clone_from(interface);
        }
        if let Some(ssp) = &self.ssp {
            config.system.ssp.clone_from(ssp);
        }
        Ok(config)
    }
}
