//! Events as a line of text or a JSON object.
use std::time::Duration;

#[derive(Debug, Clone, PartialEq)]
pub enum EventKind {
    Ready {
        interface: String,
        drives: usize,
        lockstep: bool,
    },
    /// Application-layer state of a SubDevice; code: AL status code.
    State {
        position: usize,
        from: &'static str,
        to: &'static str,
        code: u16,
    },
    /// CiA 402 state of a drive; error: object 0x603F.
    Drive {
        position: usize,
        from: &'static str,
        to: &'static str,
        error: u16,
    },
    /// All drives are enabled: the plant moves from this cycle on.
    Enabled,
    Watchdog {
        position: usize,
    },
    /// A drive stored its parameters (object 0x1010).
    Stored {
        position: usize,
    },
    /// A fault of the options file is active for the first time.
    Fault {
        kind: &'static str,
        position: usize,
    },
    /// The drive's torque has become zero because it is no longer enabled.
    TorqueZero {
        position: usize,
    },
    /// No frame for `silence_s` in lockstep: the plant continues without frames.
    Silence,
    Stopped {
        digest: u64,
        frames: u64,
        dropped: u64,
        faults: Vec<(&'static str, u64)>,
        /// States of the drives by position.
        drives: Vec<&'static str>,
        /// Largest speed [rad/s] and angle [rad] of any axis since the first frame.
        fastest: f64,
        farthest: f64,
    },
}

/// An event with its plant cycle (None before the start) and frame number.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    pub cycle: Option<u64>,
    pub frame: u64,
    pub what: EventKind,
}

impl EventKind {
    /// Name and further fields, as JSON.
    fn fields(&self) -> (&'static str, String) {
        match self {
            EventKind::Ready { interface, drives, lockstep } => {
                let fields = format!(
                    r#","interface":{interface:?},"drives":{drives},"lockstep":{lockstep}"#
                );
                ("ready", fields)
            }
            EventKind::State { position, from, to, code } => {
                let fields =
                    format!(r#","position":{position},"from":"{from}","to":"{to}","code":{code}"#);
                ("state", fields)
            }
            EventKind::Drive { position, from, to, error } => {
                let fields = format!(
                    r#","position":{position},"from":"{from}","to":"{to}","error":{error}"#
                );
                ("drive", fields)
            }
            EventKind::Enabled => ("enabled", String::new()),
            EventKind::Watchdog { position } => ("watchdog", format!(r#","position":{position}"#)),
            EventKind::Stored { position } => ("stored", format!(r#","position":{position}"#)),
            EventKind::Fault { kind, position } => {
                ("fault", format!(r#","kind":"{kind}","position":{position}"#))
            }
            EventKind::TorqueZero { position } => {
                ("torque_zero", format!(r#","position":{position}"#))
            }
            EventKind::Silence => ("silence", String::new()),
            EventKind::Stopped { digest, frames, dropped, faults, drives, fastest, farthest } => {
                let counts: Vec<String> = faults
                    .iter()
                    .map(|(kind, count)| format!(r#"{{"kind":"{kind}","count":{count}}}"#))
                    .collect();
                let counts = counts.join(",");
                let fields = format!(
                    r#","digest":"{digest:016x}","frames":{frames},"dropped":{dropped},"faults":[{counts}],"drives":{drives:?},"fastest":{fastest},"farthest":{farthest}"#
                );
                ("stopped", fields)
            }
        }
    }
}

impl Event {
    /// One JSON object without line end. `time`: of the monotonic clock.
    pub fn json(&self, time: Duration) -> String {
        let (name, fields) = self.what.fields();
        let cycle = self.cycle.map_or("null".into(), |cycle| cycle.to_string());
        let (frame, time) = (self.frame, time.as_secs_f64());
        format!(r#"{{"event":"{name}","cycle":{cycle},"frame":{frame},"time":{time:.6}{fields}}}"#)
    }

    /// One line of text.
    pub fn text(&self) -> String {
        let (name, fields) = self.what.fields();
        let cycle = self.cycle.map_or("before start".into(), |cycle| format!("cycle {cycle}"));
        let fields = fields.replace(['"', '{', '}'], "").replace(',', "  ");
        format!("{cycle:>14}  {name}{fields}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_is_one_json_object() {
        let what = EventKind::Watchdog { position: 3 };
        let event = Event { cycle: Some(2008), frame: 2100, what };
        let wanted =
            r#"{"event":"watchdog","cycle":2008,"frame":2100,"time":1.500000,"position":3}"#;
        assert_eq!(event.json(Duration::from_millis(1500)), wanted);
        let first = Event { cycle: None, frame: 0, what: EventKind::Enabled };
        assert!(first.json(Duration::ZERO).contains(r#""cycle":null"#));
    }
}
