//! Lines for people on a terminal, and one JSON object a line with --json.

use serde_json::{json, Value};
use std::io::{IsTerminal, Write};

/// Width of the label at the left.
const WIDTH: usize = 11;

/// Writes text and events. With --json, stdout carries JSON only and text goes to stderr.
#[derive(Clone, Copy)]
pub struct Reporter {
    json: bool,
    colour: bool,
}

impl Reporter {
    pub fn new(json: bool) -> Reporter {
        let terminal =
            if json { std::io::stderr().is_terminal() } else { std::io::stdout().is_terminal() };
        Reporter { json, colour: terminal && std::env::var_os("NO_COLOR").is_none() }
    }

    /// A label on the left and its text on the right; further lines of the text have no label.
    pub fn line(&self, label: &str, text: &str) {
        let mut lines = text.lines();
        let first = lines.next().unwrap_or("");
        self.print(&format!("  {}{first}", self.dim(label)));
        for line in lines {
            self.print(&format!("  {}{line}", self.dim("")));
        }
    }

    pub fn title(&self, text: &str) {
        let text = if self.colour { format!("\x1b[1m{text}\x1b[0m") } else { text.to_owned() };
        self.print(&text);
    }

    /// A result with a tick or a cross.
    pub fn mark(&self, good: bool, text: &str) {
        let (sign, colour) = if good { ("✓", 32) } else { ("✗", 31) };
        let sign =
            if self.colour { format!("\x1b[{colour}m{sign}\x1b[0m") } else { sign.to_owned() };
        let mut lines = text.lines();
        self.print(&format!("{sign} {}", lines.next().unwrap_or("")));
        for line in lines {
            self.print(&format!("  {line}"));
        }
    }

    /// A JSON object on a line of its own, with --json only.
    pub fn event(&self, name: &str, mut value: Value) {
        if self.json {
            value["event"] = json!(name);
            // the reader may be gone; the run goes on
            let _ = writeln!(std::io::stdout(), "{value}");
        }
    }

    /// A status line that is rewritten; only on a terminal.
    pub fn live(&self, label: &str, text: &str) {
        if self.colour {
            let text = format!("\r\x1b[2K  {}{text}", self.dim(label));
            self.raw(&text);
        }
    }

    pub fn live_over(&self) {
        if self.colour {
            self.raw("\r\x1b[2K");
        }
    }

    /// Without a line end. The terminal may be gone; the run goes on.
    fn raw(&self, text: &str) {
        let _ = if self.json {
            write!(std::io::stderr(), "{text}")
        } else {
            write!(std::io::stdout(), "{text}")
        };
        let _ = std::io::stdout().flush();
    }

    fn print(&self, text: &str) {
        // the terminal may be gone; the run goes on
        let _ = if self.json {
            writeln!(std::io::stderr(), "{text}")
        } else {
            writeln!(std::io::stdout(), "{text}")
        };
    }

    fn dim(&self, label: &str) -> String {
        let padded = format!("{label:<WIDTH$}");
        if self.colour {
            format!("\x1b[2m{padded}\x1b[0m")
        } else {
            padded
        }
    }
}
