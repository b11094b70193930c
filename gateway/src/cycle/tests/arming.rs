//! Replies that go wrong while the drives are being enabled.

use super::rig::{config, run, Line, COMMAND, LRW};
use super::*;

/// Head of a frame and its datagram, and the place of the length of its data.
const DATA: usize = 26;
const LENGTH: std::ops::Range<usize> = 22..24;

/// A line on which one drive takes no part in any frame any more from the first drive with power on.
struct Short<'a> {
    line: &'a mut Line,
    /// Frames of process data with power.
    powered: u64,
}

impl Link for &mut Short<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.line.send(frame);
        if frame[COMMAND] == LRW && self.line.line.powered().contains(&true) {
            self.powered += 1;
            for reply in &mut self.line.arriving {
                let length = u16::from_le_bytes(reply[LENGTH].try_into().unwrap()) & 0x7ff;
                reply[DATA + usize::from(length)] -= 3;
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
fn replies_that_stay_incomplete_take_the_power_as_in_a_run() {
    let mut line = Line::open("");
    let mut link = Short { line: &mut line, powered: 0 };
    let out = run(&mut link, 8).out;
    let (powered, limit) = (link.powered, config().safety.working_counter_limit);
    assert!(powered <= u64::from(limit) + 1, "{powered} frames with power");
    let Ending::Refused(why) = out.ending else { panic!("not refused") };
    let text = why.to_string();
    assert!(text.contains("being enabled: working counter 15, expected 18"), "{text}");
    assert_eq!(why.key(), "working_counter");
}
