//! Angles of the last cycles, and the speeds that follow from them.

use crate::config::AXES;

/// Longest window of the mean speed [cycles].
const LONGEST: usize = 64;

#[derive(Clone, Debug)]
pub struct History {
    past: [[f64; AXES]; LONGEST],
    seen: usize,
    /// Window [cycles] and its cycle time [s].
    window: usize,
    base_step: f64,
}

impl History {
    pub fn new(window: u32, base_step: f64) -> Self {
        let window = window as usize;
        History { past: [[0.0; AXES]; LONGEST], seen: 0, window, base_step }
    }

    /// Angles of a cycle [rad]; NaN where they were not measured.
    pub fn note(&mut self, theta: [f64; AXES]) {
        self.past[self.seen % LONGEST] = theta;
        self.seen += 1;
    }

    /// Cycles in which nothing was measured.
    pub fn skip(&mut self, cycles: u64) {
        for _ in 0..cycles.min(LONGEST as u64) {
            self.note([f64::NAN; AXES]);
        }
    }

    fn then(&self, ago: usize) -> &[f64; AXES] {
        &self.past[(self.seen - ago) % LONGEST]
    }

    /// Mean speed of an axis that is at `theta` now [rad/s], over more cycles where the older angle was
    /// not measured; None before there are enough cycles.
    pub fn mean_speed(&self, k: usize, theta: f64) -> Option<f64> {
        let agos = self.window..=LONGEST.min(self.seen);
        let ago = agos.into_iter().find(|ago| !self.then(*ago)[k].is_nan())?;
        Some((theta - self.then(ago)[k]) / (ago as f64 * self.base_step))
    }

    /// Enough angles were seen for a mean speed.
    pub fn knows_rates(&self) -> bool {
        self.seen > self.window.min(LONGEST - 1)
    }

    /// Mean speed of each axis [rad/s] up to its newest angle, over more cycles where the older one was not measured;
    /// 0 where it is not known.
    pub fn rates(&self) -> [f64; AXES] {
        if !self.knows_rates() {
            return [0.0; AXES];
        }
        let n = self.window.min(LONGEST - 1);
        let most = LONGEST.min(self.seen);
        std::array::from_fn(|k| {
            let known = |ago: &usize| !self.then(*ago)[k].is_nan();
            let newest = (1..=most).find(known);
            let older = newest.and_then(|newest| (newest + n..=most).find(known));
            let (Some(newest), Some(older)) = (newest, older) else { return 0.0 };
            let time = (older - newest) as f64 * self.base_step;
            (self.then(newest)[k] - self.then(older)[k]) / time
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_known_across_cycles_without_a_measurement() {
        let mut history = History::new(8, 0.5);
        for k in 0..12 {
            history.note([f64::from(k); AXES]);
        }
        assert_eq!(history.rates(), [2.0; AXES]);
        // 40 cycles go by, as when the computer stands still
        history.skip(40);
        history.note([52.0; AXES]);
        assert_eq!(history.rates(), [2.0; AXES]);
        history.skip(LONGEST as u64);
        assert_eq!(history.rates(), [0.0; AXES], "too long ago");
    }
}
