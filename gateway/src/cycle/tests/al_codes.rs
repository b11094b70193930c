//! AL status codes of drives that are not in OP: each is read, also where a reply is lost.

use super::links::{clocks, Deaf};
use super::rig::{config, run, run_with, Line};
use super::*;

/// A line that counts the frames of process data up to the first with power.
struct Enabling<'a> {
    line: &'a mut Line,
    frames: u64,
}

impl Link for &mut Enabling<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        let sent = self.line.send(frame);
        if self.frames == 0 && self.line.line.powered().contains(&true) {
            self.frames = self.line.frames;
        }
        sent
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.line.receive(buffer)
    }

    fn wait(&mut self, _: u64) {}
}

/// Frames of process data that are lost before they act, for longer than a watchdog of 1 ms.
fn without_frames(from: u64) -> (String, Config) {
    let lost = "kind = 'frame_lost'\nacting = 'before'\ncounting = 'frames'\ncount = 6";
    let mut config = config();
    // four cycles
    config.bus.watchdog_ms = 1;
    (format!("[[fault]]\n{lost}\ncycle = {from}"), config)
}

#[test]
fn drives_that_left_op_meanwhile_are_told_by_their_al_status() {
    let (lost, config) = without_frames(2);
    for (asked, code) in [(0, "0x001b"), (1, "0x001b"), (u64::MAX, "not read")] {
        let register = 0x0134u16.to_le_bytes();
        let mut line = Line::open(&lost);
        let why =
            clocks(&mut Deaf { line: &mut line, register, lost: asked }, &config, 0).unwrap_err();
        let told = format!("axis 1, position 0: SAFE-OP, AL status code {code}");
        assert!(why.contains(&told), "{why}");
        assert!(!why.contains("EEPROM"), "{why}");
    }
}

#[test]
fn drives_that_leave_op_while_they_are_enabled_are_told_by_their_al_status() {
    let mut line = Line::open("");
    let mut enabling = Enabling { line: &mut line, frames: 0 };
    assert!(run(&mut enabling, 1).out.good());
    let (lost, config) = without_frames(enabling.frames - 7);
    let out = run_with(&config, &mut Line::open(&lost), 1, |_| ()).out;
    let Ending::Refused(why) = out.ending else { panic!("not refused") };
    let text = why.to_string();
    let told = "SAFE-OP (AL status 0x04) while enabling, expected OP: AL status code 0x001b";
    assert!(text.contains(told), "{text}");
}
