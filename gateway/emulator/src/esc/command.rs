//! Datagram commands: addressing, reads and writes, working counter.
use super::fmmu::{copy_bits, Overlap};
use super::registers as reg;
use super::Esc;

/// One datagram of a frame; header fields by value, written back by the caller.
pub struct Datagram<'a> {
    pub command: u8,
    pub position: u16,
    pub offset: u16,
    pub counter: u16,
    pub data: &'a mut [u8],
}

/// Longest data of one datagram: eleven bits.
const LONGEST: usize = 2047;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Action {
    Nothing,
    Read,
    Write,
    ReadWrite,
    /// Broadcast: what is read is OR-ed into the data.
    ReadOr,
    ReadWriteOr,
}

/// Commands 10 to 12: LRD, LWR, LRW.
pub fn is_logical(command: u8) -> bool {
    (10..=12).contains(&command)
}

impl Esc {
    pub fn execute(&mut self, datagram: &mut Datagram<'_>) {
        if is_logical(datagram.command) {
            return self.logical(datagram);
        }
        let action = self.action(datagram);
        if let 1..=3 | 7..=9 | 13 = datagram.command {
            datagram.position = datagram.position.wrapping_add(1);
        }
        let added = self.physical(action, datagram.offset, datagram.data);
        datagram.counter = datagram.counter.wrapping_add(added);
    }

    fn action(&self, datagram: &Datagram<'_>) -> Action {
        let first = datagram.position == 0;
        let mine = self.is_addressed(datagram.position);
        match (datagram.command, first, mine) {
            (1, true, _) | (4, _, true) => Action::Read,
            (2, true, _) | (5, _, true) => Action::Write,
            (3, true, _) | (6, _, true) => Action::ReadWrite,
            (7, ..) => Action::ReadOr,
            (8, ..) => Action::Write,
            (9, ..) => Action::ReadWriteOr,
            (13, true, _) | (14, _, true) => Action::Read,
            (13, false, _) | (14, _, false) => Action::Write,
            _ => Action::Nothing,
        }
    }

    /// Station address, or the alias where DL control says so.
    fn is_addressed(&self, address: u16) -> bool {
        let by_alias = self.get32(reg::DL_CONTROL) & 1 << 24 != 0;
        address == self.get16(reg::STATION_ADDRESS)
            || by_alias && address == self.get16(reg::STATION_ALIAS)
    }

    fn physical(&mut self, action: Action, address: u16, data: &mut [u8]) -> u16 {
        let mut buffer = [0; LONGEST];
        let Some(old) = buffer.get_mut(..data.len()) else {
            return 0;
        };
        let reads = !matches!(action, Action::Nothing | Action::Write);
        let writes = matches!(action, Action::Write | Action::ReadWrite | Action::ReadWriteOr);
        let read = reads && self.read(address, old);
        let wrote = writes && self.write(address, data);
        if read {
            for (byte, old) in data.iter_mut().zip(old) {
                let is_or = matches!(action, Action::ReadOr | Action::ReadWriteOr);
                *byte = if is_or { *byte | *old } else { *old };
            }
        }
        let both = matches!(action, Action::ReadWrite | Action::ReadWriteOr);
        u16::from(read) + u16::from(wrote) * if both { 2 } else { 1 }
    }

    fn logical(&mut self, datagram: &mut Datagram<'_>) {
        let logical = u32::from(datagram.offset) << 16 | u32::from(datagram.position);
        let (may_read, may_write) = (datagram.command != 11, datagram.command != 10);
        let mut buffer = [0; LONGEST];
        let Some(sent) = buffer.get_mut(..datagram.data.len()) else {
            return;
        };
        sent.copy_from_slice(datagram.data);
        let (mut read, mut wrote) = (false, false);
        for index in 0..reg::FMMUS {
            let unit = self.fmmu(index);
            let Some(overlap) = unit.overlap(logical, sent.len()) else {
                continue;
            };
            if may_read && unit.reads {
                read |= self.logical_read(overlap, datagram.data);
            }
            if may_write && unit.writes {
                wrote |= self.logical_write(overlap, sent);
            }
        }
        let weight = if datagram.command == 12 { 2 } else { 1 };
        let added = u16::from(read) + u16::from(wrote) * weight;
        datagram.counter = datagram.counter.wrapping_add(added);
    }

    fn logical_read(&mut self, overlap: Overlap, data: &mut [u8]) -> bool {
        let mut buffer = [0; LONGEST + 1];
        let Some(bytes) = buffer.get_mut(..overlap.bytes()) else {
            return false;
        };
        if !self.read(overlap.address, bytes) {
            return false;
        }
        if overlap.whole_bytes() {
            let begin = overlap.data_bit / 8;
            data[begin..begin + bytes.len()].copy_from_slice(bytes);
        } else {
            copy_bits(bytes, usize::from(overlap.bit), data, overlap.data_bit, overlap.bits);
        }
        true
    }

    fn logical_write(&mut self, overlap: Overlap, data: &[u8]) -> bool {
        if overlap.whole_bytes() {
            let begin = overlap.data_bit / 8;
            return self.write(overlap.address, &data[begin..begin + overlap.bytes()]);
        }
        let mut buffer = [0; LONGEST + 1];
        let length = overlap.bytes();
        let kept = self.get(overlap.address, length);
        if kept.len() != length || length > buffer.len() {
            return false;
        }
        buffer[..length].copy_from_slice(kept);
        let bytes = &mut buffer[..length];
        copy_bits(data, overlap.data_bit, bytes, usize::from(overlap.bit), overlap.bits);
        self.write(overlap.address, &buffer[..length])
    }
}
