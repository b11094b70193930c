//! What the controllers of the devices counted, by cable, and how far their clocks were off.

use serde_json::{json, Value};

use super::terminal::Reporter;
use crate::bus::{largest, Clocks, Count, Links, PortErrors, KINDS};

/// Over which time something was counted.
pub const IN_THE_RUN: &str = "in the run";
const SINCE_POWER_UP: &str = "since power-up";

impl Reporter {
    /// Counts since power-up, as `check --bus` reads them.
    pub fn links(&self, links: &Links) {
        print(self, links, SINCE_POWER_UP);
        if links.known && links.ports.is_empty() {
            self.mark(true, &format!("cables: no error counted {SINCE_POWER_UP}"));
        }
        self.event("links", json!({ "ports": ports(links), "unread": links.unread }));
    }
}

/// A line for each port at which an error occurred; what was passed on is told together.
pub fn print(reporter: &Reporter, links: &Links, since: &str) {
    if !links.known {
        return;
    }
    let (passed_on, own): (Vec<_>, Vec<_>) = links.ports.iter().partition(|p| p.only_forwards());
    for port in &own {
        reporter.line("cable", &sentence(port, since));
    }
    if !passed_on.is_empty() {
        let mut positions: Vec<_> = passed_on.iter().map(|port| port.position).collect();
        positions.dedup();
        let cause = match own.iter().any(|port| port.is_disturbed()) {
            true => "no fault of their own cables",
            false => "no device counted the damage itself: look at the two cables before the first of them",
        };
        let text = format!("positions {positions:?} passed on damaged frames {since}: {cause}");
        reporter.line("cable", &text);
    }
    if !links.unread.is_empty() {
        let text = format!("error counters of positions {:?} were not read", links.unread);
        reporter.line("cable", &text);
    }
}

fn sentence(port: &PortErrors, since: &str) -> String {
    let counted = KINDS.iter().zip(port.counts).filter(|(_, count)| !count.is_none());
    let counted: Vec<_> = counted.map(|((name, _), count)| words(name, count)).collect();
    let axis = port.axis.map_or(String::new(), |axis| format!(" (axis {})", axis + 1));
    let remedy = match port.lost_the_link() {
        true => "a loose plug, a broken cable, or the device at its other end was without supply",
        false => "check plugs and shield, keep it away from motor cables, or replace it",
    };
    let (position, name) = (port.position, port_name(port.port));
    format!(
        "position {position}{axis}, port {name}: {} {since}: {}: {remedy}",
        counted.join(", "),
        cable(port)
    )
}

fn words(name: &str, count: Count) -> String {
    match count {
        Count { number: 0, full: true } => {
            format!("{name} not known (the counter was full at 255 before: switch the device off and on)")
        }
        Count { number, full: true } => {
            format!("at least {number} {name} (the counter stops at 255)")
        }
        Count { number, .. } => format!("{number} {name}"),
    }
}

fn port_name(port: usize) -> String {
    match port {
        0 => "IN".to_owned(),
        1 => "OUT".to_owned(),
        other => other.to_string(),
    }
}

/// The cable at a port of a device in a line.
fn cable(port: &PortErrors) -> String {
    match (port.port, port.position) {
        (0, 0) => "cable from this computer to position 0".to_owned(),
        (0, k) => format!("cable from position {} to position {k}", k - 1),
        (1, k) if !port.last => format!("cable from position {k} to position {}", k + 1),
        (1, _) => "port OUT of the last device, where nothing should be plugged in".to_owned(),
        _ => "cable at this port".to_owned(),
    }
}

/// Ports at which something was counted.
pub fn ports(links: &Links) -> Vec<Value> {
    links.ports.iter().map(one).collect()
}

fn one(port: &PortErrors) -> Value {
    let mut value = json!({"position": port.position, "axis": port.axis.map(|axis| axis + 1),
        "port": port.port, "cable": cable(port)});
    for ((_, key), count) in KINDS.iter().zip(port.counts) {
        value[*key] = json!(count.number);
    }
    let full = KINDS.iter().zip(port.counts).filter(|(_, count)| count.full);
    value["full"] = json!(full.map(|((_, key), _)| key).collect::<Vec<_>>());
    value
}

/// The largest difference before power and at the end, where any drive has a distributed clock.
pub fn print_clocks(reporter: &Reporter, clocks: &Clocks) {
    let words = [(&clocks.start, "before power"), (&clocks.end, "at the end")];
    let phrases = words.iter().filter_map(|(differences, when)| {
        let (axis, size) = largest(differences)?;
        let above = match size > clocks.bound_ns {
            true => format!(" (above bus.clock_difference_ns = {})", clocks.bound_ns),
            false => String::new(),
        };
        Some(format!("{size} ns {when} (axis {}){above}", axis + 1))
    });
    let phrases: Vec<_> = phrases.collect();
    if !phrases.is_empty() {
        reporter.line("clocks", &format!("largest difference {}", phrases.join(", ")));
    }
}

/// Differences by axis [ns]; null without distributed clocks.
pub fn clocks(clocks: &Clocks) -> Value {
    let all = clocks.start.iter().chain(&clocks.end).flatten();
    let Some(most) = all.map(|ns| ns.unsigned_abs()).max() else { return Value::Null };
    json!({"bound_ns": clocks.bound_ns, "start_ns": clocks.start, "end_ns": clocks.end,
        "largest_ns": most})
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(position: usize, port: usize, numbers: [u8; 4]) -> PortErrors {
        let counts = numbers.map(|number| Count { number, full: number == 255 });
        PortErrors { position, axis: Some(position), port, last: position == 5, counts }
    }

    #[test]
    fn a_sentence_names_device_port_counts_cable_and_remedy() {
        assert_eq!(
            sentence(&port(2, 0, [12, 13, 0, 0]), IN_THE_RUN),
            "position 2 (axis 3), port IN: 12 invalid frames, 13 receive errors in the run: cable from position 1 to \
             position 2: check plugs and shield, keep it away from motor cables, or replace it"
        );
        let lost = sentence(&port(0, 0, [0, 0, 0, 1]), SINCE_POWER_UP);
        assert!(lost.contains(
            "1 lost links since power-up: cable from this computer to position 0: a loose"
        ));
        assert!(sentence(&port(4, 1, [0, 1, 0, 0]), "").contains("position 4 to position 5"));
        assert!(
            sentence(&port(5, 1, [0, 1, 0, 0]), "").contains("where nothing should be plugged in")
        );
        assert!(
            sentence(&port(3, 2, [0, 1, 0, 0]), "").contains("port 2: 1 receive errors : cable at")
        );
    }

    #[test]
    fn a_full_counter_is_told_as_such() {
        let count = |number| words("receive errors", Count { number, full: true });
        assert_eq!(count(5), "at least 5 receive errors (the counter stops at 255)");
        assert!(
            count(0).starts_with("receive errors not known (the counter was full at 255 before")
        );
        let value = one(&port(1, 0, [0, 255, 0, 0]));
        assert_eq!((&value["full"], &value["axis"]), (&json!(["receive_errors"]), &json!(2)));
    }

    #[test]
    fn clocks_are_null_where_none_was_read() {
        let mut read = Clocks { bound_ns: 2500, ..Clocks::default() };
        assert_eq!(clocks(&read), Value::Null);
        (read.start[0], read.end[2]) = (Some(-12), Some(-7000));
        assert_eq!(clocks(&read)["largest_ns"], 7000);
    }
}
