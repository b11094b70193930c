//! The SubDevice controller: registers, memory and what happens when they are read or written.
pub mod clock;
pub mod command;
pub mod eeprom;
pub mod fmmu;
pub mod registers;
pub mod state;
pub mod sync_manager;
pub mod watchdog;

use clock::Clock;
use eeprom::Eeprom;
use fmmu::Fmmu;
use registers as reg;
use sync_manager::{Access, SyncManager, FULL};
use watchdog::Watchdog;

/// When a frame passes [ns]: `dc` for the clocks (at this SubDevice's ports), `watch` for watchdogs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Passage {
    pub dc: i64,
    /// When the frame comes back; None for the last SubDevice.
    pub dc_back: Option<i64>,
    pub watch: i64,
}

pub struct Esc {
    memory: Vec<u8>,
    pub clock: Clock,
    pub eeprom: Eeprom,
    pub watchdog: Watchdog,
    pub passage: Passage,
    /// Sync managers 2 and up are open to the MainDevice (from SAFE-OP on).
    pub process_data_open: bool,
    /// AL control was written since the application looked.
    pub al_control: Option<u16>,
    /// The last byte of the mailbox was written.
    pub mailbox_written: bool,
    /// The last byte of the outputs was written.
    pub outputs_written: bool,
}

impl Esc {
    pub fn new(eeprom: Vec<u8>, clock: Clock) -> Esc {
        let mut esc = Esc {
            memory: vec![0; usize::from(reg::RAM.end)],
            clock,
            eeprom: Eeprom { bytes: eeprom },
            watchdog: Watchdog::default(),
            passage: Passage::default(),
            process_data_open: false,
            al_control: None,
            mailbox_written: false,
            outputs_written: false,
        };
        esc.put(0, &reg::INFORMATION);
        let alias = [8, 9].map(|i| esc.eeprom.bytes.get(i).copied().unwrap_or(0));
        esc.put(reg::STATION_ALIAS, &alias);
        esc.put(reg::DL_CONTROL, &[1, 0, 0, 0]);
        esc.put(reg::AL_CONTROL, &[1, 0]);
        esc.put16(reg::WATCHDOG_DIVIDER, watchdog::DIVIDER);
        esc.put16(reg::WATCHDOG_PDI, watchdog::TICKS);
        esc.put16(reg::WATCHDOG_PROCESS, watchdog::TICKS);
        esc.put16(reg::EEPROM_CONTROL, 0x00C0);
        esc.put16(reg::SPEED_START, 0x1000);
        esc.put16(reg::FILTER_DEPTHS, 0x0C04);
        esc
    }

    /// The application's side: no sync manager stands in the way. Short where memory ends.
    pub fn get(&self, address: u16, length: usize) -> &[u8] {
        let begin = usize::from(address).min(self.memory.len());
        &self.memory[begin..(begin + length).min(self.memory.len())]
    }

    pub fn put(&mut self, address: u16, bytes: &[u8]) {
        for (place, byte) in self.memory.iter_mut().skip(usize::from(address)).zip(bytes) {
            *place = *byte;
        }
    }

    pub fn get16(&self, address: u16) -> u16 {
        let bytes = self.get(address, 2);
        u16::from_le_bytes([
            bytes.first().copied().unwrap_or(0),
            bytes.get(1).copied().unwrap_or(0),
        ])
    }

    pub fn put16(&mut self, address: u16, value: u16) {
        self.put(address, &value.to_le_bytes());
    }

    pub fn get32(&self, address: u16) -> u32 {
        u32::from(self.get16(address)) | u32::from(self.get16(address.wrapping_add(2))) << 16
    }

    pub fn sm(&self, index: usize) -> SyncManager {
        SyncManager::parse(self.get(reg::SM + 8 * index as u16, 8))
    }

    pub fn fmmu(&self, index: usize) -> Fmmu {
        Fmmu::parse(self.get(reg::FMMU + 16 * index as u16, 16))
    }

    /// Shows a mailbox (or its repetition) as full or empty.
    pub fn set_full(&mut self, index: usize, full: bool) {
        let address = reg::SM + 8 * index as u16 + 5;
        self.put(address, &[if full { FULL } else { 0 }]);
    }

    /// `[ns]` of the process-data watchdog as configured.
    pub fn watchdog_period(&self) -> i64 {
        watchdog::period(self.get16(reg::WATCHDOG_DIVIDER), self.get16(reg::WATCHDOG_PROCESS))
    }

    /// How long ago the newest SYNC0 was at this time of the world [ns]; None: there is none, or it
    /// has another cycle.
    pub fn since_sync0(&self, now: i64, cycle: i64) -> Option<i64> {
        let active = self.get16(reg::SYNC_ACTIVATION) & 3 == 3;
        let begun = i64::from_le_bytes(self.get(reg::SYNC0_START, 8).try_into().ok()?);
        let fits = active && i64::from(self.get32(reg::SYNC0_CYCLE)) == cycle;
        fits.then(|| self.clock.system(now).wrapping_sub(begun).rem_euclid(cycle))
    }

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

    /// Registers that live are brought up to date before they are read.
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
            let difference = self.clock.difference_register();
            self.put(reg::TIME_DIFFERENCE, &difference.to_le_bytes());
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
                if sm.triggers_watchdog() {
                    self.watchdog.trigger(self.passage.watch);
                }
            }
        }
    }
}
