//! Errors: one text with what, where and how to mend it.

use std::fmt;

/// A system that cannot be read or run.
#[derive(Debug, Clone, PartialEq)]
pub struct Error(String);

impl Error {
    pub(crate) fn new(text: impl Into<String>) -> Error {
        Error(text.into())
    }

    /// The same error with the place in front.
    pub(crate) fn at(self, place: impl fmt::Display) -> Error {
        Error(format!("{place}: {}", self.0))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

/// Text for a name that does not exist, with the nearest one that does.
pub(crate) fn unknown<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    let near = known.iter().map(|k| (distance(name, k), k)).min();
    match near {
        Some((steps, near)) if 2 * steps <= name.chars().count() => {
            format!("there is no {what} '{name}', did you mean '{near}'?")
        }
        _ if known.is_empty() => format!("there is no {what} '{name}', there are none"),
        _ => {
            let more = if known.len() > 12 { ", ..." } else { "" };
            let shown = known[..known.len().min(12)].join(", ");
            format!("there is no {what} '{name}', there are {shown}{more}")
        }
    }
}

/// Letters to insert, delete or replace between two words (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_not_there_names_the_nearest_one() {
        let text = unknown("component", "plnat", ["plant", "feedback"]);
        assert_eq!(text, "there is no component 'plnat', did you mean 'plant'?");
        let text = unknown("component", "drives", ["plant", "K"]);
        assert_eq!(text, "there is no component 'drives', there are plant, K");
    }
}
