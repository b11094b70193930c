//! What happened, as events: changes of states, faults, the end.
use super::seen::{states, Extremes};
use super::Machine;
use crate::error::Error;
use crate::event::{Event, EventKind};

impl Machine {
    pub fn record(&mut self, what: EventKind) {
        self.events.push(Event { cycle: self.cycle, frame: self.frames, what });
    }

    /// Records an event for each state that has changed.
    pub(super) fn record_changes(&mut self) {
        for position in 0..self.devices.len() {
            if self.devices[position].drive_mut().parameters.take_stored() {
                self.record(EventKind::Stored { position });
            }
            let device = &self.devices[position];
            let (now, before) = (states(device), self.seen[position]);
            if now == before {
                continue;
            }
            let (code, error) = (device.layer.code, device.drive().machine.error);
            self.seen[position] = now;
            if now.layer != before.layer {
                let (from, to) = (before.layer, now.layer);
                self.record(EventKind::State { position, from, to, code });
            }
            if now.drive != before.drive {
                let (from, to) = (before.drive, now.drive);
                self.record(EventKind::Drive { position, from, to, error });
            }
        }
    }

    pub fn stop(&mut self) -> Result<(), Error> {
        let names = self.faults.iter().map(|fault| fault.kind.name());
        let faults = names.zip(self.counts.iter().copied()).collect();
        let digest = self.trajectory.finish()?;
        let (frames, dropped) = (self.frames, self.dropped);
        let drives = self.devices.iter().map(|device| states(device).drive).collect();
        let Extremes { fastest, farthest, .. } = self.extremes;
        self.record(EventKind::Stopped {
            digest,
            frames,
            dropped,
            faults,
            drives,
            fastest,
            farthest,
        });
        Ok(())
    }
}
