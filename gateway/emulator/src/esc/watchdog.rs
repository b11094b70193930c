//! Process-data watchdog: divider 0x0400, time 0x0420, status 0x0440, count 0x0442.

/// Reset values: 25 MHz / (2498 + 2) = 100 us a tick, 1000 ticks = 100 ms.
pub const DIVIDER: u16 = 2498;
pub const TICKS: u16 = 1000;

#[derive(Debug, Clone, Default)]
pub struct Watchdog {
    triggered: Option<i64>,
    expired: bool,
}

/// `[ns]`; 0: switched off.
pub fn period(divider: u16, ticks: u16) -> i64 {
    (i64::from(divider) + 2) * 40 * i64::from(ticks)
}

impl Watchdog {
    /// The outputs were written at `now` [ns].
    pub fn trigger(&mut self, now: i64) {
        self.triggered = Some(now);
        self.expired = false;
    }

    pub fn alive(&self) -> bool {
        self.triggered.is_some() && !self.expired
    }

    /// True once: when the period has passed since the last trigger.
    pub fn expires(&mut self, now: i64, period: i64) -> bool {
        let Some(triggered) = self.triggered else {
            return false;
        };
        if self.expired || period == 0 || now.wrapping_sub(triggered) < period {
            return false;
        }
        self.expired = true;
        true
    }

    pub fn stop(&mut self) {
        *self = Watchdog::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_period_is_100_ms() {
        assert_eq!(period(DIVIDER, TICKS), 100_000_000);
    }

    #[test]
    fn it_expires_once_at_its_period_and_comes_back_with_a_trigger() {
        let mut dog = Watchdog::default();
        assert!(!dog.expires(1_000_000, 100) && !dog.alive());
        dog.trigger(0);
        assert!(!dog.expires(999_999, 1_000_000) && dog.alive());
        assert!(dog.expires(1_000_000, 1_000_000) && !dog.alive());
        assert!(!dog.expires(2_000_000, 1_000_000));
        dog.trigger(3_000_000);
        assert!(dog.alive());
        assert!(!dog.expires(9_000_000, 0), "0 switches it off");
    }
}
