//! Rows from one thread to another: one writer, one reader, no lock, no allocation.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::Arc;

struct Shared {
    cells: Vec<AtomicU64>,
    width: usize,
    rows: usize,
    written: AtomicUsize,
    taken: AtomicUsize,
    overflowed: AtomicU64,
}

/// The end of the control loop.
pub struct Sink(Arc<Shared>);

/// The end of the writer.
pub struct Source(Arc<Shared>);

/// A ring of `rows` rows of `width` numbers.
pub fn ring(rows: usize, width: usize) -> (Sink, Source) {
    let shared = Arc::new(Shared {
        cells: (0..rows * width).map(|_| AtomicU64::new(0)).collect(),
        width,
        rows,
        written: AtomicUsize::new(0),
        taken: AtomicUsize::new(0),
        overflowed: AtomicU64::new(0),
    });
    (Sink(shared.clone()), Source(shared))
}

impl Sink {
    /// Add a row; a full ring drops and counts it.
    pub fn push(&mut self, row: &[f64]) {
        let s = &*self.0;
        debug_assert_eq!(row.len(), s.width);
        let written = s.written.load(Ordering::Relaxed);
        if written - s.taken.load(Ordering::Acquire) == s.rows {
            s.overflowed.fetch_add(1, Ordering::Relaxed);
            return;
        }
        let begin = written % s.rows * s.width;
        for (cell, value) in s.cells[begin..begin + s.width].iter().zip(row) {
            cell.store(value.to_bits(), Ordering::Relaxed);
        }
        s.written.store(written + 1, Ordering::Release);
    }

    /// Another row fits in, or the writer has ended.
    pub fn has_room(&self) -> bool {
        let s = &*self.0;
        if Arc::strong_count(&self.0) == 1 {
            return true;
        }
        s.written.load(Ordering::Relaxed) - s.taken.load(Ordering::Acquire) < s.rows
    }

    pub fn overflowed(&self) -> u64 {
        self.0.overflowed.load(Ordering::Relaxed)
    }
}

impl Source {
    pub fn width(&self) -> usize {
        self.0.width
    }

    /// Copy the oldest row out; false when there is none.
    pub fn take(&mut self, row: &mut [f64]) -> bool {
        let s = &*self.0;
        let taken = s.taken.load(Ordering::Relaxed);
        if taken == s.written.load(Ordering::Acquire) {
            return false;
        }
        let begin = taken % s.rows * s.width;
        for (cell, value) in s.cells[begin..begin + s.width].iter().zip(row) {
            *value = f64::from_bits(cell.load(Ordering::Relaxed));
        }
        s.taken.store(taken + 1, Ordering::Release);
        true
    }
}
