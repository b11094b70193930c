//! The thread that takes rows out of the ring and writes files.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::sync::mpsc::{channel, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

use super::error::RecordError;
use super::file::{create, end, line, unused, Made, Plan};
use super::ring::Source;
use crate::file_error::FileError;

const PHASE: &str = "phase";
const RUNNING: f64 = 1.0;
const PERIOD: Duration = Duration::from_millis(10);

/// The text of the trip, if any, and who is told when the files are closed.
struct End {
    trip: Option<String>,
    done: Option<Sender<()>>,
}

/// Handle of the writer thread.
pub struct Writer {
    end: Sender<End>,
    thread: JoinHandle<Result<Written, RecordError>>,
}

/// Ends the writer from another thread, where the one that owns it does not.
pub struct Closer(Sender<End>);

impl Closer {
    /// As `Writer::finish`, but it only waits until the files are closed, at most for `limit`.
    pub fn close(&self, trip: &str, limit: Duration) {
        let (done, closed) = channel();
        // the thread has ended only after a failed write
        let _ = self.0.send(End { trip: Some(trip.to_owned()), done: Some(done) });
        let _ = closed.recv_timeout(limit);
    }
}

/// The files that were written.
#[derive(Clone, Debug, Default)]
pub struct Written {
    pub rows: u64,
    pub recording: Option<PathBuf>,
    pub before_trip: Option<PathBuf>,
}

impl Writer {
    /// Open the files and start the thread; Err if a file cannot be created, that of a trip included.
    pub fn start(plan: Plan, source: Source) -> Result<Writer, RecordError> {
        let (trip, made) = (unused(&plan.before_trip), Made::by(&plan));
        let tried = create(&trip, &plan, None)
            .and_then(|_| std::fs::remove_file(&trip).map_err(FileError::of(&trip)));
        tried.map_err(RecordError::NotBegun)?;
        let file = match &plan.recording {
            Some(path) => Some(create(path, &plan, None).map_err(RecordError::NotBegun)?),
            None => None,
        };
        let (end, ended) = channel::<End>();
        let work = move || {
            let mut sheet = Sheet::new(plan, source, (file, made));
            loop {
                match ended.recv_timeout(PERIOD) {
                    Err(RecvTimeoutError::Timeout) => sheet.drain(),
                    Ok(end) => {
                        sheet.drain();
                        let written = sheet.close(end.trip.as_deref());
                        if let Some(done) = end.done {
                            let _ = done.send(());
                        }
                        return written;
                    }
                    Err(RecvTimeoutError::Disconnected) => return sheet.close(None),
                }
            }
        };
        let thread = std::thread::Builder::new().name("recorder".to_owned());
        let thread = thread.spawn(work).map_err(RecordError::NoThread)?;
        Ok(Writer { end, thread })
    }

    pub fn closer(&self) -> Closer {
        Closer(self.end.clone())
    }

    /// Write the remaining rows; after a trip also the trip file.
    pub fn finish(self, trip: Option<String>) -> Result<Written, RecordError> {
        // the thread has ended only after a failed write, which `join` returns
        let _ = self.end.send(End { trip, done: None });
        self.thread.join().unwrap_or(Err(RecordError::Died))
    }
}

struct Sheet {
    plan: Plan,
    source: Source,
    file: Option<BufWriter<File>>,
    /// Why the recording ends early; the newest rows are kept on for a trip.
    failed: Option<FileError>,
    /// The newest rows, as a ring.
    kept: Vec<f64>,
    row: Vec<f64>,
    rows: u64,
    /// Rows before the reaction began.
    before: u64,
    /// Column of the phase.
    phase: usize,
    _made: Made,
}

impl Sheet {
    fn new(plan: Plan, source: Source, (file, made): (Option<BufWriter<File>>, Made)) -> Sheet {
        let width = source.width();
        Sheet {
            kept: vec![0.0; (plan.keep + plan.reaction) * width],
            row: vec![0.0; width],
            phase: plan.columns.names.iter().position(|n| n == PHASE).unwrap_or(0),
            plan,
            source,
            file,
            failed: None,
            rows: 0,
            before: 0,
            _made: made,
        }
    }

    fn drain(&mut self) {
        let width = self.row.len();
        while self.source.take(&mut self.row) {
            let at = self.place(self.rows);
            self.kept[at..at + width].copy_from_slice(&self.row);
            self.rows += 1;
            // the reaction belongs into the trip file only: no model describes it
            if self.row[self.phase] > RUNNING {
                continue;
            }
            self.before = self.rows;
            if let (Some(file), Some(path)) = (&mut self.file, &self.plan.recording) {
                if let Err(why) = line(file, &self.row) {
                    (self.failed, self.file) = (Some(FileError::of(path)(why)), None);
                }
            }
        }
    }

    /// Offset of row n in `kept`.
    fn place(&self, n: u64) -> usize {
        n as usize % (self.plan.keep + self.plan.reaction) * self.row.len()
    }

    /// Ends the files. After a failed recording a trip is kept all the same, if it can be.
    fn close(mut self, trip: Option<&str>) -> Result<Written, RecordError> {
        if let (Some(file), Some(path)) = (self.file.take(), &self.plan.recording) {
            self.failed = end(file, trip).map_err(FileError::of(path)).err();
            // nothing stands in it: the next try may have the same name
            if self.before == 0 && path.is_file() {
                let _ = std::fs::remove_file(path);
                self.plan.recording = None;
            }
        }
        let before_trip = trip.filter(|_| self.plan.keep > 0).map(|why| self.keep(why));
        match self.failed {
            Some(why) => {
                let kept = before_trip.and_then(Result::ok);
                Err(RecordError::NotWritten { why, kept })
            }
            None => {
                let before_trip = before_trip.transpose()?;
                Ok(Written { rows: self.rows, recording: self.plan.recording, before_trip })
            }
        }
    }

    fn keep(&self, trip: &str) -> Result<PathBuf, FileError> {
        let path = unused(&self.plan.before_trip);
        let mut file = create(&path, &self.plan, Some(trip))?;
        let first = self.before.saturating_sub(self.plan.keep as u64);
        let oldest = self.rows.saturating_sub((self.plan.keep + self.plan.reaction) as u64);
        for n in first.max(oldest)..self.rows {
            let at = self.place(n);
            line(&mut file, &self.kept[at..at + self.row.len()]).map_err(FileError::of(&path))?;
        }
        file.flush().map_err(FileError::of(&path))?;
        Ok(path)
    }
}
