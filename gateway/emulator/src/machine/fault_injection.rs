//! Applies the faults of the options file to drives, cable and replies.
use super::Machine;
use crate::error::Error;
use crate::esc::registers as reg;
use crate::esc::state::code;
use crate::event::EventKind;
use crate::faults::{Counting, Fault, FaultKind, LossTime};
use crate::replies::Fate;
use crate::segment::{self, Line};

/// What holds an axis that jams [N m/rad], [N m s/rad]: 1 mrad at 5 N m.
const STIFFNESS: f64 = 5000.0;
const DAMPING: f64 = 20.0;

impl Machine {
    /// Faults of drives, encoders and states that begin or end at this cycle.
    pub(super) fn begin_faults(&mut self, cycle: u64) {
        for place in 0..self.faults.len() {
            let fault = self.faults[place].clone();
            if fault.ends(cycle) {
                self.end_fault(&fault);
            }
            if !fault.acts(place, cycle) {
                continue;
            }
            // a cut cable may be behind the last device
            let Some(device) = self.devices.get_mut(fault.position) else {
                continue;
            };
            let drive = device.drive_mut();
            match fault.kind {
                FaultKind::DriveFault => drive.machine.raise(fault.code.unwrap_or(0x7305)),
                FaultKind::EncoderJump => drive.encoder.jump = fault.size,
                FaultKind::EncoderFrozen => {
                    drive.encoder.frozen = Some(drive.shown_position());
                }
                FaultKind::EncoderDrift => drive.encoder.jump += fault.size,
                FaultKind::StatusFrozen => {
                    let now = drive.statusword();
                    drive.status_frozen.get_or_insert(now);
                }
                FaultKind::TorqueFrozen => drive.freeze_target(),
                FaultKind::Sto => {
                    self.cut_power();
                    self.count(place);
                    continue;
                }
                FaultKind::Pause if fault.counting == Counting::Cycles => {
                    self.pauses = true;
                    self.count(place);
                    continue;
                }
                FaultKind::ModeChange => drive.forced_mode = Some(fault.size as i8),
                FaultKind::ControlIgnored => drive.deaf = true,
                FaultKind::Warning => drive.warning = true,
                FaultKind::LinkNoise => {
                    device.esc.count(reg::RECEIVE_ERRORS + 2 * fault.port);
                }
                FaultKind::SafeOp => {
                    device.fall(fault.code.unwrap_or(code::SYNC_ERROR));
                }
                _ => continue,
            }
            device.show_inputs();
            self.count(place);
        }
        let cut =
            |place: &usize| self.faults[*place].kind == FaultKind::CableCut && self.acts(*place);
        let places = (0..self.faults.len()).filter(cut);
        let reached = places.map(|place| self.faults[place].position).min();
        let reached = reached.unwrap_or(self.devices.len());
        segment::show_links(&mut self.devices, reached);
    }

    fn end_fault(&mut self, fault: &Fault) {
        let Some(device) = self.devices.get_mut(fault.position) else {
            return;
        };
        match fault.kind {
            FaultKind::EncoderJump | FaultKind::EncoderDrift => device.drive_mut().encoder.jump = 0,
            FaultKind::EncoderFrozen => device.drive_mut().encoder.frozen = None,
            FaultKind::ControlIgnored => device.drive_mut().deaf = false,
            FaultKind::Warning => device.drive_mut().warning = false,
            FaultKind::StatusFrozen => device.drive_mut().status_frozen = None,
            FaultKind::TorqueFrozen => device.drive_mut().target_frozen = None,
            _ => return,
        }
        device.show_inputs();
    }

    pub(super) fn line(&mut self, wall: i64) -> Line {
        let (dc, watch) = self.now(wall);
        let mut line = Line { reached: self.devices.len(), bypassed: Vec::new(), dc, watch };
        for place in 0..self.faults.len() {
            let (kind, position) = (self.faults[place].kind, self.faults[place].position);
            if matches!(kind, FaultKind::CableCut | FaultKind::WkcShort) && self.acts(place) {
                match kind {
                    FaultKind::CableCut => line.reached = line.reached.min(position),
                    _ => line.bypassed.push(position),
                }
                self.count(place);
            }
        }
        line
    }

