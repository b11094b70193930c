//! A million spoiled replies: bits turned, bytes replaced, cut, lengthened, or nothing but noise.

use ethercrab::{Command, MainDevice, MainDeviceConfig, PduStorage, Timeouts};
use std::collections::VecDeque;
use std::time::Duration;

use super::{Link, Wire, LARGEST};
use crate::realtime::now_ns;

const REPLIES: usize = 1_000_000;
const PER_FRAME: usize = 20;

/// Always the same numbers [Steele et al. 2014, SplitMix64].
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) % n as u64) as usize
    }

    fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }
}

/// A device whose every reply is spoiled.
struct Noise {
    random: Random,
    arriving: VecDeque<Vec<u8>>,
    replies: usize,
}

impl Noise {
    fn spoiled(&mut self, frame: &[u8]) -> Vec<u8> {
        let random = &mut self.random;
        let mut reply = frame.to_vec();
        reply[6] |= 0x02;
        for _ in 0..=random.below(4) {
            let at = random.below(reply.len().max(1));
            match random.below(6) {
                0 => reply.truncate(at),
                1 => reply.extend((0..random.below(1200)).map(|k| k as u8)),
                2 => reply = (0..random.below(LARGEST)).map(|_| random.byte()).collect(),
                // lengths and flags of the datagrams
                3 if reply.len() > 26 => reply[14 + random.below(12)] = random.byte(),
                _ if !reply.is_empty() => {
                    let at = at.min(reply.len() - 1);
                    reply[at] ^= 1 << random.below(8);
                }
                _ => {}
            }
        }
        reply.truncate(LARGEST);
        reply
    }
}

impl Link for Noise {
    fn send(&mut self, frame: &[u8]) -> bool {
        for _ in 0..PER_FRAME {
            let reply = self.spoiled(frame);
            self.arriving.push_back(reply);
        }
        self.replies += PER_FRAME;
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let frame = self.arriving.pop_front()?;
        buffer[..frame.len()].copy_from_slice(&frame);
        Some(frame.len())
    }

    fn wait(&mut self, _: u64) {}
}

#[test]
fn a_million_spoiled_replies_cause_no_panic() {
    let storage: &'static PduStorage<4, { PduStorage::element_size(64) }> =
        Box::leak(Box::new(PduStorage::new()));
    let (tx, rx, pdu_loop) = storage.try_split().unwrap();
    let patient = Timeouts { pdu: Duration::from_secs(600), ..Timeouts::default() };
    let main: &'static MainDevice =
        Box::leak(Box::new(MainDevice::new(pdu_loop, patient, MainDeviceConfig::default())));
    let noise = Noise { random: Random(1), arriving: VecDeque::new(), replies: 0 };
    let mut wire = Wire::new(noise, tx, rx);
    let mut taken = 0;
    while wire.link.replies < REPLIES {
        let read = Command::fprd(0x1000, 0x0130).receive::<[u8; 8]>(main);
        taken += u64::from(wire.drive(read, now_ns()).is_some());
    }
    let c = wire.counts;
    assert_eq!(c.answered + c.duplicated + c.late + c.bad, REPLIES as u64, "{c:?}");
    assert!(c.answered > 0 && c.duplicated > 0 && c.bad > 0 && taken > 0, "{c:?}");
}
