//! A capture judged again ends as the run did that it is of.

use super::rig::{run, Line};
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
        let theta = one.place("theta[1]");
        let bits = |ran: &super::rig::Ran| -> Vec<u64> {
            ran.rows.iter().flat_map(|row| &row[theta..theta + 24]).map(|v| v.to_bits()).collect()
        };
        assert!(one.rows.len() > 13_000);
        assert!(bits(&one) == bits(&two), "{fault}: other rows");
    }
}