    fn acts(&self, place: usize) -> bool {
        let fault = &self.faults[place];
        let now = match fault.counting {
            Counting::Cycles => self.cycle,
            Counting::Frames => Some(self.frames),
            Counting::AnyFrames => Some(self.received),
        };
        now.is_some_and(|now| fault.acts(place, now))
    }

    /// Pauses that count frames of any kind.
    pub(super) fn pause_at_frame(&mut self) {
        let counts = |fault: &Fault| fault.counting == Counting::AnyFrames;
        for place in 0..self.faults.len() {
            if counts(&self.faults[place]) && self.acts(place) {
                self.pauses = true;
                self.count(place);
            }
        }
    }

    /// Safe torque off of all drives: no power, whatever the controlwords are.
    fn cut_power(&mut self) {
        for device in &mut self.devices {
            device.drive_mut().machine.cut();
            device.show_inputs();
        }
    }

    /// Torque from outside on the axis of a position [N m]: somebody pushes, or something jams it.
    pub(super) fn pushed_by(&mut self, position: usize, axis: usize) -> f64 {
        let mut torque = 0.0;
        let mut jam = None;
        for place in 0..self.faults.len() {
            let (kind, size) = (self.faults[place].kind, self.faults[place].size);
            if self.faults[place].position != position || !self.acts(place) {
                continue;
            }
            match kind {
                FaultKind::Push => torque += size as f64 * 1e-3,
                FaultKind::Jam => jam = Some(self.jammed_at[axis].unwrap_or(self.theta[axis])),
                _ => continue,
            }
            self.count(place);
        }
        self.jammed_at[axis] = jam;
        let rate = self.devices[position].drive().rate();
        torque - jam.map_or(0.0, |at| STIFFNESS * (self.theta[axis] - at) + DAMPING * rate)
    }

    /// The other end stood still: cycles that go by before its frame acts.
    pub(super) fn stall(&mut self, wall: i64) -> Result<Option<u64>, Error> {
        let Some(fault) = self.find(FaultKind::Stall) else { return Ok(None) };
        let cycles = fault.count.unwrap_or(1);
        (0..cycles).try_for_each(|_| self.advance(wall))?;
        Ok(Some(cycles))
    }

    /// The first fault of this kind that is active now.
    fn find(&mut self, kind: FaultKind) -> Option<Fault> {
        let place = (0..self.faults.len())
            .find(|place| self.faults[*place].kind == kind && self.acts(*place))?;
        self.count(place);
        Some(self.faults[place].clone())
    }

    /// The frame is damaged on its way: devices from there on do not take its process data, and it gets no reply.
    pub(super) fn damage(&mut self, line: &mut Line) -> bool {
        let Some(fault) = self.find(FaultKind::FrameDamaged) else { return false };
        if fault.port == 0 {
            line.bypassed.extend(fault.position..self.devices.len());
        }
        segment::count_damaged(&mut self.devices, fault.position, fault.port);
        true
    }

    pub(super) fn acting(&mut self, kind: FaultKind) -> Option<LossTime> {
        self.find(kind).map(|fault| fault.acting)
    }

    /// How the reply to this frame is treated.
    pub(super) fn fate(&mut self, answered: bool) -> Fate {
        if !answered {
            return Fate::Lost;
        }
        if self.find(FaultKind::FrameDuplicated).is_some() {
            return Fate::Twice;
        }
        if let Some(fault) = self.find(FaultKind::FrameDelayed) {
            return Fate::Late { frames: fault.frames, after: false };
        }
        if let Some(fault) = self.find(FaultKind::FrameReordered) {
            return Fate::Late { frames: fault.frames, after: true };
        }
        Fate::Sound
    }

    fn count(&mut self, place: usize) {
        self.counts[place] += 1;
        if self.counts[place] == 1 {
            let fault = &self.faults[place];
            let (kind, position) = (fault.kind.name(), fault.position);
            self.record(EventKind::Fault { kind, position });
        }
    }
}
