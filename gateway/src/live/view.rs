//! What a board shows, as JSON: columns by name, those of six axes as lists.

use serde_json::{json, Map, Value};
use std::sync::atomic::Ordering;

use super::board::Board;
use crate::bus::cia402;
use crate::record::Columns;

/// Words for the column `phase`.
const PHASES: [&str; 5] = ["enabling", "running", "disabling", "lifting off", "landing"];
/// Before the first cycle.
const FIRST: &str = "bringing up the bus";

/// The word for a value of that column.
pub fn phase(value: f64) -> Option<&'static str> {
    PHASES.get(value as usize).copied()
}

/// Everything that is shown of a run; `about`: what does not change during it.
pub fn view(board: &Board, columns: &Columns, about: &Value) -> Value {
    let count = |value: &std::sync::atomic::AtomicU64| value.load(Ordering::Relaxed);
    let row = board.read();
    let mut view = Map::new();
    for (name, value) in columns.names.iter().zip(row.iter().flatten()) {
        match name.strip_suffix(']').and_then(|name| name.rsplit_once('[')) {
            Some((name, _)) => match view.entry(name).or_insert_with(|| json!([])) {
                Value::Array(axes) => axes.push(json!(value)),
                other => *other = json!(value),
            },
            None => drop(view.insert(name.clone(), json!(value))),
        }
    }
    let begun = view.get("phase").and_then(Value::as_f64).and_then(phase);
    view.insert("phase".to_owned(), json!(begun.unwrap_or(FIRST)));
    if let Some(Value::Array(words)) = view.get("statusword") {
        let state = |word: &Value| cia402::state(word.as_f64().unwrap_or(0.0) as u16).name();
        let states: Vec<_> = words.iter().map(state).collect();
        view.insert("state".to_owned(), json!(states));
    }
    view.insert("lost".to_owned(), json!(count(&board.lost)));
    view.insert("short".to_owned(), json!(count(&board.short)));
    view.insert("skipped".to_owned(), json!(count(&board.skipped)));
    view.insert("about".to_owned(), about.clone());
    Value::Object(view)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_six_axes_become_lists_and_states_words() {
        let columns = Columns::with(&[("K.p.arm[1].mass".to_owned(), "kg".to_owned())]);
        let board = Board::new(columns.len());
        let nothing = view(&board, &columns, &json!({"system": "a.ssp"}));
        assert_eq!(nothing["phase"], "bringing up the bus");
        assert_eq!(nothing["about"]["system"], "a.ssp");
        let mut row: Vec<f64> = (0..columns.len()).map(|k| k as f64).collect();
        let at = |name: &str| columns.names.iter().position(|n| n == name).unwrap();
        (row[at("phase")], row[at("statusword[2]")]) = (4.0, f64::from(0x0237u16));
        row[at("theta[3]")] = f64::NAN;
        board.write(&row);
        let shown = view(&board, &columns, &Value::Null);
        assert_eq!((&shown["phase"], &shown["time"]), (&json!("landing"), &json!(0.0)));
        assert_eq!(shown["theta"].as_array().map(Vec::len), Some(6));
        assert_eq!(shown["theta"][2], Value::Null, "no reply, no angle");
        assert_eq!(shown["state"][1], "operation enabled");
        assert_eq!(shown["K.p.arm[1].mass"], json!(columns.len() as f64 - 1.0));
    }
}
