//! Six drives on one plant: start, cycle, and faults at their exact cycles.
mod fault_injection;
mod happened;
#[cfg(test)]
mod link_tests;
mod motion;
mod seen;

use crate::error::Error;
use crate::event::{Event, EventKind};
use crate::faults::{Fault, FaultKind, LossTime};
use crate::plant::{Plant, AXES};
use crate::replies::{Fate, Replies};
use crate::segment;
use crate::subdevice::SubDevice;
use crate::trajectory::Trajectory;
use seen::{states, Extremes, States};

pub struct Machine {
    pub devices: Vec<SubDevice>,
    /// Axis of each position on the bus; None: no drive.
    order: Vec<Option<usize>>,
    plant: Box<dyn Plant>,
    faults: Vec<Fault>,
    counts: Vec<u64>,
    lockstep: bool,
    /// Base step `[s]`.
    dt: f64,
    /// Since a reply showed all drives enabled; None before.
    cycle: Option<u64>,
    /// Something holds the plant until then.
    waits: bool,
    /// Process-data frames so far, or base steps in their place.
    pub frames: u64,
    other_frames: u64,
    /// Frames of any kind.
    received: u64,
    pub dropped: u64,
    theta: [f64; AXES],
    tau_meas: [f64; AXES],
    pushed: [bool; AXES],
    /// Torque of somebody at the axis `[N m]`.
    pushed_from_outside: [f64; AXES],
    /// Angle at which something holds an axis [rad].
    jammed_at: [Option<f64>; AXES],
    /// Since the first frame.
    pub extremes: Extremes,
    /// This process is to stand still before it answers.
    pauses: bool,
    seen: Vec<States>,
    replies: Replies,
    pub trajectory: Trajectory,
    pub events: Vec<Event>,
}

impl Machine {
    pub fn new(
        devices: Vec<SubDevice>,
        order: Vec<Option<usize>>,
        plant: Box<dyn Plant>,
        faults: Vec<Fault>,
        (dt, lockstep): (f64, bool),
        trajectory: Trajectory,
    ) -> Machine {
        let mut machine = Machine {
            seen: devices.iter().map(states).collect(),
            devices,
            order,
            plant,
            counts: vec![0; faults.len()],
            faults,
            lockstep,
            dt,
            cycle: None,
            waits: true,
            frames: 0,
            other_frames: 0,
            received: 0,
            dropped: 0,
            theta: [0.0; AXES],
            tau_meas: [0.0; AXES],
            pushed: [false; AXES],
            pushed_from_outside: [0.0; AXES],
            jammed_at: [None; AXES],
            extremes: Extremes::default(),
            pauses: false,
            replies: Replies::default(),
            trajectory,
            events: Vec::new(),
        };
        machine.measure(None);
        segment::show_links(&mut machine.devices, machine.order.len());
        machine
    }

    /// Plant cycles completed; None before the start.
    pub fn cycle(&self) -> Option<u64> {
        self.cycle
    }

    /// The SYNC0 of the first drive nearest to this time [ns]; the time itself without SYNC0.
    pub fn nearest_sync0(&self, wall: i64) -> i64 {
        let cycle = (self.dt * 1e9).round() as i64;
        let since = self.devices.first().and_then(|d| d.esc.since_sync0(wall, cycle));
        since.map_or(wall, |since| wall - since + if since > cycle / 2 { cycle } else { 0 })
    }

    fn now(&self, wall: i64) -> (i64, i64) {
        if !self.lockstep {
            return (wall, wall);
        }
        let watch = self.frames as i64 * (self.dt * 1e9).round() as i64;
        (watch + 1000 * self.other_frames as i64, watch)
    }

    /// Processes a frame. `wall`: time [ns] for free-running clocks. Replies are added to `out`.
    pub fn receive(
        &mut self,
        frame: &[u8],
        wall: i64,
        out: &mut Vec<Vec<u8>>,
    ) -> Result<(), Error> {
        let Some(ranges) = segment::datagrams(frame) else {
            self.dropped += 1;
            return Ok(());
        };
        self.received += 1;
        self.pause_at_frame();
        let mut frame = frame.to_vec();
        if !segment::is_process_data(&frame, &ranges) {
            self.other_frames += 1;
            let line = self.line(wall);
            segment::pass(&mut frame, &ranges, &mut self.devices, &line);
            if line.reached > 0 {
                out.push(frame);
            }
            self.record_changes();
            return Ok(());
        }
        if self.cycle.is_none() && self.all_enabled() {
            self.cycle = Some(0);
            self.record(EventKind::Enabled);
        }
        if self.lockstep {
            out.extend(self.stall(wall)?.map(|cycles| segment::stalled(&frame, cycles)));
        }
        let mut line = self.line(wall);
        let damaged = self.damage(&mut line);
        let lost = self.acting(FaultKind::FrameLost);
        if lost != Some(LossTime::Before) {
            segment::pass(&mut frame, &ranges, &mut self.devices, &line);
            self.devices.iter_mut().for_each(|device| {
                device.act();
            });
        }
        let answered = lost.is_none() && !damaged && line.reached > 0;
        let fate = self.fate(answered);
        let unanswered = matches!(fate, Fate::Lost | Fate::Late { .. });
        // no clock applies in lockstep: the other end is told not to wait
        let notice = (self.lockstep && unanswered).then(|| segment::no_reply(&frame));
        self.replies.take(frame, fate, out);
        out.extend(notice);
        if self.lockstep {
            self.advance(wall)
        } else {
            self.frames += 1;
            self.record_changes();
            Ok(())
        }
    }

    fn all_enabled(&self) -> bool {
        let mut drives = self.devices.iter().zip(&self.order).filter(|(_, axis)| axis.is_some());
        drives.all(|(device, _)| device.is_enabled())
    }

    /// One base step: watchdogs, then the plant under the drives' torques, then what they measure.
    pub fn advance(&mut self, wall: i64) -> Result<(), Error> {
        let (_, watch) = self.now(wall);
        for position in 0..self.devices.len() {
            if self.devices[position].watch(watch) {
                self.record(EventKind::Watchdog { position });
            }
        }
        if self.lockstep {
            self.frames += 1;
        }
        if self.cycle.is_some() || !self.waits {
            self.push()?;
        }
        self.record_changes();
        for device in &mut self.devices {
            device.drive_mut().machine.settle();
        }
        let Some(cycle) = self.cycle else {
            self.measure((!self.waits).then_some(self.dt));
            self.extremes.note(&self.theta, self.dt);
            return Ok(());
        };
        self.cycle = Some(cycle + 1);
        self.measure(Some(self.dt));
        self.extremes.note(&self.theta, self.dt);
        self.begin_faults(cycle + 1);
        Ok(())
    }

    /// True angles of the axes [rad].
    pub fn angles(&self) -> [f64; AXES] {
        self.theta
    }

    /// Axes whose drive gave torque in the last step.
    pub fn powered(&self) -> [bool; AXES] {
        self.pushed
    }

    pub fn has_torque(&self) -> bool {
        self.pushed.contains(&true)
    }

    /// Whether a fault wants this process to stand still; once.
    pub fn take_pause(&mut self) -> bool {
        std::mem::take(&mut self.pauses)
    }
}

#[cfg(test)]
mod tests;
