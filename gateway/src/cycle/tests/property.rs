//! Whatever single fault strikes, and whenever: the machine ends at rest, within its stroke, and no axis is faster
//! than 1 rad/s; drives end without power, and one that still has it when the gateway ends is named.

use super::rig::{config, run_with, Line, Ran, COMMAND, LRW};
use super::*;
use flexhex_system::Value;

/// Faults that are drawn; FLEXHEX_FAULTS names others by their numbers, as in `3,17,40`.
const CASES: u64 = 40;
/// Bytes of process data out and in: six drives of 8 and 16.
const PROCESS_DATA: u64 = 6 * (8 + 16);
/// Cycles of the controller: with lift-off and landing a run has some 24 000.
const CYCLES: i64 = 2000;
const LAST: u64 = 22_000;
/// End stops [rad], with the rounding of the encoder.
const STROKE: f64 = std::f64::consts::FRAC_PI_6 + 1e-6;
/// Counts of a radian.
const RAD: f64 = 683_565_275.6;

/// Always the same numbers [Steele et al. 2014, SplitMix64].
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ z >> 31) as f64 / u64::MAX as f64
    }

    fn below(&mut self, n: u64) -> u64 {
        (self.next() * n as f64) as u64
    }
}

/// Numbers of the cases: what a case is does not depend on which others are run.
fn cases() -> Vec<u64> {
    let Ok(named) = std::env::var("FLEXHEX_FAULTS") else { return (0..CASES).collect() };
    named.split(',').map(|number| number.parse().unwrap()).collect()
}

/// A run along a trajectory of its own, which moves from the first cycle of the controller on.
fn moving<L: Link>(chance: &mut Chance, link: L) -> Ran {
    let mut config = config();
    let parameters = &mut config.system.parameters;
    parameters.insert("reference.t_start".to_owned(), Value::Number(0.0));
    let seed = 1 + chance.below(1_000_000);
    parameters.insert("reference.seed".to_owned(), Value::Number(seed as f64));
    run_with(&config, link, CYCLES, |_| ())
}

/// A fault of the emulator drawn at random.
fn fault(chance: &mut Chance) -> String {
    let (cycle, position) = (1 + chance.below(LAST), chance.below(6));
    let sign = if chance.next() < 0.5 { -1.0 } else { 1.0 };
    let jump = sign * RAD * 10f64.powf(-4.0 + 3.0 * chance.next());
    let kinds = [
        "kind = \"drive_fault\"".to_owned(),
        format!("kind = \"encoder_jump\"\nsize = {jump:.0}"),
        "kind = \"encoder_frozen\"".to_owned(),
        format!("kind = \"mode_change\"\nsize = {}", chance.below(11)),
        "kind = \"control_ignored\"".to_owned(),
        "kind = \"status_frozen\"".to_owned(),
        "kind = \"sto\"".to_owned(),
        format!("kind = \"push\"\nsize = {:.0}\ncount = 40", sign * 6000.0 * chance.next()),
        "kind = \"torque_frozen\"".to_owned(),
        format!("kind = \"safe_op\"\ncode = {}", chance.below(64)),
        format!("kind = \"wkc_short\"\ncount = {}", chance.below(40)),
        "kind = \"cable_cut\"".to_owned(),
        format!("kind = \"frame_lost\"\ncount = 0\nprobability = {:.3}", chance.next()),
        format!("kind = \"frame_lost\"\nacting = \"after\"\ncount = {}", chance.below(40)),
        format!("kind = \"frame_delayed\"\ncount = 0\nprobability = {:.3}", 0.3 * chance.next()),
        format!("kind = \"frame_duplicated\"\ncount = 0\nprobability = {:.3}", chance.next()),
    ];
    let kind = &kinds[chance.below(kinds.len() as u64) as usize];
    format!("[[fault]]\ncycle = {cycle}\nposition = {position}\n{kind}\n")
}

/// What must hold afterwards.
fn ends_well(what: &str, line: &mut Line, out: &Outcome) {
    let case = format!("{what}: {:?}", out.unconfirmed());
    line.line.wait().unwrap();
    for axis in (0..AXES).filter(|axis| line.line.powered()[*axis]) {
        assert!(out.unconfirmed().contains(&(axis + 1)), "{case}: axis {} has power", axis + 1);
    }
    line.leave_alone(3.0);
    let before = line.line.angles();
    line.leave_alone(0.5);
    let after = line.line.angles();
    let rate = (0..AXES).map(|k| (after[k] - before[k]).abs() / 0.5).fold(0.0, f64::max);
    assert!(rate < 0.1, "{case}: {rate} rad/s at the end");
    assert!(!line.line.powered().contains(&true), "{case}: a drive has power at the end");
    let (fastest, farthest) = line.line.extremes();
    assert!(fastest < 1.0, "{case}: {fastest} rad/s");
    assert!(farthest <= STROKE, "{case}: {farthest} rad");
}

#[test]
fn any_single_fault_at_any_time_ends_at_rest() {
    for case in cases() {
        let mut chance = Chance(1900 + case);
        let fault = fault(&mut chance);
        let mut line = Line::open(&fault);
        let ran = moving(&mut chance, &mut line);
        ends_well(&format!("case {case}: {fault}"), &mut line, &ran.out);
    }
}

/// Bytes of the inputs that are not what the drives said.
struct Noise<'a> {
    line: &'a mut Line,
    chance: Chance,
    /// Frame of process data from which on, and how many are spoiled.
    frames: std::ops::Range<u64>,
    /// Bytes in a row that are always the same ones, as of one object; none: any.
    window: Option<usize>,
}

/// Head of a frame and its datagram; counters and states of the drives come after it.
const HEAD: u64 = 26;
/// Bytes of the largest object.
const OBJECT: usize = 4;

impl Link for Noise<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.line.send(frame);
        let spoils = frame[COMMAND] == LRW && self.frames.contains(&self.line.frames);
        for reply in self.line.arriving.iter_mut().filter(|reply| spoils && reply.len() > 60) {
            let length = reply.len() as u64;
            let any = |chance: &mut Chance| (HEAD + chance.below(length - HEAD)) as usize;
            let places: Vec<usize> = match self.window {
                Some(first) => (first..first + OBJECT).collect(),
                None => (0..=self.chance.below(8)).map(|_| any(&mut self.chance)).collect(),
            };
            for at in places {
                reply[at] = self.chance.below(256) as u8;
            }
        }
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.line.receive(buffer)
    }

    fn wait(&mut self, _: u64) {}
}

#[test]
fn any_bytes_in_the_replies_end_at_rest() {
    for case in cases() {
        let mut chance = Chance(2000 + case);
        let begin = 3 + chance.below(LAST);
        // one reply, a few, or all from then on
        let count = [1, 3, 40, 1_000_000][case as usize % 4];
        let window = (case % 8 > 2).then(|| (HEAD + chance.below(PROCESS_DATA)) as usize);
        let mut line = Line::open("");
        let frames = begin..begin + count;
        let noise = Noise { line: &mut line, chance: Chance(case), frames, window };
        let ran = moving(&mut chance, noise);
        let what = format!("case {case}: {count} replies from {begin} on, {window:?}");
        ends_well(&what, &mut line, &ran.out);
    }
}
