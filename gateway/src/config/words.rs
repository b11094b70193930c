//! What the TOML reader complains of, in words for whoever wrote the file.

/// The complaint with the line that it is about.
pub fn of(text: &str, why: &toml::de::Error) -> String {
    let start = why.span().map_or(0, |span| span.start.min(text.len()));
    let number = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count();
    let line = text.lines().nth(number).unwrap_or("").split(" #").next().unwrap_or("").trim();
    let quoted = if line.is_empty() { String::new() } else { format!(" `{line}`") };
    format!("line {}{quoted}: {}", number + 1, plain(why.message()))
}

/// The reader's words for kinds of values are those of the program.
fn plain(message: &str) -> String {
    const KINDS: [(&str, &str); 9] = [
        ("expected u8", "wanted a whole number from 0 to 255"),
        ("expected u16", "wanted a whole number from 0 to 65535"),
        ("expected u32", "wanted a whole number, 0 or more"),
        ("expected usize", "wanted a whole number, 0 or more"),
        ("expected i8", "wanted a whole number from -128 to 127"),
        ("expected i32", "wanted a whole number"),
        ("expected f64", "wanted a number"),
        ("expected a sequence", "wanted a list, as [2.0]"),
        ("expected a boolean", "wanted true or false"),
    ];
    let told = message.lines().collect::<Vec<_>>().join(", ");
    let found = KINDS.iter().find(|(theirs, _)| told.ends_with(theirs));
    match found {
        Some((theirs, ours)) => told.replace(theirs, ours),
        None => told,
    }
}
