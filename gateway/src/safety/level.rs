//! Failures in a row, and too many of them.

/// A failure counts three and a good cycle takes one back, as the sync error counter of ETG.1020 does: one
/// failure in four and more adds up.
const PER_FAILURE: u32 = 3;
/// The level that trips, in failures in a row that would.
const ROWS: u32 = 10;

/// Counts failures of one kind.
#[derive(Clone, Copy, Debug, Default)]
pub struct Failures {
    row: u32,
    level: u32,
}

impl Failures {
    /// A cycle; the number of failures, if it is too large: `limit` in a row, or too many.
    pub fn note(&mut self, failed: bool, limit: u32) -> Option<u32> {
        if failed {
            self.row += 1;
            self.level += PER_FAILURE;
        } else {
            self.row = 0;
            self.level = self.level.saturating_sub(1);
        }
        let often = self.level >= limit * PER_FAILURE * ROWS;
        let row = (self.row >= limit).then_some(self.row);
        row.or(often.then_some(self.level / PER_FAILURE))
    }
}
