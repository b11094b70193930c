//! A panic in the control loop, in the process of the test: real frames, FMUs, a machine with weight.

use flexhex_emulator::Loopback;
use flexhex_system::System;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Duration;

use super::*;
use crate::bus::{bring_up, BringUpOptions};
use crate::config::parse;
use crate::record::{ring, Columns};
use crate::rules::{ReactionKind, Reason};
use crate::session;

/// Frame of process data in which the link panics: the lift-off takes some 12 000.
const PANIC_AT: u64 = 16_000;
const ROWS: usize = 60_000;
/// Command of process data, and its place in a frame.
const LRW: u8 = 12;
const COMMAND: usize = 16;

struct Panics {
    line: Loopback,
    arriving: VecDeque<Vec<u8>>,
    frames: u64,
}

impl Link for Panics {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.frames += u64::from(frame[COMMAND] == LRW);
        if self.frames == PANIC_AT {
            self.frames += 1;
            panic!("on purpose");
        }
        self.arriving.extend(self.line.answer(frame).unwrap());
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
fn ssp() -> PathBuf {
    let built = concat!(env!("CARGO_MANIFEST_DIR"), "/../out/hexapod.ssp");
    std::env::var_os("FLEXHEX_SSP").map_or(built.into(), PathBuf::from)
}

#[test]
fn a_panic_in_a_cycle_lands_the_machine() {
    let path = ssp();
    let system = System::open(&path).unwrap_or_else(|e| panic!("{e}: set FLEXHEX_SSP"));
    let config = parse(include_str!("../../machines/akd.toml")).unwrap();
    let text = format!("plant = {{ system = {:?}, resting_s = 5.0 }}", path.display().to_string());
    let line = Loopback::open(&toml::from_str(&text).unwrap()).unwrap();
    let link = Panics { line, arriving: VecDeque::new(), frames: 0 };
    let controller = signals::open(&config, &system, true, Vec::new()).unwrap();
    let signals = Signals::find(&config, &controller).unwrap();
    let mechanics = session::mechanics(&config, &system).unwrap();
    let columns = Columns::with(&[]);
    let (sink, mut source) = ring(ROWS, columns.len());
    let cycle = Duration::from_secs_f64(system.base_step());
    let options = BringUpOptions { cycle, lockstep: true, reset_faults: false, cyclic: true };
    let bus = bring_up(&config, link, options, &mut |_| ()).unwrap();
    let board = Board::new(columns.len());
    let options =
        RunOptions { cycles: 1_000_000, dry_run: false, lockstep: true, reset_faults: false };
    let options = (options, Task::Control);
    let sinks = (sink, Preallocated::new(columns.len()));
    let parts = (controller, signals, mechanics);
    let out =
        ControlLoop::new(&config, options, bus, parts, sinks, (&board, system.base_step())).run();

    let Ending::Tripped(trip, _) = &out.ending else { panic!("it did not trip") };
    assert_eq!((trip.reason, out.reaction), (Reason::Panic, ReactionKind::Land));
    assert!(trip.cycle > 1000, "in the run: {}", trip.cycle);
    assert_eq!((out.unconfirmed(), out.landing_trip), (vec![], None));
    // braking, two pauses and the way back: nothing is let fall
    assert!(out.to_zero > 8000, "{}", out.to_zero);
    let place = |name: &str| columns.names.iter().position(|n| n == name).unwrap();
    let (theta, phase) = (place("theta[1]"), place("phase"));
    let (mut row, mut first, mut last) = (vec![0.0; columns.len()], None, Vec::new());
    let mut phases = Vec::new();
    while source.take(&mut row) {
        first.get_or_insert_with(|| row.clone());
        if phases.last() != Some(&row[phase]) {
            phases.push(row[phase]);
        }
        last.clone_from(&row);
    }
    assert_eq!(phases, [3.0, 1.0, 4.0, 2.0], "lift-off, run, landing, disabling");
    let first = first.unwrap();
    for k in theta..theta + AXES {
        assert!(first[k] < -0.3 && (last[k] - first[k]).abs() < 0.02, "{} {}", first[k], last[k]);
    }
}
