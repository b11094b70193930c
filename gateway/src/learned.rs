//! What the estimator learns: taken from an earlier run before this one, saved after it.

use flexhex_system::{Error, State};
use serde_json::json;
use std::path::Path;

use crate::config::Config;
use crate::cycle::{Ending, Outcome};
use crate::estimate::{self, EstimateError};
use crate::record::provenance;
use crate::report::Reporter;

/// States of an earlier run that the configuration names.
pub fn resumed(config: &Config) -> Result<Vec<State>, EstimateError> {
    let Some(path) = &config.estimate.resume else { return Ok(Vec::new()) };
    estimate::read(path, config.estimate.range)
}

/// What was learned in a run that ended as wanted. After a trip nothing is saved, as what tripped may
/// have spoilt it.
pub fn save(
    reporter: Reporter,
    (out, learned): (&Outcome, Vec<Result<State, Error>>),
    recording: &Path,
    config: &Config,
) -> Result<(), EstimateError> {
    if !matches!(out.ending, Ending::Done | Ending::StopRequested) || out.cycles == 0 {
        return Ok(());
    }
    let mut states = Vec::new();
    for state in learned {
        match state {
            Ok(state) => states.push(state),
            Err(why) => reporter.line("estimate", &format!("not saved: {why}")),
        }
    }
    if states.is_empty() {
        return Ok(());
    }
    let mut origin = provenance(config.hash);
    origin.push(("recording".to_owned(), recording.display().to_string()));
    origin.push(("system".to_owned(), config.system.ssp.display().to_string()));
    let file = estimate::write(recording, &states, &origin)?;
    reporter.line("estimate", &format!("{} (--resume)", file.display()));
    reporter.event("estimate", json!({ "file": file }));
    Ok(())
}
