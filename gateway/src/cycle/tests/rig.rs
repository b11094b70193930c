//! A whole run in the process of the test: real frames, FMUs, a machine with weight whose drives brake.

use flexhex_emulator::Loopback;
use flexhex_system::System;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Duration;

use super::*;
use crate::bus::{bring_up, BringUpOptions};
use crate::config::parse;
use crate::record::{ring, Columns};
use crate::session;

/// Most rows of a run.
const ROWS: usize = 60_000;
/// Command of process data, and its place in a frame.
pub const LRW: u8 = 12;
pub const COMMAND: usize = 16;
/// Command of a read of one device, the place of the register, and the first of the error counters.
pub const FPRD: u8 = 4;
pub const REGISTER: std::ops::Range<usize> = 20..22;
pub const COUNTERS: [u8; 2] = 0x0300u16.to_le_bytes();
const TS: f64 = 0.00025;

/// The emulated line.
pub struct Line {
    pub line: Loopback,
    pub arriving: VecDeque<Vec<u8>>,
    /// Frames of process data.
    pub frames: u64,
}

impl Line {
    /// At rest under its weight; `more`: further options of the emulator.
    pub fn open(more: &str) -> Line {
        let path = ssp().display().to_string();
        let text =
            format!("plant.system = {path:?}\nplant.resting_s = 5.0\ndrives.braking = 1.8\n{more}");
        Line {
            line: Loopback::open(&toml::from_str(&text).unwrap()).unwrap(),
            arriving: VecDeque::new(),
            frames: 0,
        }
    }

    /// Nothing is sent any more for a time [s].
    pub fn leave_alone(&mut self, time: f64) {
        for _ in 0..(time / TS) as usize {
            self.line.wait().unwrap();
        }
    }
}

impl Link for &mut Line {
    fn send(&mut self, frame: &[u8]) -> bool {
        let replies = self.line.answer(frame).unwrap();
        if frame[COMMAND] == LRW {
            self.frames += 1;
        }
        self.arriving.extend(replies);
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let reply = self.arriving.pop_front()?;
        buffer[..reply.len()].copy_from_slice(&reply);
        Some(reply.len())
    }

    fn wait(&mut self, _: u64) {}
}

/// The `.ssp` that the environment names, else the one that `flexhex build` writes.
pub fn ssp() -> PathBuf {
    let built = concat!(env!("CARGO_MANIFEST_DIR"), "/../out/hexapod.ssp");
    std::env::var_os("FLEXHEX_SSP").map_or(built.into(), PathBuf::from)
}

/// What a run left: its end, and its rows.
pub struct Ran {
    pub out: Outcome,
    pub rows: Vec<Vec<f64>>,
    pub columns: Columns,
}

impl Ran {
    pub fn place(&self, name: &str) -> usize {
        self.columns.names.iter().position(|n| n == name).unwrap()
    }

    pub fn phases(&self) -> Vec<f64> {
        let mut phases: Vec<_> = self.rows.iter().map(|row| row[self.place("phase")]).collect();
        phases.dedup();
        phases
    }
}

/// The configuration of the template.
pub fn config() -> Config {
    parse(include_str!("../../../machines/akd.toml")).unwrap()
}

/// A run of so many cycles of the controller over a link, in lockstep.
pub fn run<L: Link>(link: L, cycles: i64) -> Ran {
    run_with(&config(), link, cycles, |_| ())
}

/// The same with another configuration; `first` does the first cycles.
pub fn run_with<L: Link>(
    config: &Config,
    link: L,
    cycles: i64,
    first: impl FnOnce(&mut ControlLoop<L>),
) -> Ran {
    let path = ssp();
    let system = System::open(&path).unwrap_or_else(|e| panic!("{e}: set FLEXHEX_SSP"));
    let parameters: Vec<_> = config.system.parameters.clone().into_iter().collect();
    let system = system.with(&parameters).unwrap();
    let controller = signals::open(config, &system, true, Vec::new()).unwrap();
    let signals = Signals::find(config, &controller).unwrap();
    let mechanics = session::mechanics(config, &system).unwrap();
    let columns = Columns::with(&[]);
    let (sink, mut source) = ring(ROWS, columns.len());
    let cycle = Duration::from_secs_f64(system.base_step());
    let (lockstep, reset_faults, replayed) = (true, false, false);
    let options = BringUpOptions { cycle, lockstep, reset_faults, replayed, cyclic: true };
    let bus = bring_up(config, link, options, &mut |_| ()).unwrap();
    let board = Board::new(columns.len());
    let options = RunOptions { cycles, dry_run: false, lockstep, reset_faults };
    let sinks = (sink, Preallocated::new(columns.len()));
    let workspace = Workspace::open(config, &system, "").unwrap();
    let parts = (controller, signals, mechanics, workspace);
    let base_step = system.base_step();
    let task = (options, crate::tasks::Task::Control);
    let mut control = ControlLoop::new(config, task, bus, parts, sinks, (&board, base_step));
    first(&mut control);
    let (out, _) = control.run();
    let (mut row, mut rows) = (vec![0.0; columns.len()], Vec::new());
    while source.take(&mut row) {
        rows.push(row.clone());
    }
    Ran { out, rows, columns }
}
