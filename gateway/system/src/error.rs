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

/// `p.actuator[1].d` for `p[3]`, where the elements of p have names; known: in the order of the
/// model description, by which elements were counted before.
pub(crate) fn renamed<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let (array, index) = name.strip_suffix(']')?.split_once('[')?;
    let index: usize = index.parse().ok()?;
    let starts = [format!("{array}."), format!("{array}[")];
    let elements: Vec<&str> =
        known.into_iter().filter(|k| starts.iter().any(|s| k.starts_with(s.as_str()))).collect();
    let new = elements.get(index.checked_sub(1)?)?;
    (!array.contains('.') && !elements.contains(&name)).then_some(*new)
}

/// Text for a name that does not exist, with its new name or the nearest one that does.
pub(crate) fn unknown<'a>(
    what: &str,
    name: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    if let Some(new) = renamed(name, known.iter().copied()) {
        return format!("there is no {what} '{name}', it is called '{new}'");
    }
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
    fn an_element_that_was_counted_is_known_by_its_name() {
        let known = ["x_E.x", "x_E.y", "p.actuator[1].o", "p.end.m", "theta[1]", "theta[2]"];
        let text = unknown("variable", "p[2]", known);
        assert_eq!(text, "there is no variable 'p[2]', it is called 'p.end.m'");
        assert_eq!(renamed("x_E[1]", known), Some("x_E.x"));
        for name in ["x_E[3]", "x_E[0]", "theta[3]", "theta[1]", "p.actuator[1]", "q[1]"] {
            assert_eq!(renamed(name, known), None, "{name}");
        }
    }

    #[test]
    fn a_name_that_is_not_there_names_the_nearest_one() {
        let text = unknown("component", "plnat", ["plant", "feedback"]);
        assert_eq!(text, "there is no component 'plnat', did you mean 'plant'?");
        let text = unknown("component", "drives", ["plant", "K"]);
        assert_eq!(text, "there is no component 'drives', there are plant, K");
    }
}
