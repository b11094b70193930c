//! One row of the recording: the values of a cycle in the order of `Columns`.

use std::sync::atomic::Ordering;

use super::{ControlLoop, Phase};
use crate::bus::Reply;
use crate::config::AXES;
use crate::record::time_of;
use crate::wire::Link;

/// Position of `compute` among the columns behind the axes.
const COMPUTE: usize = 1 + 9 * AXES + 7;

impl<L: Link> ControlLoop<'_, L> {
    /// Fill the row of cycle n with the signals published at n.
    pub(super) fn fill(&mut self, n: i64, reply: &Reply, late_ns: u64, round_trip_ns: u64) {
        if reply.answered {
            self.out.note_remarks(&reply.statusword);
        }
        let bus = self.controller.bus();
        let (r, e) = match &self.phase {
            Phase::Lifting(mover) | Phase::Landing(mover) => (mover.r, mover.e),
            _ => (self.pick(self.signals.r), self.pick(self.signals.e)),
        };
        let mut row = Cursor(&mut self.row, 0);
        row.put(time_of(n, self.missed, self.safety.base_step()));
        row.all(&measured(reply.answered, &reply.theta));
        row.all(&measured(reply.answered, &reply.tau));
        row.all(&r);
        row.all(&self.sent);
        row.all(&self.signals.tau_ff.map(|slot| bus[slot]));
        row.all(&e);
        row.all(&reply.statusword.map(f64::from));
        row.all(&reply.error_code.map(f64::from));
        row.all(&reply.al_state.map(f64::from));
        row.put(n as f64);
        row.put(match self.phase {
            Phase::Arming(_) => 0.0,
            Phase::Running => 1.0,
            Phase::Disabling(_) => 2.0,
            Phase::Lifting(_) => 3.0,
            Phase::Landing(_) => 4.0,
        });
        row.put(f64::from(u8::from(reply.answered)));
        row.put(f64::from(reply.working_counter));
        row.put(self.controller.late() as f64);
        row.put(late_ns as f64 / 1e3);
        row.put(round_trip_ns as f64 / 1e3);
        row.put(0.0);
        row.put(reply.phase_ns.map_or(0.0, |ns| ns as f64 / 1e3));
        for slot in &self.signals.more {
            row.put(bus[*slot]);
        }
    }

    /// Pass the row to the writer, and show it to those who look. In lockstep it waits for room, so no row is dropped there.
    pub(super) fn push(&mut self, compute_ns: u64) {
        self.row[COMPUTE] = compute_ns as f64 / 1e3;
        while self.options.lockstep && !self.sink.has_room() {
            std::thread::yield_now();
        }
        self.sink.push(&self.row);
        let board = self.board;
        board.write(&self.row);
        for (count, value) in [
            (&board.lost, self.out.lost),
            (&board.short, self.out.short),
            (&board.skipped, self.clock.skipped),
        ] {
            count.store(value, Ordering::Relaxed);
        }
    }
}

/// Measured values; NaN without a reply, as the stored values are of an earlier cycle.
fn measured(answered: bool, values: &[f64; AXES]) -> [f64; AXES] {
    if answered {
        *values
    } else {
        [f64::NAN; AXES]
    }
}

struct Cursor<'a>(&'a mut [f64], usize);

impl Cursor<'_> {
    fn put(&mut self, value: f64) {
        self.0[self.1] = value;
        self.1 += 1;
    }

    fn all(&mut self, values: &[f64; AXES]) {
        self.0[self.1..self.1 + AXES].copy_from_slice(values);
        self.1 += AXES;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cycle_without_a_reply_records_no_measurement() {
        let theta = [0.1; AXES];
        assert_eq!(measured(true, &theta), theta);
        assert!(measured(false, &theta).iter().all(|value| value.is_nan()));
    }
}
