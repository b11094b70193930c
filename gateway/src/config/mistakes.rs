//! Collects the mistakes of a configuration, so that all are reported at once.

use std::ops::RangeInclusive;

/// Mistakes as text, each `key = value, allowed range: how to mend it`.
#[derive(Default)]
pub struct Mistakes {
    lines: Vec<String>,
}

impl Mistakes {
    pub fn add(&mut self, text: String) {
        self.lines.push(text);
    }

    /// Add a mistake if a value lies outside its range.
    pub fn check_range(&mut self, key: &str, value: f64, range: RangeInclusive<f64>, mend: &str) {
        if !range.contains(&value) {
            let (low, high) = range.into_inner();
            self.add(format!("{key} = {value}, allowed {low} to {high}: {mend}"));
        }
    }

    /// Err with one mistake a line, if there is any.
    pub fn into_result(self) -> Result<(), String> {
        if self.lines.is_empty() {
            Ok(())
        } else {
            Err(self.lines.join("\n"))
        }
    }
}
