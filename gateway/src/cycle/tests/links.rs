//! What the controllers of the devices counted in a run, and clocks before and after it.

use std::time::Duration;

use super::rig::{config, run, Line, COMMAND, COUNTERS, FPRD, LRW, REGISTER};
use super::*;
use crate::bus::{bring_up, Ask, BringUpOptions, Clocks};

/// Cycle since the drives were enabled, in the lift-off.
const AT: u64 = 2000;
const CYCLES: i64 = 400;
const CYCLE: Duration = Duration::from_micros(250);
/// Position, port and counts by kind.
type Counted = (usize, usize, [u8; 4]);

fn counted(out: &Outcome) -> Vec<Counted> {
    let one = |p: &crate::bus::PortErrors| (p.position, p.port, p.counts.map(|c| c.number));
    out.links.ports.iter().map(one).collect()
}

/// A run with a fault that lasts so many cycles.
fn faulty(kind: &str, count: u64, more: &str) -> Outcome {
    let text =
        format!("[[fault]]\nkind = '{kind}'\ncycle = {AT}\ncount = {count}\nposition = 2\n{more}");
    run(&mut Line::open(&text), CYCLES).out
}

#[test]
fn a_run_without_errors_counts_none_and_reads_every_device() {
    // what was counted before is not of the run
    let out = run(&mut Line::open("[[drive]]\nposition = 3\nregisters = [[784, 9]]"), CYCLES).out;
    assert!(out.good() && out.links.known);
    assert_eq!((counted(&out), out.links.unread), (vec![], vec![]));
    assert_eq!(out.clocks.start, [None; AXES], "lockstep has no clocks");
}

#[test]
fn noise_on_a_cable_stops_nothing_and_is_counted_at_its_port() {
    let out = faulty("link_noise", 7, "port = 1");
    assert!(out.good());
    assert_eq!(counted(&out), [(2, 1, [0, 7, 0, 0])]);
}

#[test]
fn damaged_frames_are_lost_frames_whose_cable_is_known() {
    let out = faulty("frame_damaged", 3, "burst = 1\nevery = 2");
    assert!(out.good());
    let passed_on = [0, 0, 2, 0];
    let [back, there] = [1, 0].map(|port| move |k| (k, port, passed_on));
    let invalid = (2, 0, [2, 2, 0, 0]);
    let wanted =
        [back(0), back(1), invalid, back(2), there(3), back(3), there(4), back(4), there(5)];
    assert_eq!(counted(&out), wanted);
}

#[test]
fn a_plug_that_was_loose_for_two_cycles_is_a_lost_link_at_both_ends() {
    let out = faulty("cable_cut", 2, "");
    assert!(out.good());
    assert_eq!(counted(&out), [(1, 1, [0, 0, 0, 1]), (2, 0, [0, 0, 0, 1])]);
}

#[test]
fn devices_behind_a_cut_cable_are_named_as_not_read() {
    let out = faulty("cable_cut", 0, "");
    assert!(matches!(out.ending, Ending::Tripped(..)));
    assert_eq!(counted(&out), [(1, 1, [0, 0, 0, 1])]);
    assert_eq!(out.links.unread, [2, 3, 4, 5]);
}

/// A line on which so many replies to questions about a register are lost.
pub struct Deaf<'a> {
    pub line: &'a mut Line,
    pub register: [u8; 2],
    pub lost: u64,
}

impl Link for &mut Deaf<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        if frame[COMMAND] == FPRD && frame[REGISTER] == self.register && self.lost > 0 {
            self.lost -= 1;
            return true;
        }
        self.line.send(frame)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.line.receive(buffer)
    }

    fn wait(&mut self, _: u64) {}
}

#[test]
fn a_lost_reply_is_asked_for_again_and_without_any_the_run_is_the_same() {
    let ran = |lost| {
        let mut line = Line::open("");
        run(&mut Deaf { line: &mut line, register: COUNTERS, lost }, CYCLES).out
    };
    let (one, none) = (ran(1), ran(u64::MAX));
    assert!(one.good() && one.links.known && one.links.unread.is_empty());
    assert!(none.good() && !none.links.known && none.links.ports.is_empty());
}

