//! Errors of the TOML reader with line and plain names of types.

use super::mistakes::Mistake;

/// The error with its line number and line.
pub fn describe(text: &str, why: &toml::de::Error) -> Mistake {
    let (number, line) = place(text, why);
    let quoted = if line.is_empty() { String::new() } else { format!(" `{line}`") };
    Mistake::Form(format!("line {}{quoted}: {}", number + 1, plain(why.message())))
}

/// The same of a text whose file has no such mistake: `--set` made it, and its lines are not those of the file.
pub fn describe_change(text: &str, why: &toml::de::Error) -> Mistake {
    Mistake::Change { change: place(text, why).1.to_owned(), why: plain(why.message()) }
}

/// Number and content of its line.
fn place<'a>(text: &'a str, why: &toml::de::Error) -> (usize, &'a str) {
    let start = why.span().map_or(0, |span| span.start.min(text.len()));
    let number = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count();
    let line = text.lines().nth(number).unwrap_or("").split(" #").next().unwrap_or("").trim();
    (number, line)
}

/// Replaces the reader's names of Rust types.
fn plain(message: &str) -> String {
    const KINDS: [(&str, &str); 9] = [
        ("expected u8", "expected a whole number from 0 to 255"),
        ("expected u16", "expected a whole number from 0 to 65535"),
        ("expected u32", "expected a whole number, 0 or more"),
        ("expected usize", "expected a whole number, 0 or more"),
        ("expected i8", "expected a whole number from -128 to 127"),
        ("expected i32", "expected a whole number"),
        ("expected f64", "expected a number"),
        ("expected a sequence", "expected a list such as [2.0]"),
        ("expected a boolean", "expected true or false"),
    ];
    let text = message.lines().collect::<Vec<_>>().join(", ");
    let rule = KINDS.iter().find(|(theirs, _)| text.ends_with(theirs));
    match rule {
        Some((theirs, ours)) => text.replace(theirs, ours),
        None => text,
    }
}
