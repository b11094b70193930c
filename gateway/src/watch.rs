//! A run as other programs see it, and the end of one whose control loop hangs.

use flexhex_system::Watch;
use serde_json::{json, Value};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::arguments::ConfigArgs;
use crate::config::{Config, AXES};
use crate::exit::Exit;
use crate::live::{self, Board, LiveError};
use crate::off;
use crate::record::{Closer, Columns};
use crate::report::Reporter;

/// A control loop without a cycle, or an FMU without an answer, for so long hangs.
pub const HANG_S: u32 = 3;
/// Longest wait until the files of a loop that hangs are closed.
const CLOSING: Duration = Duration::from_secs(5);

/// Ends a run whose control loop hangs in an FMU: nothing can be sent any more, so the drives end the torque
/// by their watchdog. Nobody may believe that: the process becomes `off`, which disables them and reads them
/// back.
pub fn hung(reporter: Reporter, watch: &Watch, closer: &Closer, config: &ConfigArgs) {
    let component = watch.component().unwrap_or("the control loop");
    let why = format!(
        "{component} hangs: no cycle for {HANG_S} s; the watchdog of the drives should have taken the torque: \
         disabling the drives and reading them back"
    );
    reporter.mark(false, &why);
    reporter.event("hung", json!({ "component": watch.component(), "message": why }));
    closer.close(&format!("hung: {why}"), CLOSING);
    let failed = off::in_place_of_this(config);
    reporter.refused(format!(
        "`off` cannot be started ({failed}): no drive is confirmed as disabled: use the emergency stop"
    ));
    std::process::exit(i32::from(Exit::Failed as u8));
}

/// Looks of 0.1 s without a beat after which the loop hangs. In lockstep each cycle may wait longer.
pub fn patience(lockstep: bool, config: &Config) -> u32 {
    let looks = HANG_S * 10;
    match lockstep {
        true => looks + config.bus.lockstep_timeout_ms / 50,
        false => looks,
    }
}

/// What does not change during a run.
fn about(recording: Option<&Path>, config: &Config) -> Value {
    let torque: Vec<_> = (0..AXES).map(|k| config.limits(k).torque).collect();
    json!({"system": config.system.ssp, "drives": config.profile.name,
        "interface": config.bus.interface, "recording": recording,
        "version": env!("CARGO_PKG_VERSION"), "config_hash": format!("{:016x}", config.hash),
        "torque_N_m": torque})
}

/// Show the run to other programs of this computer.
pub fn serve(
    config: &Config,
    (page, recording): (Option<u16>, Option<&Path>),
    board: &Arc<Board>,
    columns: &Columns,
) -> Result<(), LiveError> {
    let shown = || {
        let (board, columns, about) =
            (Arc::clone(board), columns.clone(), about(recording, config));
        move || live::view(&board, &columns, &about).to_string()
    };
    live::serve_status(&config.bus.interface, shown())?;
    match page {
        Some(port) => live::serve_page(&config.bus.interface, port, shown()),
        None => Ok(()),
    }
}
