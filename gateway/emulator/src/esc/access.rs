//! Reads and writes by the MainDevice, and their effects.
use super::registers as reg;
use super::sync_manager::{Access, SyncManager, WATCHDOG_TRIGGER};
use super::Esc;

impl Esc {
    /// The MainDevice reads; false: nothing was read and the working counter stays.
    pub fn read(&mut self, address: u16, data: &mut [u8]) -> bool {
        if !self.inside(address, data.len()) || !self.allowed(Access::Read, address, data.len()) {
            return false;
        }
        self.refresh(address, data.len());
        data.copy_from_slice(self.get(address, data.len()));
        for index in 0..reg::SMS {
            let sm = self.sm(index);
            if self.completes(&sm, Access::Read, address, data.len()) && sm.is_mailbox() {
                self.set_full(index, false);
            }
        }
        true
    }

    /// The MainDevice writes; false: nothing was written.
    pub fn write(&mut self, address: u16, data: &[u8]) -> bool {
        if !self.inside(address, data.len()) || !self.allowed(Access::Write, address, data.len()) {
            return false;
        }
        let mut any = false;
        for (place, byte) in (address..).zip(data) {
            if reg::writable(place) {
                self.memory[usize::from(place)] = *byte;
                any = true;
            }
        }
        if any {
            self.written(address, data);
        }
        any
    }

    fn inside(&self, address: u16, length: usize) -> bool {
        length > 0 && usize::from(address) + length <= self.memory.len()
    }

    fn allowed(&self, access: Access, address: u16, length: usize) -> bool {
        (0..reg::SMS).all(|index| {
            let sm = self.sm(index);
            let touched = sm.enabled() && sm.overlaps(address, length);
            let open = index < 2 || self.process_data_open;
            !touched || open && sm.allows(access, address)
        })
    }

    fn completes(&self, sm: &SyncManager, access: Access, address: u16, length: usize) -> bool {
        sm.enabled() && sm.direction() == access && sm.covers_last(address, length)
    }

    /// Updates registers that change by themselves before they are read.
    fn refresh(&mut self, address: u16, length: usize) {
        let touches = |register: u16, size: u16| {
            let end = usize::from(address) + length;
            usize::from(register) < end && address < register + size
        };
        if touches(reg::SYSTEM_TIME, 8) {
            let time = self.clock.system(self.passage.dc);
            self.put(reg::SYSTEM_TIME, &time.to_le_bytes());
        }
        if touches(reg::WATCHDOG_STATUS, 2) {
            let alive = self.watchdog.alive() || self.watchdog_period() == 0;
            self.put16(reg::WATCHDOG_STATUS, u16::from(alive));
        }
    }

    fn written(&mut self, address: u16, data: &[u8]) {
        let range = usize::from(address)..usize::from(address) + data.len();
        let wrote = |register: u16| range.contains(&usize::from(register));
        if wrote(reg::AL_CONTROL) {
            self.al_control = Some(self.get16(reg::AL_CONTROL));
        }
        if wrote(reg::EEPROM_CONTROL + 1) {
            self.eeprom_command();
        }
        let outputs = reg::SM + 2 * 8 + 4;
        if self.trigger_fixed && wrote(outputs) {
            let control = self.get(outputs, 1)[0];
            self.put(outputs, &[control & !WATCHDOG_TRIGGER]);
        }
        for index in 0..reg::SMS {
            if wrote(reg::SM + 8 * index as u16 + 6) && !self.sm(index).enabled() {
                self.set_full(index, false);
            }
        }
        self.clock_written(&wrote);
        self.buffers_written(address, data.len());
    }

    fn eeprom_command(&mut self) {
        let control = self.get16(reg::EEPROM_CONTROL);
        let address = self.get32(reg::EEPROM_CONTROL + 2);
        let data = self.get16(reg::EEPROM_CONTROL + 6).to_le_bytes();
        let answer = self.eeprom.command(control, address, data);
        self.put16(reg::EEPROM_CONTROL, answer.status);
        if let Some(data) = answer.data {
            self.put(reg::EEPROM_CONTROL + 6, &data);
        }
    }

    fn clock_written(&mut self, wrote: &dyn Fn(u16) -> bool) {
        let now = self.passage.dc;
        if wrote(reg::RECEIVE_TIME) {
            let there = self.clock.local(now);
            self.put(reg::RECEIVE_TIME, &(there as u32).to_le_bytes());
            let back = self.passage.dc_back.map_or(0, |time| self.clock.local(time) as u32);
            self.put(reg::RECEIVE_TIME + 4, &back.to_le_bytes());
            self.put(reg::RECEIVE_TIME_ECAT, &there.to_le_bytes());
        }
        if wrote(reg::SYSTEM_TIME) {
            self.clock.control(now, self.get32(reg::SYSTEM_TIME));
        }
        if wrote(reg::TIME_OFFSET) || wrote(reg::TIME_DELAY) {
            let low = u64::from(self.get32(reg::TIME_OFFSET));
            let high = u64::from(self.get32(reg::TIME_OFFSET + 4));
            self.clock.offset = (high << 32 | low) as i64;
            self.clock.delay = self.get32(reg::TIME_DELAY);
        }
        if wrote(reg::SPEED_START) {
            self.clock.restart(now);
        }
        let difference = self.clock.difference_register();
        self.put(reg::TIME_DIFFERENCE, &difference.to_le_bytes());
    }

    fn buffers_written(&mut self, address: u16, length: usize) {
        for index in 0..reg::SMS {
            let sm = self.sm(index);
            if !self.completes(&sm, Access::Write, address, length) {
                continue;
            }
            if sm.is_mailbox() {
                self.set_full(index, true);
                self.mailbox_written |= index == 0;
            } else if index == 2 {
                self.outputs_written = true;
                if sm.triggers_watchdog() && !self.watchdog_dead {
                    self.watchdog.trigger(self.passage.watch);
                }
            }
        }
    }
}
