//! The newest row of the control loop for other threads: one writer that never waits, any number of
//! readers that try again when they were disturbed (a sequence lock).

use std::sync::atomic::{fence, AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Tries of a reader, and its pause between two of them.
const TRIES: usize = 200;
const PAUSE: Duration = Duration::from_micros(50);

/// Values of the newest cycle, and counts since the start.
pub struct Board {
    /// Odd while the row is written.
    sequence: AtomicU64,
    cells: Vec<AtomicU64>,
    /// Cycles of every phase.
    pub beats: AtomicU64,
    /// The control loop runs: beats must follow each other.
    pub beating: AtomicBool,
    pub lost: AtomicU64,
    pub short: AtomicU64,
    pub skipped: AtomicU64,
}

impl Board {
    /// For rows of this many numbers.
    pub fn new(width: usize) -> Board {
        Board {
            sequence: AtomicU64::new(0),
            cells: (0..width).map(|_| AtomicU64::new(0)).collect(),
            beats: AtomicU64::new(0),
            beating: AtomicBool::new(false),
            lost: AtomicU64::new(0),
            short: AtomicU64::new(0),
            skipped: AtomicU64::new(0),
        }
    }

    /// Shows a row; for the control loop alone.
    pub fn write(&self, row: &[f64]) {
        let sequence = self.sequence.load(Ordering::Relaxed);
        self.sequence.store(sequence + 1, Ordering::Relaxed);
        fence(Ordering::Release);
        for (cell, value) in self.cells.iter().zip(row) {
            cell.store(value.to_bits(), Ordering::Relaxed);
        }
        self.sequence.store(sequence + 2, Ordering::Release);
    }

    /// A whole row; None before the first, or where none could be read undisturbed.
    pub fn read(&self) -> Option<Vec<f64>> {
        for _ in 0..TRIES {
            let before = self.sequence.load(Ordering::Acquire);
            if before == 0 {
                return None;
            }
            let cells = self.cells.iter();
            let row = cells.map(|cell| f64::from_bits(cell.load(Ordering::Relaxed))).collect();
            fence(Ordering::Acquire);
            if before.is_multiple_of(2) && self.sequence.load(Ordering::Relaxed) == before {
                return Some(row);
            }
            std::thread::sleep(PAUSE);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_sees_whole_rows_while_they_are_written() {
        const WIDTH: usize = 80;
        let board = Board::new(WIDTH);
        assert_eq!(board.read(), None);
        let over = AtomicBool::new(false);
        let seen = std::thread::scope(|scope| {
            let reader = scope.spawn(|| {
                let mut seen = Vec::new();
                while !over.load(Ordering::Relaxed) {
                    seen.extend(board.read());
                }
                seen
            });
            for n in 0..200_000 {
                board.write(&[f64::from(n); WIDTH]);
            }
            over.store(true, Ordering::Relaxed);
            reader.join().unwrap()
        });
        assert!(seen.iter().all(|row| row.iter().all(|value| *value == row[0])), "a torn row");
        assert!(seen.windows(2).all(|rows| rows[0][0] <= rows[1][0]), "an older row after a newer");
        assert_eq!(board.read(), Some(vec![199_999.0; WIDTH]));
    }
}
