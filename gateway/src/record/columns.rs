//! Columns of a recording: names and units as in measured logs.

use crate::config::AXES;

/// Names and units, in the order of a row.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    pub names: Vec<String>,
    pub units: Vec<String>,
}

const BY_AXIS: [(&str, &str); 9] = [
    ("theta", "rad"),
    ("tau_meas", "N m"),
    ("r", "rad"),
    ("tau", "N m"),
    ("tau_ff", "N m"),
    ("e", "rad"),
    ("statusword", "1"),
    ("error_code", "1"),
    ("al_state", "1"),
];

const OF_CYCLE: [(&str, &str); 9] = [
    ("cycle", "1"),
    ("phase", "1"),
    ("answered", "1"),
    ("working_counter", "1"),
    ("late_threads", "1"),
    ("wake_up", "us"),
    ("round_trip", "us"),
    ("compute", "us"),
    ("dc_phase", "us"),
];

/// Time [s] of cycle n after `missed` cycles that the clock skipped since cycle 0: a recording has
/// a gap there.
pub fn time_of(n: i64, missed: u64, base_step: f64) -> f64 {
    (n + missed as i64) as f64 * base_step
}

impl Columns {
    /// The columns of every recording, then further signals of the system with their units.
    pub fn with(more: &[(String, String)]) -> Columns {
        let mut columns = Columns::default();
        columns.add("time", "s");
        for (name, unit) in BY_AXIS {
            for axis in 1..=AXES {
                columns.add(&format!("{name}[{axis}]"), unit);
            }
        }
        for (name, unit) in OF_CYCLE {
            columns.add(name, unit);
        }
        for (name, unit) in more {
            columns.add(name, unit);
        }
        columns
    }

    pub fn len(&self) -> usize {
        self.names.len()
    }

    fn add(&mut self, name: &str, unit: &str) {
        self.names.push(name.to_owned());
        self.units.push(unit.to_owned());
    }
}
