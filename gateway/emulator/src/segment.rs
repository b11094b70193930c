//! Passes a frame through all SubDevices of the line and back; malformed frames are dropped.
use crate::esc::command::{is_logical, Datagram};
use crate::esc::registers as reg;
use crate::esc::Passage;
use crate::subdevice::SubDevice;
use std::ops::Range;

const ETHERNET: usize = 14;
const HEADER: usize = 10;
/// Ethernet frame without check sequence.
const SHORTEST: usize = 60;
const COUNTER: usize = 2;
const ETHERTYPE: [u8; 2] = [0x88, 0xA4];
/// Time from one SubDevice to the next, and through it [ns].
const HOP_NS: i64 = 680;

/// Where the datagrams of a sound frame lie; each range covers header, data and working counter.
pub fn datagrams(frame: &[u8]) -> Option<Vec<Range<usize>>> {
    if frame.get(12..ETHERNET)? != ETHERTYPE {
        return None;
    }
    let header = word(frame, ETHERNET)?;
    let (length, kind) = (usize::from(header & 0x07FF), header >> 12);
    let end = ETHERNET + 2 + length;
    if kind != 1 || end > frame.len() {
        return None;
    }
    let mut ranges = Vec::with_capacity(4);
    let mut begin = ETHERNET + 2;
    loop {
        let field = word(frame, begin + 6)?;
        let next = begin + HEADER + usize::from(field & 0x07FF) + COUNTER;
        if next > end {
            return None;
        }
        ranges.push(begin..next);
        if field & 0x8000 == 0 {
            return Some(ranges);
        }
        begin = next;
    }
}

/// The frame has logical datagrams: it carries process data.
pub fn is_process_data(frame: &[u8], ranges: &[Range<usize>]) -> bool {
    ranges.iter().any(|range| frame.get(range.start).is_some_and(|command| is_logical(*command)))
}

/// State of the line while a frame passes.
pub struct Line {
    /// SubDevices that are reached; the cable is cut behind them.
    pub reached: usize,
    /// SubDevices that do not take logical datagrams.
    pub bypassed: Vec<usize>,
    /// True time, for clocks and for watchdogs [ns].
    pub dc: i64,
    pub watch: i64,
}

/// Every reached SubDevice takes every datagram, in bus order; the frame is changed in place.
pub fn pass(frame: &mut [u8], ranges: &[Range<usize>], devices: &mut [SubDevice], line: &Line) {
    let reached = line.reached.min(devices.len());
    for (position, device) in devices.iter_mut().take(reached).enumerate() {
        let hops = |count: usize| line.dc + HOP_NS * count as i64;
        device.esc.passage = Passage {
            dc: hops(position),
            dc_back: (position + 1 < reached).then(|| hops(2 * (reached - 1) - position)),
            watch: line.watch,
        };
        let bypassed = line.bypassed.contains(&position);
        for range in ranges {
            if let Some(bytes) = frame.get_mut(range.clone()) {
                execute(bytes, device, bypassed);
            }
        }
    }
    // what the controllers do to every frame that they pass on
    if let Some(source) = frame.get_mut(6) {
        *source |= 0x02;
    }
}

/// Lockstep: says that this frame gets no reply now. An EtherCAT header of the unused type 15.
pub fn no_reply(frame: &[u8]) -> Vec<u8> {
    notice(frame, 0xF000)
}

/// Lockstep: says that so many cycles, at most 2047, went by before this frame. The unused type 14.
pub fn stalled(frame: &[u8], cycles: u64) -> Vec<u8> {
    notice(frame, 0xE000 | cycles.min(0x7FF) as u16)
}

fn notice(frame: &[u8], header: u16) -> Vec<u8> {
    let mut notice: Vec<u8> = frame.iter().copied().take(ETHERNET).collect();
    notice.resize(ETHERNET, 0);
    notice[6] |= 0x02;
    notice.extend(header.to_le_bytes());
    notice.resize(SHORTEST, 0);
    notice
}

fn execute(bytes: &mut [u8], device: &mut SubDevice, bypassed: bool) {
    let Some((header, rest)) = bytes.split_first_chunk_mut::<HEADER>() else {
        return;
    };
    let Some((data, counter)) = rest.split_last_chunk_mut::<COUNTER>() else {
        return;
    };
    if bypassed && is_logical(header[0]) {
        return;
    }
    let mut datagram = Datagram {
        command: header[0],
        position: u16::from_le_bytes([header[2], header[3]]),
        offset: u16::from_le_bytes([header[4], header[5]]),
        counter: u16::from_le_bytes(*counter),
        data,
    };
    device.esc.execute(&mut datagram);
    *counter = datagram.counter.to_le_bytes();
    header[2..4].copy_from_slice(&datagram.position.to_le_bytes());
    device.serve();
}

/// A frame arrives damaged at a port: its device counts it as invalid, and all that it passes afterwards as forwarded,
/// on the way out (port 0) and back (port 1).
pub fn count_damaged(devices: &mut [SubDevice], position: usize, port: u16) {
    let last = devices.len().saturating_sub(1);
    for (k, device) in devices.iter_mut().enumerate() {
        if k == position {
            device.esc.count(reg::INVALID_FRAMES + 2 * port);
            device.esc.count(reg::RECEIVE_ERRORS + 2 * port);
        }
        if port == 0 && k > position {
            device.esc.count(reg::FORWARDED_ERRORS);
        }
        let comes_back = k < last && (port == 0 || k < position);
        if comes_back {
            device.esc.count(reg::FORWARDED_ERRORS + 1);
        }
    }
}

/// DL status and lost-link counters as the cable stands now.
pub fn show_links(devices: &mut [SubDevice], reached: usize) {
    let count = devices.len();
    for (position, device) in devices.iter_mut().enumerate() {
        let next = position + 1 < count && position + 1 != reached;
        let before = position == 0 || position != reached;
        // PDI runs; per port: link (bit 4 + p), loop closed (8 + 2p), communication (9 + 2p)
        let port = |p: u16, on: bool| {
            if on {
                1 << (4 + p) | 2 << (8 + 2 * p)
            } else {
                1 << (8 + 2 * p)
            }
        };
        let status = 1 | port(0, before) | port(1, next) | port(2, false) | port(3, false);
        let old = device.esc.get16(reg::DL_STATUS);
        for p in 0..2 {
            if old & !status & 1 << (4 + p) != 0 {
                device.esc.count(reg::LOST_LINK + p);
            }
        }
        device.esc.put16(reg::DL_STATUS, status);
    }
}

fn word(frame: &[u8], place: usize) -> Option<u16> {
    Some(u16::from_le_bytes([*frame.get(place)?, *frame.get(place + 1)?]))
}

#[cfg(test)]
#[path = "segment_tests.rs"]
pub mod tests;
