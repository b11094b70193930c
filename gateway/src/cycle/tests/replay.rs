//! A capture judged again ends as the run did that it is of.

use super::rig::{run, Line, COMMAND, COUNTERS, FPRD, LRW, REGISTER};
use super::*;
use crate::wire::{pcap, Replay};

struct Captured<'a> {
    line: &'a mut Line,
    frames: Vec<Vec<u8>>,
}

impl Link for &mut Captured<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.frames.push(frame.to_vec());
        self.line.send(frame)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let length = self.line.receive(buffer)?;
        self.frames.push(buffer[..length].to_vec());
        Some(length)
    }

    fn wait(&mut self, _: u64) {}
}

#[test]
fn a_replayed_capture_gives_the_same_rows_and_the_same_trip() {
    for fault in ["kind = \"drive_fault\"", "kind = \"encoder_jump\"", "kind = \"cable_cut\""] {
        let mut line = Line::open(&format!("[[fault]]\ncycle = 13000\nposition = 2\n{fault}\n"));
        let mut captured = Captured { line: &mut line, frames: Vec::new() };
        let one = run(&mut captured, 4000);
        let two = run(Replay::of(&pcap(&captured.frames)).unwrap(), 4000);
        let trip = |ran: &super::rig::Ran| match &ran.out.ending {
            Ending::Tripped(trip, _) => *trip,
            _ => panic!("{fault}: it did not trip"),
        };
        assert_eq!(trip(&one), trip(&two));
        assert_eq!(one.out.disabled, two.out.disabled);
        assert!(one.out.links == two.out.links && one.out.links.known);
        let theta = one.place("theta[1]");
        let bits = |ran: &super::rig::Ran| -> Vec<u64> {
            ran.rows.iter().flat_map(|row| &row[theta..theta + 24]).map(|v| v.to_bits()).collect()
        };
        assert!(one.rows.len() > 13_000);
        assert!(bits(&one) == bits(&two), "{fault}: other rows");
    }
}

/// The capture as an older version left it: without the questions about error counters, and the cycle after each.
fn without_questions(frames: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let asks = |frame: &[u8]| frame[COMMAND] == FPRD && frame[REGISTER] == COUNTERS;
    let mut kept = Vec::new();
    let (mut due, mut in_op) = (false, false);
    for frame in frames {
        in_op |= frame[COMMAND] == LRW;
        if asks(frame) {
            due = in_op;
            continue;
        }
        let skipped = due && frame[COMMAND] == LRW;
        let is_reply = frame[6] & 0x02 != 0;
        due &= !(skipped && is_reply);
        if !skipped {
            kept.push(frame.clone());
        }
    }
    kept
}

#[test]
fn a_capture_without_questions_about_counters_is_judged_as_before() {
    let fault = "[[fault]]\ncycle = 13000\nposition = 2\nkind = \"drive_fault\"\n";
    let mut line = Line::open(fault);
    let mut captured = Captured { line: &mut line, frames: Vec::new() };
    let one = run(&mut captured, 4000);
    let two = run(Replay::of(&pcap(&without_questions(&captured.frames))).unwrap(), 4000);
    assert!(one.out.links.known && !two.out.links.known);
    assert_eq!(two.out.links.ports, []);
    let bits = |ran: &super::rig::Ran| -> Vec<u64> {
        // times of this computer stand elsewhere
        let theta = ran.place("theta[1]");
        ran.rows.iter().flat_map(|row| &row[theta..theta + 24]).map(|v| v.to_bits()).collect()
    };
    assert!(bits(&one) == bits(&two));
    assert_eq!(one.out.disabled, two.out.disabled);
}
