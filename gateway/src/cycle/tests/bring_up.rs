//! Replies of a bring-up in which bytes are not what the devices said: registers, EEPROMs, mailboxes. No panic, and
//! an end within the time-outs.

use flexhex_emulator::Loopback;
use std::collections::VecDeque;
use std::time::Duration;

use super::rig::{config, ssp};
use crate::bus::{bring_up, inspect, Ask, BringUpOptions, Lists};
use crate::config::AXES;
use crate::wire::Link;

/// Replies without FLEXHEX_REPLIES, which names another number; FLEXHEX_DRAW draws others.
const REPLIES: u64 = 1_000_000;
/// Bytes of a frame that say which one it is and how long its parts are: `wire/fuzz_tests.rs` spoils these.
const HEAD: usize = 26;

fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().unwrap())
}

/// Always the same numbers [Steele et al. 2014, SplitMix64].
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ z >> 31) % n
    }
}

/// Emulated drives of whose replies one in `every` is spoiled.
struct Spoiled {
    line: Loopback,
    arriving: VecDeque<Vec<u8>>,
    random: Random,
    every: u64,
    replies: u64,
    spoiled: u64,
}

impl Link for &mut Spoiled {
    fn send(&mut self, frame: &[u8]) -> bool {
        for mut reply in self.line.answer(frame).unwrap() {
            self.replies += 1;
            if reply.len() > HEAD && self.random.below(self.every) == 0 {
                self.spoiled += 1;
                for _ in 0..=self.random.below(8) {
                    let at = HEAD + self.random.below((reply.len() - HEAD) as u64) as usize;
                    reply[at] = self.random.below(256) as u8;
                }
            }
            self.arriving.push_back(reply);
        }
        true
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let reply = self.arriving.pop_front()?;
        buffer[..reply.len()].copy_from_slice(&reply);
        Some(reply.len())
    }

    fn wait(&mut self, _: u64) {}
}

#[test]
fn spoiled_replies_in_a_bring_up_cause_no_panic() {
    let mut config = config();
    // what never comes is waited for that long
    config.bus.state_timeout_ms = 2;
    let text = format!("plant.system = {:?}", ssp().display().to_string());
    let random = Random(number("FLEXHEX_DRAW", 1));
    let line = Loopback::open(&toml::from_str(&text).unwrap()).unwrap();
    let arriving = VecDeque::new();
    let mut link = Spoiled { line, arriving, random, every: 1, replies: 0, spoiled: 0 };
    let (cycle, lockstep, reset_faults) = (Duration::from_micros(250), true, true);
    let options = BringUpOptions { cycle, lockstep, reset_faults, replayed: false, cyclic: true };
    let (mut rounds, mut failed) = (0_u64, 0_u64);
    while link.replies < number("FLEXHEX_REPLIES", REPLIES) {
        link.every = [10, 100, 1000, 10_000][link.random.below(4) as usize];
        link.arriving.clear();
        rounds += 1;
        let ended = if rounds % 2 == 0 {
            bring_up(&config, &mut link, options, &mut |_| ())
                .map(|bus| drop(bus.leave(Ask::default(), &[true; AXES])))
        } else {
            inspect(&config, &mut link, options, Lists::Write, &mut |_, _| ()).map(drop)
        };
        failed += u64::from(ended.is_err_and(|why| !why.to_string().is_empty()));
    }
    println!("{rounds} bring-ups, {failed} refused, {} replies spoiled", link.spoiled);
    assert!(failed > 0 && failed < rounds && link.spoiled > 0);
}
