//! Field bus memory management units: logical addresses to physical ones, bit by bit.

/// The sixteen bytes at 0x0600 + 16 i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fmmu {
    logical: u32,
    length: u16,
    first_bit: u8,
    last_bit: u8,
    physical: u16,
    physical_bit: u8,
    pub reads: bool,
    pub writes: bool,
    pub active: bool,
}

/// Where a datagram and an FMMU meet: from bit `data_bit` of the datagram on, `bits` bits lie at
/// bit `bit` of physical `address`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    pub data_bit: usize,
    pub address: u16,
    pub bit: u8,
    pub bits: usize,
}

impl Fmmu {
    pub fn parse(bytes: &[u8]) -> Fmmu {
        let byte = |i: usize| bytes.get(i).copied().unwrap_or(0);
        Fmmu {
            logical: u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]),
            length: u16::from_le_bytes([byte(4), byte(5)]),
            first_bit: byte(6) & 7,
            last_bit: byte(7) & 7,
            physical: u16::from_le_bytes([byte(8), byte(9)]),
            physical_bit: byte(10) & 7,
            reads: byte(11) & 1 != 0,
            writes: byte(11) & 2 != 0,
            active: byte(12) & 1 != 0,
        }
    }

    /// None where the datagram [logical, logical + length) and the mapped bits do not meet.
    pub fn overlap(&self, logical: u32, length: usize) -> Option<Overlap> {
        if !self.active || self.length == 0 {
            return None;
        }
        let begin = u64::from(self.logical) * 8 + u64::from(self.first_bit);
        let end = (u64::from(self.logical) + u64::from(self.length) - 1) * 8
            + u64::from(self.last_bit)
            + 1;
        let from = begin.max(u64::from(logical) * 8);
        let to = end.min((u64::from(logical) + length as u64) * 8);
        if from >= to {
            return None;
        }
        let place = u64::from(self.physical) * 8 + u64::from(self.physical_bit) + (from - begin);
        Some(Overlap {
            data_bit: (from - u64::from(logical) * 8) as usize,
            address: u16::try_from(place / 8).ok()?,
            bit: (place % 8) as u8,
            bits: (to - from) as usize,
        })
    }
}

impl Overlap {
    /// Physical bytes that are touched.
    pub fn bytes(&self) -> usize {
        (usize::from(self.bit) + self.bits).div_ceil(8)
    }

    pub fn whole_bytes(&self) -> bool {
        self.bit == 0 && self.data_bit.is_multiple_of(8) && self.bits.is_multiple_of(8)
    }
}

/// Copies `count` bits between byte strings; both must be long enough (the caller cuts them so).
pub fn copy_bits(from: &[u8], from_bit: usize, to: &mut [u8], to_bit: usize, count: usize) {
    for i in 0..count {
        let (source, target) = (from_bit + i, to_bit + i);
        let Some(byte) = from.get(source / 8) else {
            return;
        };
        let value = byte >> (source % 8) & 1;
        if let Some(place) = to.get_mut(target / 8) {
            *place = *place & !(1 << (target % 8)) | value << (target % 8);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fmmu(logical: u32, length: u16, bits: (u8, u8), physical: u16, bit: u8) -> Fmmu {
        let mut bytes = [0; 16];
        bytes[..4].copy_from_slice(&logical.to_le_bytes());
        bytes[4..6].copy_from_slice(&length.to_le_bytes());
        (bytes[6], bytes[7]) = bits;
        bytes[8..10].copy_from_slice(&physical.to_le_bytes());
        (bytes[10], bytes[11], bytes[12]) = (bit, 1, 1);
        Fmmu::parse(&bytes)
    }

    #[test]
    fn whole_bytes_are_found_inside_a_datagram() {
        let hit = fmmu(0x10008, 8, (0, 7), 0x1800, 0).overlap(0x10000, 32);
        let wanted = Overlap { data_bit: 64, address: 0x1800, bit: 0, bits: 64 };
        assert_eq!(hit, Some(wanted));
        assert!(wanted.whole_bytes());
    }

    #[test]
    fn a_datagram_that_begins_inside_finds_the_later_bytes() {
        let hit = fmmu(0x10000, 8, (0, 7), 0x1800, 0).overlap(0x10003, 2);
        assert_eq!(hit, Some(Overlap { data_bit: 0, address: 0x1803, bit: 0, bits: 16 }));
    }

    #[test]
    fn single_bits_move_to_their_place() {
        // logical bits 3..=4 of byte 1 lie at bits 6..=7 of physical 0x1A00
        let hit = fmmu(1, 1, (3, 4), 0x1A00, 6).overlap(0, 2).unwrap();
        assert_eq!(hit, Overlap { data_bit: 11, address: 0x1A00, bit: 6, bits: 2 });
        let mut data = [0xFF, 0x00];
        copy_bits(&[0b1000_0000], 6, &mut data, hit.data_bit, hit.bits);
        assert_eq!(data, [0xFF, 0b0001_0000]);
    }

    #[test]
    fn neighbours_and_inactive_ones_do_not_meet() {
        let mut unit = fmmu(0x10008, 8, (0, 7), 0x1800, 0);
        assert_eq!(unit.overlap(0x10000, 8), None);
        assert_eq!(unit.overlap(0x10010, 8), None);
        unit.active = false;
        assert_eq!(unit.overlap(0x10008, 8), None);
        assert_eq!(fmmu(u32::MAX, 8, (0, 7), 0xFFFF, 0).overlap(5, 1), None);
    }
}
