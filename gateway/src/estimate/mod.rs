//! What the estimator has learned, from one run to the next: files beside the recordings.

mod file;
#[cfg(test)]
mod tests;

use flexhex_system::State;
use std::path::{Path, PathBuf};

use file::Estimates;

/// The states in a file, or why no run may start from them. `range`: largest |p - p0| / scale.
pub fn read(path: &Path, range: f64) -> Result<Vec<State>, String> {
    let at = |why: String| format!("{}: {why}", path.display());
    let mend = "give the -estimate.json of an earlier run";
    let text = std::fs::read_to_string(path).map_err(|why| at(format!("{why}: {mend}")))?;
    let states = Estimates::states(&text).map_err(|why| at(format!("{why}: {mend}")))?;
    for state in &states {
        check(state, range).map_err(at)?;
    }
    Ok(states)
}

/// Writes the states beside a recording, `a-estimate.json` beside `a.csv`. Nothing is overwritten.
pub fn write(
    recording: &Path,
    states: &[State],
    origin: &[(String, String)],
) -> Result<PathBuf, String> {
    let path = beside(recording);
    let failed = |why: std::io::Error| format!("{}: {why}: check the folder", path.display());
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
fn check(state: &State, range: f64) -> Result<(), String> {
    let name = &state.component;
    let parameter = |name: String| {
        state.parameters.iter().find(|(known, _)| *known == name).map(|(_, value)| *value)
    };
    for (output, value) in &state.outputs {
        let wrong = |why: String| {
            Err(format!("{name}.{output} = {value}{why}: start without the saved state"))
        };
        if !value.is_finite() {
            return wrong(", must be finite".to_owned());
        }
        if output == "fault" && *value != 0.0 {
            return wrong(", must be 0".to_owned());
        }
        let Some(element) = output.strip_prefix("p.") else { continue };
        let first = parameter(format!("p0.{element}"));
        let (Some(first), Some(scale)) = (first, parameter(format!("scale.{element}"))) else {
            continue;
        };
        let far = (value - first).abs() / scale;
        if far > range {
            return wrong(format!(
                ", {far:.3} times scale = {scale} from p0 = {first}, allowed {range} \
                 (estimate.range)"
            ));
        }
    }
    Ok(())
}
