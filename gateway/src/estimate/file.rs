//! The file: JSON, values by name for people, the whole state of the FMU in hexadecimal digits.

use super::error::NoEstimate;
use crate::config::text_hash;
use flexhex_system::State;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write;

const FORMAT: &str = "flexhex estimate 2";

#[derive(Serialize, Deserialize)]
pub struct Estimates {
    format: String,
    /// Date, version, hash of the configuration, ...
    origin: BTreeMap<String, String>,
    states: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    component: String,
    guid: String,
    steps: i64,
    outputs: Vec<(String, f64)>,
    parameters: Vec<(String, f64)>,
    state: String,
    /// Of `state`, in which a covariance that was changed shows in no output before the next update.
    #[serde(default)]
    state_hash: String,
}

impl Estimates {
    pub fn text(states: &[State], origin: &[(String, String)]) -> String {
        let file = Estimates {
            format: FORMAT.to_owned(),
            origin: origin.iter().cloned().collect(),
            states: states.iter().map(Entry::of).collect(),
        };
        // only maps with keys that are no strings cannot be written
        serde_json::to_string_pretty(&file).unwrap_or_default() + "\n"
    }

    /// The states in the text of a file, at least one.
    pub fn states(text: &str) -> Result<Vec<State>, NoEstimate> {
        let file: Estimates = serde_json::from_str(text).map_err(NoEstimate::NotJson)?;
        if file.format != FORMAT {
            return Err(NoEstimate::Format(file.format, FORMAT));
        }
        if file.states.is_empty() {
            return Err(NoEstimate::Empty);
        }
        file.states.into_iter().map(Entry::state).collect()
    }
}

impl Entry {
    fn of(state: &State) -> Entry {
        let mut digits = String::with_capacity(2 * state.bytes.len());
        for byte in &state.bytes {
            // writing to a String does not fail
            let _ = write!(digits, "{byte:02x}");
        }
        Entry {
            component: state.component.clone(),
            guid: state.guid.clone(),
            steps: state.steps,
            outputs: state.outputs.clone(),
            parameters: state.parameters.clone(),
            state_hash: format!("{:016x}", text_hash(&digits)),
            state: digits,
        }
    }

    fn state(self) -> Result<State, NoEstimate> {
        let digits = self.state.as_bytes();
        if !digits.len().is_multiple_of(2) || !digits.iter().all(u8::is_ascii_hexdigit) {
            return Err(NoEstimate::NoDigits(self.component));
        }
        if self.state_hash != format!("{:016x}", text_hash(&self.state)) {
            return Err(NoEstimate::Changed(self.component));
        }
        let value = |digit: u8| char::from(digit).to_digit(16).unwrap_or(0) as u8;
        let bytes = digits.chunks(2).map(|pair| value(pair[0]) << 4 | value(pair[1])).collect();
        Ok(State {
            component: self.component,
            guid: self.guid,
            steps: self.steps,
            parameters: self.parameters,
            outputs: self.outputs,
            bytes,
        })
    }
}
