//! Rights of the process: locked memory, priority, CPU.

use crate::config::Config;
use crate::realtime;
use crate::wire::Socket;

/// Request the real-time settings of the configuration; lockstep needs none. Returns a note on each
/// that was not granted, with its remedy; on a live machine (`enable`) that is an error.
pub fn request_real_time(
    config: &Config,
    lockstep: bool,
    enable: bool,
) -> Result<Vec<String>, String> {
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
    if enable && live && !missing.is_empty() {
        return Err(format!(
            "{}\na live machine is not enabled without these rights; real_time.required = false allows \
             it",
            missing.join("\n")
        ));
    }
    Ok(missing)
}
