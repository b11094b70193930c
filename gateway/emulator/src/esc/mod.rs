//! The EtherCAT SubDevice controller: registers, memory and the effects of reads and writes.
mod access;
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
use sync_manager::{SyncManager, FULL};
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
    /// The outputs' sync manager never triggers the watchdog, whatever is written.
    pub trigger_fixed: bool,
    /// Outputs never trigger the watchdog, whatever the sync manager says.
    pub watchdog_dead: bool,
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
            trigger_fixed: false,
            watchdog_dead: false,
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

    /// One more in an error counter; all of them stop at 255.
    pub fn count(&mut self, counter: u16) {
        let one_more = self.get(counter, 1).first().map(|count| count.saturating_add(1));
        self.put(counter, one_more.as_slice());
    }

    /// Shows a mailbox (or its repetition) as full or empty.
    pub fn set_full(&mut self, index: usize, full: bool) {
        let address = reg::SM + 8 * index as u16 + 5;
        self.put(address, &[if full { FULL } else { 0 }]);
    }

    pub fn is_full(&self, index: usize) -> bool {
        self.get(reg::SM + 8 * index as u16 + 5, 1) == [FULL]
    }

    /// `[ns]` of the process-data watchdog as configured.
    pub fn watchdog_period(&self) -> i64 {
        watchdog::period(self.get16(reg::WATCHDOG_DIVIDER), self.get16(reg::WATCHDOG_PROCESS))
    }

    /// How long ago the newest SYNC0 was at this true time [ns]; None: there is none, or it
    /// has another cycle.
    pub fn since_sync0(&self, now: i64, cycle: i64) -> Option<i64> {
        let active = self.get16(reg::SYNC_ACTIVATION) & 3 == 3;
        let begun = i64::from_le_bytes(self.get(reg::SYNC0_START, 8).try_into().ok()?);
        let fits = active && i64::from(self.get32(reg::SYNC0_CYCLE)) == cycle;
        fits.then(|| self.clock.system(now).wrapping_sub(begun).rem_euclid(cycle))
    }
}
