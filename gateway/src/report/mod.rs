//! What a person or a script is told: calm lines on a terminal, one JSON object a line with --json.

mod summary;

use serde_json::{json, Value};
use std::io::{IsTerminal, Write};

use crate::bus::{cia402, Found};
use crate::cycle::{Ending, Outcome};
use crate::record::Written;
use crate::safety::Trip;

const WIDTH: usize = 11;

/// Where words go. With --json, stdout carries JSON only and words go to stderr.
#[derive(Clone, Copy)]
pub struct Teller {
    json: bool,
    colour: bool,
}

impl Teller {
    pub fn new(json: bool) -> Teller {
        let terminal =
            if json { std::io::stderr().is_terminal() } else { std::io::stdout().is_terminal() };
        Teller { json, colour: terminal && std::env::var_os("NO_COLOR").is_none() }
    }

    /// A line: a short word on the left, what there is to say of it on the right.
    pub fn line(&self, what: &str, text: &str) {
        let mut lines = text.lines();
        let first = lines.next().unwrap_or("");
        self.words(&format!("  {}{first}", self.dim(what)));
        for more in lines {
            self.words(&format!("  {}{more}", self.dim("")));
        }
    }

    pub fn title(&self, text: &str) {
        let text = if self.colour { format!("\x1b[1m{text}\x1b[0m") } else { text.to_owned() };
        self.words(&text);
    }

    /// Good or bad, after a mark.
    pub fn mark(&self, good: bool, text: &str) {
        let (sign, colour) = if good { ("✓", 32) } else { ("✗", 31) };
        let sign =
            if self.colour { format!("\x1b[{colour}m{sign}\x1b[0m") } else { sign.to_owned() };
        let mut lines = text.lines();
        self.words(&format!("{sign} {}", lines.next().unwrap_or("")));
        for more in lines {
            self.words(&format!("  {more}"));
        }
    }

    /// A JSON object on a line of its own, with --json only.
    pub fn event(&self, name: &str, mut value: Value) {
        if self.json {
            value["event"] = json!(name);
            // whoever read it may be gone; the machine goes on
            let _ = writeln!(std::io::stdout(), "{value}");
        }
    }

    /// The line that changes while the machine runs; only a terminal shows it.
    pub fn live(&self, text: &str) {
        if self.colour {
            let text = format!("\r\x1b[2K  {}{text}", self.dim("running"));
            if self.json {
                eprint!("{text}");
            } else {
                print!("{text}");
            }
            let _ = std::io::stdout().flush();
        }
    }

    pub fn live_over(&self) {
        if self.colour {
            let clear = "\r\x1b[2K";
            if self.json {
                eprint!("{clear}");
            } else {
                print!("{clear}");
            }
        }
    }

    pub fn found(&self, found: &[Found]) {
        for f in found {
            let state = cia402::state(f.statusword).words();
            let id = format!("{:#x}/{:#x}", f.vendor_id, f.product_code);
            let text = format!("{:<14} {id:<16} serial {:<10} {state}", f.name, f.serial);
            self.line(&format!("drive {}", f.position), &text);
            self.event(
                "device",
                json!({"position": f.position, "name": f.name, "vendor": f.vendor_id,
                    "product": f.product_code, "revision": f.revision, "serial": f.serial,
                    "state": state}),
            );
        }
    }

    pub fn refused(&self, why: &str) {
        self.mark(false, why);
        self.event("refused", json!({ "message": why }));
    }

    /// How a run ended, with its figures.
    pub fn outcome(&self, out: &Outcome, written: &Written) {
        match &out.ending {
            Ending::Done => self.mark(true, "done, drives disabled"),
            Ending::Asked => self.mark(true, "ended as asked, drives disabled"),
            Ending::Refused(why) => self.refused(why),
            Ending::Tripped(trip, said) => self.trip(trip, said, out),
        }
        summary::tell(self, out, written);
    }

    fn trip(&self, trip: &Trip, said: &str, out: &Outcome) {
        self.mark(false, &format!("tripped: {trip}"));
        if !said.is_empty() {
            self.line("", said);
        }
        let disabled = out
            .to_disabled
            .map_or("not confirmed".to_owned(), |n| format!("disabled {n} cycles after it"));
        self.line(
            "reaction",
            &format!("zero torque {} cycles after the trip, {disabled}", out.to_zero),
        );
        self.event(
            "trip",
            json!({"reason": trip.reason.key(), "axis": trip.axis.map(|a| a + 1),
                "value": trip.value, "limit": trip.limit, "cycle": trip.cycle,
                "message": trip.to_string(), "said": said,
                "cycles_to_zero": out.to_zero, "cycles_to_disabled": out.to_disabled}),
        );
    }

    fn words(&self, text: &str) {
        if self.json {
            eprintln!("{text}");
        } else {
            println!("{text}");
        }
    }

    fn dim(&self, what: &str) -> String {
        let padded = format!("{what:<WIDTH$}");
        if self.colour {
            format!("\x1b[2m{padded}\x1b[0m")
        } else {
            padded
        }
    }
}
