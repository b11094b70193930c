//! The mode of operation that an enabled drive shows is the configured one.

use super::{Measured, Safety};
use crate::config::AXES;
use crate::rules::{Reason, Trip};

impl Safety {
    /// Judged where the process data has the display (0x6061). An absent drive shows AL status 0.
    pub(super) fn modes(&self, m: &Measured) -> Option<Trip> {
        let wanted = self.rules.config.profile.mode;
        (0..AXES).filter(|k| self.rules.bounds.powered && m.al_state[*k] != 0).find_map(|k| {
            let shown = m.mode[k].filter(|mode| *mode != wanted)?;
            Some(Trip::of(Reason::Mode, Some(k), shown.into(), wanted.into(), m.cycle))
        })
    }
}
