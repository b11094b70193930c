//! Sync managers: who may touch which memory, full and empty mailboxes.

/// The eight bytes at 0x0800 + 8 i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SyncManager {
    pub start: u16,
    pub length: u16,
    pub control: u8,
    pub status: u8,
    pub activate: u8,
}

pub const FULL: u8 = 0x08;
/// Bit of the control byte: the buffer's last byte triggers the watchdog.
pub const WATCHDOG_TRIGGER: u8 = 0x40;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    Read,
    Write,
}

impl SyncManager {
    pub fn parse(bytes: &[u8]) -> SyncManager {
        let byte = |i: usize| bytes.get(i).copied().unwrap_or(0);
        SyncManager {
            start: u16::from_le_bytes([byte(0), byte(1)]),
            length: u16::from_le_bytes([byte(2), byte(3)]),
            control: byte(4),
            status: byte(5),
            activate: byte(6),
        }
    }

    pub fn enabled(&self) -> bool {
        self.activate & 1 == 1 && self.length > 0
    }

    pub fn is_mailbox(&self) -> bool {
        self.control & 3 == 2
    }

    /// What the MainDevice does with it.
    pub fn direction(&self) -> Access {
        if self.control & 0x0C == 0x04 {
            Access::Write
        } else {
            Access::Read
        }
    }

    pub fn triggers_watchdog(&self) -> bool {
        self.control & WATCHDOG_TRIGGER != 0
    }

    fn end(&self) -> u32 {
        u32::from(self.start) + u32::from(self.length)
    }

    pub fn overlaps(&self, address: u16, length: usize) -> bool {
        let end = u32::from(address) + length as u32;
        u32::from(address) < self.end() && u32::from(self.start) < end
    }

    pub fn covers_last(&self, address: u16, length: usize) -> bool {
        let last = self.end() - 1;
        (u32::from(address)..u32::from(address) + length as u32).contains(&last)
    }

    /// May the MainDevice do this now? A mailbox must be taken from its first byte on.
    pub fn allows(&self, access: Access, address: u16) -> bool {
        if self.direction() != access {
            return false;
        }
        if !self.is_mailbox() {
            return true;
        }
        let full = self.status & FULL != 0;
        address <= self.start && full == (access == Access::Read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mailbox(control: u8, status: u8) -> SyncManager {
        let mut bytes = [0, 0x10, 0x80, 0, control, status, 1, 0];
        bytes[4] = control;
        SyncManager::parse(&bytes)
    }

    #[test]
    fn a_full_mailbox_takes_nothing_and_an_empty_one_gives_nothing() {
        assert!(mailbox(0x26, 0).allows(Access::Write, 0x1000));
        assert!(!mailbox(0x26, FULL).allows(Access::Write, 0x1000));
        assert!(!mailbox(0x22, 0).allows(Access::Read, 0x1000));
        assert!(mailbox(0x22, FULL).allows(Access::Read, 0x1000));
    }

    #[test]
    fn the_wrong_direction_and_a_start_in_the_middle_are_refused() {
        assert!(!mailbox(0x22, 0).allows(Access::Write, 0x1000));
        assert!(!mailbox(0x26, 0).allows(Access::Write, 0x1001));
        assert!(SyncManager::parse(&[0, 0x18, 8, 0, 0x64, 0, 1]).allows(Access::Write, 0x1804));
    }

    #[test]
    fn the_last_byte_completes_a_buffer() {
        let sm = mailbox(0x26, 0);
        assert!(sm.covers_last(0x1000, 0x80) && sm.covers_last(0x107F, 1));
        assert!(!sm.covers_last(0x1000, 0x7F) && !sm.covers_last(0x1080, 4));
        assert!(!sm.overlaps(0x1080, 4) && sm.overlaps(0x0FFF, 2));
    }
}
