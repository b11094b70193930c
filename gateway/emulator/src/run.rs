//! The loop of the emulator: frames in, replies out, in lockstep or by the clock.
use crate::assembly::assemble;
use crate::error::Error;
use crate::event::EventKind;
use crate::machine::Machine;
use crate::options::Options;
use crate::socket::{Socket, LONGEST};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Set by SIGINT and SIGTERM.
static STOP: AtomicBool = AtomicBool::new(false);
/// Set by SIGUSR1: nobody sends frames any more.
static GONE: AtomicBool = AtomicBool::new(false);
/// Longest sleep, so that a signal just before it is not missed for long.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);
/// Delay [base steps] beyond which steps are skipped rather than caught up.
const LONGEST_BACKLOG: i64 = 4000;
/// Longest time [s] in which a plant that nothing holds comes to rest at the end.
const LONGEST_END: f64 = 5.0;

extern "C" fn stop(_: libc::c_int) {
    STOP.store(true, Ordering::Relaxed);
}

extern "C" fn gone(_: libc::c_int) {
    GONE.store(true, Ordering::Relaxed);
}

fn catch_signals() {
    let stop = stop as *const () as libc::sighandler_t;
    let gone = gone as *const () as libc::sighandler_t;
    for (signal, handler) in [(libc::SIGINT, stop), (libc::SIGTERM, stop), (libc::SIGUSR1, gone)] {
        // SAFETY: the handlers only store to an atomic, which is allowed in a handler.
        unsafe { libc::signal(signal, handler) };
    }
}

fn failed(error: std::io::Error) -> Error {
    Error::new(format!("the interface failed: {error}: check it with `ip link`"))
}

struct Run {
    options: Options,
    machine: Machine,
    socket: Socket,
    begun: Instant,
    buffer: [u8; LONGEST],
    out: Vec<Vec<u8>>,
}

/// Emulates until SIGINT or SIGTERM, or until `cycles` plant cycles are done.
pub fn run(options: Options) -> Result<(), Error> {
    let socket = Socket::open(&options.interface)?;
    let (machine, dt) = assemble(&options)?;
    catch_signals();
    let mut run = Run {
        options,
        machine,
        socket,
        begun: Instant::now(),
        buffer: [0; LONGEST],
        out: Vec::new(),
    };
    run.machine.record(EventKind::Ready {
        interface: run.options.interface.clone(),
        drives: run.options.drives.count,
        lockstep: run.options.lockstep,
    });
    run.print()?;
    if run.options.lockstep {
        run.lockstep()?;
        run.come_to_rest()?;
    } else {
        run.wall_clock((dt * 1e9).round() as i64)?;
    }
    run.machine.stop()?;
    run.print()
}

impl Run {
    fn done(&self) -> bool {
        let cycle = self.machine.cycle().unwrap_or(0);
        let all = self.options.cycles.is_some_and(|cycles| cycle >= cycles);
        all || STOP.load(Ordering::Relaxed)
    }

    fn lockstep(&mut self) -> Result<(), Error> {
        let silence = self.options.silence_s.map(Duration::from_secs_f64);
        let mut last = Instant::now();
        let mut silent = false;
        while !self.done() {
            if let Some(length) = self.next_frame()? {
                self.answer(length)?;
                last = Instant::now();
                silent = false;
            } else if GONE.swap(false, Ordering::Relaxed)
                || !silent && silence.is_some_and(|most| last.elapsed() >= most)
            {
                silent = true;
                self.continue_without_frames()?;
            } else {
                self.socket.wait(Some(silence.unwrap_or(LONGEST_SLEEP).min(LONGEST_SLEEP)));
            }
        }
        Ok(())
    }

    /// At the end a plant that nothing holds comes to rest, after the watchdogs.
    fn come_to_rest(&mut self) -> Result<(), Error> {
        if self.machine.cycle().is_some() {
            let time = self.options.plant.resting_s.unwrap_or(0.0).min(LONGEST_END);
            (0..self.machine.steps(time)).try_for_each(|_| self.machine.advance(0))?;
        }
        Ok(())
    }

    /// The MainDevice is gone: the plant continues until no drive has torque.
    fn continue_without_frames(&mut self) -> Result<(), Error> {
        if self.machine.cycle().is_none() || !self.machine.has_torque() {
            return Ok(());
        }
        self.machine.record(EventKind::Silence);
        while self.machine.has_torque() && !self.done() {
            self.machine.advance(0)?;
        }
        self.print()
    }

    /// The plant steps at SYNC0, so the time of a frame within the cycle has no effect. Overdue steps
    /// are done before each frame is processed, also those of a time in which this process stood still,
    /// so that no reply shows an old angle; watchdogs count only up to the last look for frames meanwhile.
    fn wall_clock(&mut self, dt: i64) -> Result<(), Error> {
        let mut next = self.wall() + dt;
        let mut looked = self.wall();
        while !self.done() {
            let frame = self.next_frame()?;
            let now = self.wall();
            if now >= next + dt * LONGEST_BACKLOG {
                next = now;
            }
            while next <= now && !self.done() {
                self.machine.advance(looked)?;
                next = self.machine.nearest_sync0(next + dt);
            }
            self.print()?;
            looked = now;
            let waits = self.machine.cycle().is_none();
            if let Some(length) = frame {
                self.answer(length)?;
            } else {
                let left = Duration::from_nanos((next - self.wall()).max(0) as u64);
                self.socket.wait(Some(left.min(LONGEST_SLEEP)));
            }
            if waits && self.machine.cycle().is_some() {
                // the first step is half a cycle after its frame, where there is no SYNC0
                let middle = self.wall() + dt / 2;
                next = self.machine.nearest_sync0(middle);
            }
        }
        Ok(())
    }

    fn wall(&self) -> i64 {
        self.begun.elapsed().as_nanos() as i64
    }

    /// The length of the next frame, which lies in the buffer; None: nothing is waiting.
    fn next_frame(&mut self) -> Result<Option<usize>, Error> {
        let frame = self.socket.receive(&mut self.buffer).map_err(failed)?;
        Ok(frame.map(<[u8]>::len))
    }

    /// Processes the frame in the buffer and sends the replies.
    fn answer(&mut self, length: usize) -> Result<(), Error> {
        let wall = self.wall();
        self.machine.receive(&self.buffer[..length], wall, &mut self.out)?;
        self.pause()?;
        for reply in self.out.drain(..) {
            self.socket.send(&reply).map_err(failed)?;
        }
        self.print()
    }

    /// Where a fault wants it: this process stands still before it answers, until it is continued (SIGCONT).
    fn pause(&mut self) -> Result<(), Error> {
        if self.machine.take_pause() {
            self.print()?;
            // SAFETY: a signal to this process, which needs no memory.
            unsafe { libc::raise(libc::SIGSTOP) };
        }
        Ok(())
    }

    fn print(&mut self) -> Result<(), Error> {
        if self.machine.events.is_empty() {
            return Ok(());
        }
        let time = monotonic();
        let mut out = std::io::stdout().lock();
        for event in self.machine.events.drain(..) {
            let line = if self.options.json { event.json(time) } else { event.text() };
            // a reader that has gone away is no reason to stop
            let _ = writeln!(out, "{line}");
        }
        let _ = out.flush();
        Ok(())
    }
}

/// CLOCK_MONOTONIC, which other programs on this computer can read too.
fn monotonic() -> Duration {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is a timespec that lives through the call.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &mut time) };
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}
