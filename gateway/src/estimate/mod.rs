//! What the estimator has learned, from one run to the next: files beside the recordings.

mod error;
mod file;
#[cfg(test)]
mod tests;

use flexhex_system::State;
use std::path::{Path, PathBuf};

pub use error::EstimateError;
use error::{Fault, Unfit};
use file::Estimates;

/// The states in a file, or why no run may start from them. `range`: largest |p - p0| / scale.
pub fn read(path: &Path, range: f64) -> Result<Vec<State>, EstimateError> {
    let at = |why: Fault| EstimateError { file: path.to_owned(), why };
    let text = std::fs::read_to_string(path).map_err(|why| at(Fault::Unreadable(why)))?;
    let states = Estimates::states(&text).map_err(|why| at(Fault::NoEstimate(why)))?;
    states.iter().try_for_each(|state| check(state, range)).map_err(at)?;
    Ok(states)
}

/// Writes the states beside a recording, `a-estimate.json` beside `a.csv`. Nothing is overwritten.
pub fn write(
    recording: &Path,
    states: &[State],
    origin: &[(String, String)],
) -> Result<PathBuf, EstimateError> {
    let path = beside(recording);
    let failed = |why| EstimateError { file: path.clone(), why: Fault::NotWritten(why) };
    let text = Estimates::text(states, origin);
    let mut file = std::fs::File::create_new(&path).map_err(failed)?;
    std::io::Write::write_all(&mut file, text.as_bytes()).map_err(failed)?;
    file.sync_all().map_err(failed)?;
    Ok(path)
}

/// The first of `a-estimate.json`, `a-estimate-2.json`, ... that does not exist.
fn beside(recording: &Path) -> PathBuf {
    let stem = recording.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = |n: u32| match n {
        1 => format!("{stem}-estimate.json"),
        n => format!("{stem}-estimate-{n}.json"),
    };
    let mut all = (1..).map(|n| recording.with_file_name(name(n)));
    all.find(|path| !path.exists()).unwrap_or_else(|| recording.with_file_name(name(1)))
}

/// Outputs are finite, no fault is shown, and every `p.x` with a parameter `p0.x` is near it.
fn check(state: &State, range: f64) -> Result<(), Fault> {
    let parameter = |name: String| {
        state.parameters.iter().find(|(known, _)| *known == name).map(|(_, value)| *value)
    };
    for (output, value) in &state.outputs {
        let wrong = |why: Unfit| {
            let (component, output) = (state.component.clone(), output.clone());
            Err(Fault::Unfit { component, output, value: *value, why })
        };
        if !value.is_finite() {
            return wrong(Unfit::NotFinite);
        }
        if output == "fault" && *value != 0.0 {
            return wrong(Unfit::Fault);
        }
        let Some(element) = output.strip_prefix("p.") else { continue };
        let first = parameter(format!("p0.{element}"));
        let (Some(first), Some(scale)) = (first, parameter(format!("scale.{element}"))) else {
            continue;
        };
        let far = (value - first).abs() / scale;
        if far > range {
            return wrong(Unfit::Far { far, scale, first, range });
        }
    }
    Ok(())
}
