//! The cable with a scripted other end: answers that come twice, late, spoiled or never.

use ethercrab::{Command, MainDevice, MainDeviceConfig, PduStorage, Timeouts};
use std::collections::VecDeque;
use std::time::Duration;

use super::{Counts, Link, Wire};
use crate::realtime::now_ns;

#[derive(Clone, Copy)]
enum Answer {
    Once,
    Twice,
    /// Kept back until the next frame is sent.
    Late,
    /// Kept back until the next frame with the same index is sent, and before its answer.
    SameIndexAgain,
    Never,
    /// The other end says that there is none.
    None,
    /// A frame of another index, one that is too short, then the answer.
    AfterRubbish,
}

/// One device that answers as the script says.
struct Script {
    answers: VecDeque<Answer>,
    arriving: VecDeque<Vec<u8>>,
    kept: Option<Vec<u8>>,
    wait_for_index: bool,
}

impl Link for Script {
    fn send(&mut self, frame: &[u8]) -> bool {
        let mut reply = frame.to_vec();
        reply[6] |= 0x02; // the first device marks the source address
        let counter = reply.len() - 2;
        reply[counter] = 1;
        let withheld =
            |kept: &[u8]| self.wait_for_index && kept[super::INDEX] != frame[super::INDEX];
        if self.kept.as_deref().is_some_and(|kept| !withheld(kept)) {
            self.arriving.extend(self.kept.take());
        }
        match self.answers.pop_front().unwrap_or(Answer::Once) {
            Answer::Once => self.arriving.push_back(reply),
            Answer::Twice => self.arriving.extend([reply.clone(), reply]),
            Answer::Late => (self.kept, self.wait_for_index) = (Some(reply), false),
            Answer::SameIndexAgain => (self.kept, self.wait_for_index) = (Some(reply), true),
            Answer::Never => {}
            Answer::None => self.arriving.push_back(no_reply(frame)),
            Answer::AfterRubbish => {
                let mut other = reply.clone();
                other[super::INDEX] ^= 0x80;
                self.arriving.extend([other, vec![1, 2, 3], reply]);
            }
        }
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let frame = self.arriving.pop_front()?;
        buffer[..frame.len()].copy_from_slice(&frame);
        Some(frame.len())
    }

    fn wait(&mut self, timeout_ns: u64) {
        std::thread::sleep(Duration::from_nanos(timeout_ns.min(1_000_000)));
    }
}

fn no_reply(frame: &[u8]) -> Vec<u8> {
    [&frame[..14], &[0, 0xF0], &[0; 44]].concat()
}

/// Read one register as often as there are answers: which reads came back, and the counts.
fn reads(answers: &[Answer]) -> (Vec<bool>, Counts) {
    reads_within(answers, false, 20_000_000)
}

fn reads_within(answers: &[Answer], lockstep: bool, wait_ns: u64) -> (Vec<bool>, Counts) {
    let storage: &'static PduStorage<4, { PduStorage::element_size(64) }> =
        Box::leak(Box::new(PduStorage::new()));
    let (tx, rx, pdu_loop) = storage.try_split().unwrap();
    let patient = Timeouts { pdu: Duration::from_secs(5), ..Timeouts::default() };
    let main: &'static MainDevice =
        Box::leak(Box::new(MainDevice::new(pdu_loop, patient, MainDeviceConfig::default())));
    let link = Script {
        answers: answers.iter().copied().collect(),
        arriving: VecDeque::new(),
        kept: None,
        wait_for_index: false,
    };
    let mut wire = Wire::new(link, tx, rx).in_lockstep(lockstep);
    let read = |_| {
        let register = Command::brd(0).receive::<u8>(main);
        wire.drive(register, now_ns() + wait_ns).is_some_and(|r| r.is_ok())
    };
    let came = (0..answers.len()).map(read).collect();
    (came, wire.counts)
}

#[test]
fn a_second_copy_is_counted_and_ends_nothing() {
    let (came, counts) = reads(&[Answer::Twice, Answer::Twice, Answer::Once]);
    assert_eq!(came, [true; 3]);
    assert_eq!((counts.sent, counts.answered, counts.duplicated), (3, 3, 2));
    assert_eq!((counts.late, counts.bad), (0, 0));
}

#[test]
fn a_late_reply_is_not_taken_for_the_next_one() {
    let (came, counts) = reads(&[Answer::Once, Answer::Late, Answer::Once]);
    assert_eq!(came, [true, false, true]);
    assert_eq!((counts.answered, counts.late, counts.duplicated), (2, 1, 0));
}

/// One byte of index is used again after 256 datagrams; the old reply comes just before the new.
#[test]
fn a_reply_of_the_frame_that_had_this_index_before_is_not_taken() {
    let mut answers = vec![Answer::SameIndexAgain];
    answers.extend([Answer::Once; 255]);
    answers.push(Answer::Never);
    answers.push(Answer::Once);
    let (came, counts) = reads(&answers);
    let mut wanted = vec![true; 258];
    (wanted[0], wanted[256]) = (false, false);
    assert_eq!(came, wanted);
    assert_eq!((counts.answered, counts.late, counts.duplicated, counts.bad), (256, 1, 0, 0));
}

#[test]
fn a_lost_frame_costs_one_cycle_and_is_not_sent_again() {
    let (came, counts) = reads(&[Answer::Never, Answer::Once]);
    assert_eq!(came, [false, true]);
    assert_eq!(counts.sent, 2);
}

#[test]
fn rubbish_is_counted_and_the_answer_still_found() {
    let (came, counts) = reads(&[Answer::AfterRubbish]);
    assert_eq!((came, counts.bad), (vec![true], 2));
}

#[test]
fn all_256_frame_numbers_are_used_again() {
    let (came, counts) = reads(&[Answer::Once; 600]);
    assert_eq!((came, counts.answered), (vec![true; 600], 600));
}

/// By the clock nobody may say so: the frame is rubbish then, and the reply is waited for.
#[test]
fn only_in_lockstep_the_other_end_ends_the_wait() {
    let begin = std::time::Instant::now();
    let (came, counts) = reads_within(&[Answer::None, Answer::Once], true, 60_000_000_000);
    assert_eq!((came, counts.bad, counts.late), (vec![false, true], 0, 0));
    assert!(begin.elapsed() < Duration::from_secs(30), "it did not wait for its deadline");
    let (came, counts) = reads(&[Answer::None, Answer::Once]);
    assert_eq!((came, counts.answered), (vec![false, true], 1));
    assert_eq!(counts.bad + counts.late + counts.duplicated, 1);
}
