//! A capture (pcap) in the place of the drives: what the gateway sends is answered as it was then. So a run can be
//! judged again, by other limits or by another version.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use super::{Link, INDEX, NUMBER};
use crate::exit::{Ends, Exit};

const MAGIC: u32 = 0xA1B2_C3D4;
/// The same with times in nanoseconds.
const MAGIC_NS: u32 = 0xA1B2_3C4D;
const FILE_HEAD: usize = 24;
const FRAME_HEAD: usize = 16;
const ETHERNET: u32 = 1;
/// Ethernet type of EtherCAT, and where it stands.
const ETHERCAT: [u8; 2] = [0x88, 0xA4];
const TYPE: std::ops::Range<usize> = 12..14;
/// Bit of the source address that the first device sets.
const ANSWERED: u8 = 0x02;
/// Process data, and the time before it: their content depends on the controller and the clock.
const PROCESS_DATA: u8 = 12;
const TIME: u8 = 14;
/// Registers of the distributed clocks.
const CLOCKS: std::ops::Range<u16> = 0x900..0xA00;
/// A request is looked for among so many that follow: polls may have been more or fewer.
const AHEAD: usize = 20_000;

/// Why a file is no capture that can be judged.
#[derive(Debug)]
pub struct CaptureError {
    file: PathBuf,
    why: CaptureFault,
}

#[derive(Debug)]
pub enum CaptureFault {
    Unreadable(std::io::Error),
    /// Shorter than the head of a capture.
    Short,
    NoPcap,
    LinkType(u32),
    NoRequest,
}

impl std::fmt::Display for CaptureError {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.why)
    }
}

impl Ends for CaptureError {
    fn exit(&self) -> Exit {
        Exit::BadInput
    }
}

impl std::fmt::Display for CaptureFault {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            CaptureFault::Unreadable(why) => write!(f, "{why}: name a capture (pcap) of an earlier run"),
            CaptureFault::Short => f.write_str("no capture: shorter than its head"),
            CaptureFault::NoPcap => f.write_str(
                "no pcap file: save the capture as pcap, for example `tcpdump -w FILE`, or `tshark -F pcap`",
            ),
            CaptureFault::LinkType(kind) => {
                write!(f, "link type {kind}, expected {ETHERNET} (Ethernet): capture the port of the drives")
            }
            CaptureFault::NoRequest => f.write_str(
                "no EtherCAT frame that a gateway sent: capture the port of the drives during a run",
            ),
        }
    }
}

/// A request of the capture, and its reply.
struct Exchange {
    request: Vec<u8>,
    reply: Option<Vec<u8>>,
}

/// Answers from a capture.
pub struct Replay {
    exchanges: VecDeque<Exchange>,
    arriving: VecDeque<Vec<u8>>,
}

impl Replay {
    pub fn open(file: &Path) -> Result<Replay, CaptureError> {
        let capture = std::fs::read(file).map_err(CaptureFault::Unreadable);
        let replay = capture.and_then(|capture| Replay::of(&capture));
        replay.map_err(|why| CaptureError { file: file.to_owned(), why })
    }

    /// From the content of a file, or why it is none.
    pub fn of(capture: &[u8]) -> Result<Replay, CaptureFault> {
        let mut exchanges: VecDeque<Exchange> = VecDeque::new();
        for frame in frames(capture)? {
            if frame.len() <= INDEX || frame[TYPE] != ETHERCAT {
                continue;
            }
            if frame[6] & ANSWERED == 0 {
                exchanges.push_back(Exchange { request: frame.to_vec(), reply: None });
                continue;
            }
            let number = &frame[NUMBER];
            let waiting = exchanges.iter_mut().rev().take(AHEAD);
            if let Some(waiting) = waiting.into_iter().find(|e| e.request[NUMBER] == *number) {
                // of two copies the first
                waiting.reply.get_or_insert_with(|| frame.to_vec());
            }
        }
        match exchanges.is_empty() {
            false => Ok(Replay { exchanges, arriving: VecDeque::new() }),
            true => Err(CaptureFault::NoRequest),
        }
    }

    /// The capture has no more frames.
    #[cfg(test)]
    pub fn is_over(&self) -> bool {
        self.exchanges.is_empty()
    }
}

impl Link for Replay {
    fn send(&mut self, frame: &[u8]) -> bool {
        let place = self.exchanges.iter().take(AHEAD).position(|e| alike(&e.request, frame));
        let Some(place) = place else { return true };
        self.exchanges.drain(..place);
        let kept = self.exchanges.pop_front().and_then(|exchange| exchange.reply);
        if let Some(mut reply) = kept {
            reply[NUMBER].copy_from_slice(&frame[NUMBER]);
            reply[INDEX] = frame[INDEX];
            self.arriving.push_back(reply);
        } else {
            self.arriving.push_back(super::no_reply(frame));
        }
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let reply = self.arriving.pop_front()?;
        let length = reply.len().min(buffer.len());
        buffer[..length].copy_from_slice(&reply[..length]);
        Some(length)
    }

    fn wait(&mut self, _: u64) {}
}

/// The same request: equal commands, addresses and lengths; equal data, too, unless it is process data or a time.
fn alike(one: &[u8], other: &[u8]) -> bool {
    if one.len() != other.len() || one.len() < 26 || one[14..16] != other[14..16] {
        return false;
    }
    let commands = |frame: &[u8]| (frame[16], frame[18..24].to_vec());
    if commands(one) != commands(other) {
        return false;
    }
    let register = u16::from_le_bytes([one[20], one[21]]);
    let varies = [PROCESS_DATA, TIME].contains(&one[16]) || CLOCKS.contains(&register);
    varies || one[26..] == other[26..]
}

/// The frames of a capture.
fn frames(capture: &[u8]) -> Result<Vec<&[u8]>, CaptureFault> {
    let head = capture.get(..FILE_HEAD).ok_or(CaptureFault::Short)?;
    let word = |bytes: &[u8]| [bytes[0], bytes[1], bytes[2], bytes[3]];
    let little = [MAGIC, MAGIC_NS].contains(&u32::from_le_bytes(word(head)));
    let big = [MAGIC, MAGIC_NS].contains(&u32::from_be_bytes(word(head)));
    if !little && !big {
        return Err(CaptureFault::NoPcap);
    }
    let number = |bytes: &[u8]| match little {
        true => u32::from_le_bytes(word(bytes)),
        false => u32::from_be_bytes(word(bytes)),
    };
    if number(&head[20..]) != ETHERNET {
        return Err(CaptureFault::LinkType(number(&head[20..])));
    }
    let (mut at, mut frames) = (FILE_HEAD, Vec::new());
    while let Some(head) = capture.get(at..at + FRAME_HEAD) {
        let length = number(&head[8..]) as usize;
        at += FRAME_HEAD;
        // a capture that was cut short ends here
        let Some(frame) = capture.get(at..at.saturating_add(length)) else { break };
        frames.push(frame);
        at += length;
    }
    Ok(frames)
}

#[cfg(test)]
#[path = "replay_tests.rs"]
mod tests;
#[cfg(test)]
pub use tests::pcap;
