//! Distributed clock of one SubDevice: drifts, and is pulled to the reference by each time it gets.
//! All times in ns; `now` is the true time, which no device on the bus knows.

/// Largest change of the rate that the control loop makes.
const RATE_LIMIT: f64 = 2e-3;
/// A gap longer than this says nothing about the rate.
const LONGEST_GAP_NS: i64 = 100_000_000;

#[derive(Debug, Clone)]
pub struct Clock {
    /// Local time and the true time when it was last corrected.
    local: i64,
    world: i64,
    /// Relative error of the oscillator.
    drift: f64,
    correction: f64,
    controlled: Option<i64>,
    /// It notes how far it is off and never follows.
    pub free: bool,
    pub offset: i64,
    pub delay: u32,
    pub difference: i32,
}

impl Clock {
    /// power_up: local time at true time 0.
    pub fn new(power_up: i64, drift: f64) -> Clock {
        Clock {
            local: power_up,
            world: 0,
            drift,
            correction: 0.0,
            controlled: None,
            free: false,
            offset: 0,
            delay: 0,
            difference: 0,
        }
    }

    pub fn local(&self, now: i64) -> i64 {
        let gone = now.wrapping_sub(self.world);
        let extra = gone as f64 * (self.drift + self.correction);
        self.local.wrapping_add(gone).wrapping_add(extra as i64)
    }

    /// The local copy of the system time.
    pub fn system(&self, now: i64) -> i64 {
        self.local(now).wrapping_add(self.offset)
    }

    /// A system time arrives from the reference: the difference is noted, phase and rate follow.
    pub fn control(&mut self, now: i64, received: u32) {
        let mine = self.system(now).wrapping_sub(i64::from(self.delay));
        let difference = (mine as u32).wrapping_sub(received) as i32;
        self.difference = difference;
        if self.free {
            return;
        }
        let gone = self.controlled.map_or(0, |last| now.wrapping_sub(last));
        self.controlled = Some(now);
        self.local = self.local(now);
        self.world = now;
        let most = 10 + gone.clamp(0, LONGEST_GAP_NS) / 100;
        let pull = i64::from(difference / 2).clamp(-most, most);
        self.local = self.local.wrapping_sub(pull);
        if (1..LONGEST_GAP_NS).contains(&gone) {
            let rate = 0.05 * f64::from(difference) / gone as f64;
            self.correction = (self.correction - rate).clamp(-RATE_LIMIT, RATE_LIMIT);
        }
    }

    /// A write to the speed counter starts the control loop anew, and sets the difference to 0.
    pub fn restart(&mut self, now: i64) {
        self.local = self.local(now);
        self.world = now;
        self.correction = 0.0;
        self.controlled = None;
        self.difference = 0;
    }

    /// Register 0x092C: sign and magnitude.
    pub fn difference_register(&self) -> u32 {
        let sign = if self.difference < 0 { 1 << 31 } else { 0 };
        sign | self.difference.unsigned_abs() & 0x7FFF_FFFF
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_drift_apart_until_they_are_controlled() {
        let reference = Clock::new(1_000_000, 20e-6);
        let mut other = Clock::new(7_000_000, -30e-6);
        other.offset = reference.local(0) - other.local(0);
        let second = 1_000_000_000;
        // 50 ppm of a second are 50 us; one count of rounding each
        let apart = reference.system(second) - other.system(second);
        assert!((apart - 50_000).abs() <= 2, "{apart}");
        other.offset += apart;
        for k in 1..=4000 {
            let now = second + k * 250_000;
            other.control(now, reference.system(now) as u32);
        }
        // what is left is the step of a loop that has converged: a few ns
        assert!(other.difference.abs() < 20, "{}", other.difference);
        let later = second + 4000 * 250_000 + 10_000_000;
        assert!((reference.system(later) - other.system(later)).abs() < 100);
    }

    #[test]
    fn a_free_clock_says_how_far_it_is_off_and_goes_on_drifting() {
        let reference = Clock::new(1_000_000, 0.0);
        let mut free = Clock { free: true, ..Clock::new(1_000_000, -20e-6) };
        for k in 0..=4000 {
            let now = k * 250_000;
            free.control(now, reference.system(now) as u32);
        }
        // 20 ppm of a second, behind; one count of rounding
        assert!((free.difference + 20_000).abs() <= 1, "{}", free.difference);
    }

    #[test]
    fn the_propagation_delay_counts() {
        let mut clock = Clock::new(5_000, 0.0);
        clock.delay = 700;
        clock.control(0, 5_000 - 700);
        assert_eq!(clock.difference, 0);
        clock.control(0, 5_000);
        assert_eq!(clock.difference, -700);
        assert_eq!(clock.difference_register(), 1 << 31 | 700);
    }

    #[test]
    fn extreme_values_do_not_overflow() {
        let mut clock = Clock::new(i64::MAX, 1.0);
        clock.offset = i64::MAX;
        clock.control(i64::MAX, 0);
        clock.restart(i64::MAX);
        assert_ne!(clock.system(i64::MAX), 0);
    }
}
