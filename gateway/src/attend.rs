//! Watches the control loop from another thread: a status line, the end of a loop that hangs, and a landing where
//! an FMU hangs beside it.

use flexhex_system::hanging;
use serde_json::json;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::config::AXES;
use crate::live::{self, Board};
use crate::realtime::stop;
use crate::record::Columns;
use crate::report::Reporter;
use crate::watch::{HungBeside, HANG_LOOKS};

/// Time between two looks at the beats, and looks between two lines of status.
pub const LOOK: Duration = Duration::from_millis(100);
const LOOKS_OF_STATUS: u32 = 5;

/// Values of the column `phase`.
const RUNNING: f64 = 1.0;
const LIFTING: f64 = 3.0;

/// What is watched and how.
pub struct Watched<'a> {
    pub reporter: Reporter,
    pub board: &'a Board,
    pub columns: &'a Columns,
    /// Looks without a beat after which the loop hangs. Looks are counted, not time: where the whole
    /// process stood still, nothing hangs.
    pub patience: u32,
}

/// Runs `work` in this thread while another one shows the status; `on_hang` gets the FMU, if it is one, and ends the
/// process. Returns the FMU that hung beside the loop, too: then the machine was landed.
pub fn attend<T>(
    watched: Watched,
    on_hang: impl FnOnce(Option<String>) + Send,
    work: impl FnOnce() -> T,
) -> (T, Option<HungBeside>) {
    let over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let attendant = scope.spawn(|| {
            let (mut stillness, mut beside) = (Stillness::default(), None);
            let (mut looks, mut phase) = (0, None);
            while !over.load(Ordering::Relaxed) {
                std::thread::park_timeout(LOOK);
                looks += 1;
                watched.tell_phase(&mut phase);
                if looks % LOOKS_OF_STATUS == 0 {
                    watched.tell();
                }
                let board = watched.board;
                let beats = board.beats.load(Ordering::Relaxed);
                let beating = board.beating.load(Ordering::Relaxed);
                let still = stillness.note(beating.then_some(beats));
                let hung = hanging(HANG_LOOKS);
                let stands = !beating && hung.is_some() && beside.is_none();
                if still >= watched.patience || stands {
                    watched.reporter.live_over();
                    on_hang(hung);
                    return None;
                }
                // the loop goes on without it
                if let (Some(component), None, 0) = (hung, &beside, still) {
                    watched.reporter.live_over();
                    beside = Some(HungBeside::told(component, watched.reporter));
                    stop::request();
                }
            }
            watched.reporter.live_over();
            beside
        });
        let out = work();
        over.store(true, Ordering::Relaxed);
        attendant.thread().unpark();
        (out, attendant.join().unwrap_or(None))
    })
}

impl Watched<'_> {
    fn place(&self, name: &str) -> Option<usize> {
        self.columns.names.iter().position(|known| known == name)
    }

    /// A line for each phase that begins: in a journal, too, there is something to see before the end.
    fn tell_phase(&self, last: &mut Option<f64>) {
        let Some(row) = self.board.read() else { return };
        let phase = self.place("phase").map(|k| row[k]);
        let word = phase.filter(|_| phase != *last).and_then(live::phase);
        *last = phase;
        if let Some(word) = word {
            self.reporter.live_over();
            self.reporter.line("phase", word);
            self.reporter.event("phase", json!({ "phase": word }));
        }
    }

    /// The status line, and the same as an event, in lift-off and run.
    fn tell(&self) {
        let Some(row) = self.board.read() else { return };
        let value = |name: &str| self.place(name).map_or(0.0, |k| row[k]);
        let (cycle, time, phase) = (value("cycle"), value("time"), value("phase"));
        let event = match phase {
            RUNNING if cycle > 0.0 => "status",
            LIFTING => "moving",
            _ => return,
        };
        let first = self.place("e[1]").unwrap_or(0);
        let most = row[first..first + AXES].iter().fold(0.0, |most: f64, e| most.max(e.abs()));
        let (error, lost) = (most * 1e6, self.board.lost.load(Ordering::Relaxed));
        let text = format!("{time:8.2} s   error {error:9.2} urad   lost {lost}");
        self.reporter.live(live::phase(phase).unwrap_or_default(), &text);
        self.reporter.event(
            event,
            json!({"cycle": cycle as i64, "time_s": time, "error_urad": error, "lost": lost}),
        );
    }
}

/// Looks in a row at which a counter that should count stood still.
#[derive(Default)]
pub struct Stillness {
    last: Option<u64>,
    looks: u32,
}

impl Stillness {
    /// None: it need not count.
    pub fn note(&mut self, count: Option<u64>) -> u32 {
        let still = count.is_some() && count == self.last;
        self.looks = if still { self.looks + 1 } else { 0 };
        self.last = count;
        self.looks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_counter_that_should_count_and_does_not_is_still() {
        let mut stillness = Stillness::default();
        let seen: Vec<_> = [None, None, Some(1), Some(1), Some(1), Some(2), Some(2), None, Some(2)]
            .into_iter()
            .map(|count| stillness.note(count))
            .collect();
        assert_eq!(seen, [0, 0, 0, 1, 2, 0, 1, 0, 0]);
    }
}
