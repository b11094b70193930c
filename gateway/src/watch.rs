//! A run as other programs see it, and the end of one whose control loop hangs.

use serde_json::{json, Value};
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::arguments::ConfigArgs;
use crate::config::{Config, AXES};
use crate::exit::{Ends, Exit};
use crate::live::{self, Board, LiveError};
use crate::off;
use crate::record::{Closer, Columns};
use crate::report::Reporter;

/// A control loop without a cycle, or an FMU without an answer, for so long hangs.
pub const HANG_S: u32 = 3;
/// The same in looks of 0.1 s.
pub const HANG_LOOKS: u32 = 10 * HANG_S;
/// Longest wait until the files of a loop that hangs are closed.
const CLOSING: Duration = Duration::from_secs(5);

/// Ends a run whose control loop hangs in an FMU: nothing can be sent any more, so the drives end the torque
/// by their watchdog. Nobody may believe that: the process becomes `off`, which disables them and reads them
/// back.
pub fn hung(reporter: Reporter, component: Option<String>, closer: &Closer, config: &ConfigArgs) {
    let name = component.as_deref().unwrap_or("the control loop");
    let why = format!(
        "{name} hangs: no cycle for {HANG_S} s; the watchdog of the drives should have taken the torque: \
         disabling the drives and reading them back"
    );
    reporter.mark(false, &why);
    reporter.event("hung", json!({ "component": component, "message": why }));
    closer.close(&format!("hung: {why}"), CLOSING);
    let failed = off::in_place_of_this(config);
    reporter.refused(format!(
        "`off` cannot be started ({failed}): no drive is confirmed as disabled: use the emergency stop"
    ));
    std::process::exit(i32::from(Exit::Failed as u8));
}

/// Looks of 0.1 s without a beat after which the loop hangs. In lockstep each cycle may wait longer.
pub fn patience(lockstep: bool, config: &Config) -> u32 {
    match lockstep {
        true => HANG_LOOKS + config.bus.lockstep_timeout_ms / 50,
        false => HANG_LOOKS,
    }
}

/// An FMU that hangs in another thread than the control loop's, while drives may have power: the machine lands.
pub struct HungBeside(String);

impl HungBeside {
    pub fn told(component: String, reporter: Reporter) -> HungBeside {
        let why = HungBeside(component);
        reporter.mark(false, &format!("{why}: the machine lands"));
        reporter.event("hung", json!({ "component": why.0, "message": why.to_string() }));
        why
    }
}

impl Display for HungBeside {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "{} hangs: no answer for {HANG_S} s", self.0)
    }
}

impl Ends for HungBeside {
    fn exit(&self) -> Exit {
        Exit::Failed
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
