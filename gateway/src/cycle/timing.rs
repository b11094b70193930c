//! Start times of the cycles and distributions of durations.

use std::time::Duration;

use crate::realtime::{now_ns, sleep_until};

const BIN_NS: u64 = 100;
const BINS: usize = 200_000; // up to 20 ms

/// Histogram of durations, allocated before the run.
pub struct Histogram {
    bins: Vec<u32>,
    pub count: u64,
    pub most_ns: u64,
}

impl Histogram {
    pub fn new() -> Self {
        Histogram { bins: vec![0; BINS], count: 0, most_ns: 0 }
    }

    pub fn add(&mut self, ns: u64) {
        self.bins[((ns / BIN_NS) as usize).min(BINS - 1)] += 1;
        self.count += 1;
        self.most_ns = self.most_ns.max(ns);
    }

    /// Quantile of the durations [us].
    pub fn quantile_us(&self, share: f64) -> f64 {
        let rank = (share * self.count as f64).ceil() as u64;
        let mut seen = 0;
        for (k, n) in self.bins.iter().enumerate() {
            seen += u64::from(*n);
            if seen >= rank.max(1) {
                let ns = (k as u64 + 1) * BIN_NS;
                return ns.min(self.most_ns) as f64 / 1e3;
            }
        }
        self.most_ns as f64 / 1e3
    }

    pub fn most_us(&self) -> f64 {
        self.most_ns as f64 / 1e3
    }
}

/// Start of every cycle: by the absolute clock, or at once in lockstep.
pub struct Clock {
    cycle_ns: u64,
    spin: Duration,
    lockstep: bool,
    next_ns: u64,
    /// The phase in the cycle of the drives is known.
    steered: bool,
    /// Cycles skipped because the one before took too long.
    pub skipped: u64,
}

impl Clock {
    pub fn new(cycle: Duration, spin: Duration, lockstep: bool) -> Self {
        Clock {
            cycle_ns: cycle.as_nanos() as u64,
            spin,
            lockstep,
            next_ns: 0,
            steered: false,
            skipped: 0,
        }
    }

    /// Wait for the next cycle; returns its start and its delay [ns].
    pub fn wait(&mut self) -> (u64, u64) {
        if self.lockstep {
            return (now_ns(), 0);
        }
        let before = now_ns();
        self.next_ns = if self.next_ns == 0 { before } else { self.next_ns + self.cycle_ns };
        sleep_until(self.next_ns, self.spin);
        let now = now_ns();
        let late = now.saturating_sub(self.next_ns);
        // missed cycles are skipped: a burst of frames would delay the next ones too
        let missed = self.missed(late);
        self.skipped += missed;
        self.next_ns += missed * self.cycle_ns;
        (now, late)
    }

    /// So many cycles went by before this one; its delay [ns].
    pub fn skip(&mut self, cycles: u64) -> u64 {
        self.skipped += cycles;
        cycles * self.cycle_ns
    }

    /// Cycles missed at this delay. A frame in the last quarter would arrive after the SYNC0 of the next
    /// cycle and read its angles, so it belongs to that cycle.
    fn missed(&self, late: u64) -> u64 {
        let behind = if self.steered { self.cycle_ns / 4 } else { 0 };
        (late + behind) / self.cycle_ns
    }

    /// Shift the frame to a quarter of the drives' cycle, as it may be late but never early: at once at
    /// the first phase, before power, and by at most a thousandth of a cycle from then on.
    pub fn steer(&mut self, phase_ns: u64) {
        let cycle = self.cycle_ns as i64;
        let off = (phase_ns as i64 + cycle / 4).rem_euclid(cycle) - cycle / 2;
        let step = match self.steered {
            true => (-off / 64).clamp(-cycle / 1000, cycle / 1000),
            false => -off,
        };
        self.steered = true;
        self.next_ns = self.next_ns.saturating_add_signed(step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_within_one_bin() {
        let mut h = Histogram::new();
        for us in 1..=100 {
            h.add(us * 1000);
        }
        for (share, wanted) in [(0.5, 50.0), (0.99, 99.0), (1.0, 100.0)] {
            let got = h.quantile_us(share);
            assert!((got - wanted).abs() <= 0.1001, "{share}: {got}");
        }
        assert_eq!(h.most_us(), 100.0);
    }

    #[test]
    fn the_phase_is_pulled_to_a_quarter_from_either_side() {
        let mut clock = Clock::new(Duration::from_micros(250), Duration::ZERO, false);
        clock.steered = true;
        for (phase, wanted) in
            [(62_500, 0), (137_500, -250), (63_780, -20), (0, 250), (249_000, 250)]
        {
            clock.next_ns = 1_000_000;
            clock.steer(phase);
            assert_eq!(clock.next_ns as i64 - 1_000_000, wanted, "{phase}");
        }
    }

    #[test]
    fn a_frame_behind_the_next_sync0_is_of_the_next_cycle() {
        let mut clock = Clock::new(Duration::from_micros(250), Duration::ZERO, false);
        let late = [0, 187_499, 187_500, 249_999, 250_000, 437_500];
        assert_eq!(late.map(|late| clock.missed(late)), [0, 0, 0, 0, 1, 1]);
        clock.steered = true;
        assert_eq!(late.map(|late| clock.missed(late)), [0, 0, 1, 1, 1, 2]);
    }

    #[test]
    fn the_first_phase_is_put_there_at_once() {
        for (phase, wanted) in [(62_500, 0), (186_500, -124_000), (0, 62_500), (188_500, 124_000)] {
            let mut clock = Clock::new(Duration::from_micros(250), Duration::ZERO, false);
            clock.next_ns = 1_000_000;
            clock.steer(phase);
            assert_eq!(clock.next_ns as i64 - 1_000_000, wanted, "{phase}");
        }
    }
}