#[test]
fn a_lost_reply_does_not_say_that_no_watchdog_runs() {
    let register = 0x0440u16.to_le_bytes();
    for lost in [1, 2] {
        let mut line = Line::open("");
        assert!(run(&mut Deaf { line: &mut line, register, lost }, CYCLES).out.good());
    }
}

/// The bus with distributed clocks: in lockstep only a replayed run has them. After so many cycles.
pub fn clocks(line: impl Link, config: &Config, cycles: usize) -> Result<Clocks, String> {
    let options = BringUpOptions {
        cycle: CYCLE,
        lockstep: true,
        reset_faults: false,
        replayed: true,
        cyclic: true,
    };
    let bus = bring_up(config, line, options, &mut |_| ());
    let mut bus = bus.map_err(|why| why.to_string())?;
    for _ in 0..cycles {
        assert!(bus.exchange(u64::MAX).answered);
    }
    Ok(bus.leave(Ask::default(), &[true; AXES]).clocks)
}

#[test]
fn clocks_that_follow_the_first_one_settle_within_some_ns() {
    let report = clocks(&mut Line::open("drives.drift_ppm = 100.0"), &config(), 4000).unwrap();
    assert_eq!((report.bound_ns, report.start[0]), (2500, None), "the first follows nobody");
    for ns in report.start[1..].iter().chain(&report.end[1..]) {
        assert!(ns.is_some_and(|ns| ns.abs() < 100), "{report:?}");
    }
}

#[test]
fn a_clock_that_drifts_away_is_told_at_the_end() {
    let text =
        "drives.drift_ppm = 0.0\n[[drive]]\nposition = 4\ndrift_ppm = -20.0\nclock_free = true";
    let mut config = config();
    // the master sets the clocks to within the delays of the line, here 4 times 0.68 us
    config.bus.clock_difference_ns = Some(5000);
    let report = clocks(&mut Line::open(text), &config, 4000).unwrap();
    let [start, end] = [report.start, report.end].map(|all| all[4].unwrap());
    // 20 ppm of the second of the cycles: 20 us, behind
    assert!(start.abs() < 5000, "{start}");
    assert!((end - start + 20_000).abs() < 100, "{start} {end}");
    assert_eq!(crate::bus::largest(&report.end).map(|(axis, _)| axis), Some(4));
}

#[test]
fn a_clock_beyond_its_bound_is_refused_with_the_remedy() {
    let text = "[[drive]]\nposition = 1\ndrift_ppm = 9000.0\nclock_free = true";
    let why = clocks(&mut Line::open(text), &config(), 0).unwrap_err();
    let wanted = "axis 2, position 1: system time difference (register 0x092c) is ";
    assert!(why.starts_with(wanted) && why.lines().count() == 1, "{why}");
    let bound = "expected at most 2500 ns either way (bus.clock_difference_ns): its clock does not";
    assert!(why.contains(bound), "{why}");
    let mut config = config();
    config.bus.clock_difference_ns = Some(1_000_000);
    clocks(&mut Line::open(text), &config, 0).unwrap();
}

/// A line that counts frames of other kinds than process data while a drive gives torque.
struct Watched<'a> {
    line: &'a mut Line,
    cycles: u64,
    others: u64,
}

impl Link for &mut Watched<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        if self.line.line.powered().contains(&true) {
            let cyclic = frame[COMMAND] == LRW;
            self.cycles += u64::from(cyclic);
            self.others += u64::from(!cyclic);
        }
        self.line.send(frame)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.line.receive(buffer)
    }

    fn wait(&mut self, _: u64) {}
}

#[test]
fn nothing_is_asked_between_cycles_while_a_drive_has_power() {
    for fault in ["", "[[fault]]\nkind = 'link_noise'\ncycle = 2000\ncount = 9"] {
        let mut line = Line::open(fault);
        let mut watched = Watched { line: &mut line, cycles: 0, others: 0 };
        let out = run(&mut watched, CYCLES).out;
        assert!(out.links.known && watched.cycles > 1000);
        assert_eq!(watched.others, 0);
    }
}
