//! Rights of the process: locked memory, priority, CPU.

use std::fmt::{self, Display, Formatter};

use crate::config::Config;
use crate::exit::{Ends, Exit};
use crate::realtime::{self, Denied};
use crate::wire::Socket;

/// Rights without which a live machine is not enabled.
#[derive(Debug)]
pub struct RightsError(Vec<Denied>);

impl Display for RightsError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        self.0.iter().try_for_each(|denied| writeln!(f, "{denied}"))?;
        f.write_str(
            "a live machine is not enabled without these rights; real_time.required = false allows it",
        )
    }
}

impl Ends for RightsError {
    fn exit(&self) -> Exit {
        Exit::Failed
    }
}

/// Request the real-time settings of the configuration; lockstep needs none. Returns those that were not
/// granted; on a live machine (`enable`) they are an error.
pub fn request_real_time(
    config: &Config,
    lockstep: bool,
    enable: bool,
) -> Result<Vec<Denied>, RightsError> {
    let r = &config.real_time;
    if lockstep {
        return Ok(Vec::new());
    }
    let mut missing = Vec::new();
    if r.lock_memory {
        missing.extend(realtime::lock_memory().err());
    }
    if let Some(cpu) = r.cpu {
        missing.extend(realtime::pin_to(cpu).err());
    }
    if r.priority > 0 {
        missing.extend(realtime::set_fifo(r.priority).err());
    }
    let live = r.required.unwrap_or_else(|| Socket::is_hardware(&config.bus.interface));
    match enable && live && !missing.is_empty() {
        true => Err(RightsError(missing)),
        false => Ok(missing),
    }
}
