//! The EEPROM behind registers 0x0500 to 0x050F: read 8 bytes, write 2, reload.

const READ: u16 = 1;
const WRITE: u16 = 2;
const RELOAD: u16 = 4;
/// Eight bytes a read, two address bytes.
const FEATURES: u16 = 0x00C0;
const MISSING_ACKNOWLEDGE: u16 = 0x2000;
const WRITE_ERROR: u16 = 0x4000;

#[derive(Debug, Clone)]
pub struct Eeprom {
    pub bytes: Vec<u8>,
}

/// What the registers 0x0502.. show after a command: control/status and, after a read, data.
pub struct Answer {
    pub status: u16,
    pub data: Option<[u8; 8]>,
}

impl Eeprom {
    /// control: as written to 0x0502; address: in words; data: what is to be written.
    pub fn command(&mut self, control: u16, address: u32, data: [u8; 2]) -> Answer {
        let mut answer = Answer { status: FEATURES | control & 1, data: None };
        let place = (address as usize).saturating_mul(2);
        match control >> 8 & 7 {
            0 | RELOAD => {}
            READ if place < self.bytes.len() => {
                let mut read = [0xFF; 8];
                for (byte, stored) in read.iter_mut().zip(&self.bytes[place..]) {
                    *byte = *stored;
                }
                answer.data = Some(read);
            }
            WRITE if control & 1 == 0 => answer.status |= WRITE_ERROR,
            WRITE if place + 1 < self.bytes.len() => {
                self.bytes[place..place + 2].copy_from_slice(&data);
                answer.status &= !1;
            }
            _ => answer.status |= MISSING_ACKNOWLEDGE,
        }
        answer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_eight_bytes_and_pads_at_the_end() {
        let mut eeprom = Eeprom { bytes: (0..12).collect() };
        let answer = eeprom.command(0x0100, 1, [0; 2]);
        assert_eq!(answer.data, Some([2, 3, 4, 5, 6, 7, 8, 9]));
        assert_eq!(answer.status, FEATURES);
        let last = eeprom.command(0x0100, 5, [0; 2]).data.unwrap();
        assert_eq!(last[..3], [10, 11, 0xFF]);
    }

    #[test]
    fn writes_only_when_enabled_and_refuses_what_is_not_there() {
        let mut eeprom = Eeprom { bytes: vec![0; 8] };
        assert_eq!(eeprom.command(0x0200, 1, [1, 2]).status, FEATURES | WRITE_ERROR);
        assert_eq!(eeprom.command(0x0201, 1, [1, 2]).status, FEATURES);
        assert_eq!(eeprom.bytes, [0, 0, 1, 2, 0, 0, 0, 0]);
        let beyond = eeprom.command(0x0100, u32::MAX, [0; 2]);
        assert!(beyond.data.is_none() && beyond.status & MISSING_ACKNOWLEDGE != 0);
        assert!(eeprom.command(0x0700, 0, [0; 2]).status & MISSING_ACKNOWLEDGE != 0);
    }
}
