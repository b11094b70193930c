//! Conversion between process data in counts and SI units.

use crate::config::{Config, Pdo, Role, AXES};

/// Byte offset of a role in the process data of one drive.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: usize,
    bits: u8,
}

/// Layout of the process data of every drive, and the scaling of each axis.
#[derive(Clone, Debug)]
pub struct Drives {
    rx: Layout,
    tx: Layout,
    mode: i8,
    tau_step: f64,
    theta_step: f64,
    axes: [Axis; AXES],
}

#[derive(Clone, Debug, Default)]
struct Layout {
    places: Vec<(Role, Place)>,
    bytes: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    direction: f64,
    offset: i32,
}

/// Values that a drive reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    pub statusword: u16,
    pub error_code: u16,
    pub theta: f64,
    pub tau: f64,
    /// Mode of operation display; None if it is not in the process data.
    pub mode: Option<i8>,
}

impl Drives {
    pub fn new(config: &Config) -> Self {
        let mut axes = [Axis::default(); AXES];
        for (axis, drive) in axes.iter_mut().zip(&config.drive) {
            axis.direction = f64::from(drive.direction);
            axis.offset = drive.offset_counts;
        }
        Drives {
            rx: Layout::new(&config.profile.rx),
            tx: Layout::new(&config.profile.tx),
            mode: config.profile.mode,
            tau_step: config.profile.scale.tau_step(),
            theta_step: config.theta_step(),
            axes,
        }
    }

    /// Bytes of the outputs and inputs of each drive.
    pub fn bytes(&self) -> (usize, usize) {
        (self.rx.bytes, self.tx.bytes)
    }

    /// Torque [N m] in counts of the drive, rounded to nearest even.
    pub fn counts(&self, axis: usize, tau: f64) -> i32 {
        // `as` saturates and maps NaN to zero; the safety rules have checked the limits before
        (self.axes[axis].direction * (tau / self.tau_step)).round_ties_even() as i32
    }

    /// Torque [N m] of a number of counts.
    pub fn torque(&self, axis: usize, counts: i32) -> f64 {
        self.axes[axis].direction * f64::from(counts) * self.tau_step
    }

    /// Angle [rad] of a position in counts. The counts wrap around; an angle near the offset does not.
    pub fn angle(&self, axis: usize, counts: i32) -> f64 {
        let a = self.axes[axis];
        a.direction * f64::from(counts.wrapping_sub(a.offset)) * self.theta_step
    }

    /// Shows this angle [rad] as 0 from now on; the new offset in counts.
    pub fn zero(&mut self, axis: usize, angle: f64) -> i32 {
        let a = &mut self.axes[axis];
        let counts = (a.direction * angle / self.theta_step).round() as i64;
        a.offset = a.offset.wrapping_add(counts as i32);
        a.offset
    }

    /// Write the outputs of an axis.
    pub fn write(&self, axis: usize, controlword: u16, tau: f64, out: &mut [u8]) {
        for (role, place) in &self.rx.places {
            let value = match role {
                Role::Controlword => i32::from(controlword),
                Role::Mode => i32::from(self.mode),
                Role::TargetTorque => place.fitting(self.counts(axis, tau)),
                _ => 0,
            };
            place.put(value, out);
        }
    }

    /// Read the inputs of an axis.
    pub fn read(&self, axis: usize, data: &[u8]) -> Report {
        let mut report = Report::default();
        for (role, place) in &self.tx.places {
            let value = place.get(data);
            match role {
                Role::Statusword => report.statusword = value as u16,
                Role::ErrorCode => report.error_code = value as u16,
                Role::ModeDisplay => report.mode = Some(value as i8),
                Role::Position => report.theta = self.angle(axis, value),
                Role::ActualTorque => report.tau = self.torque(axis, value),
                _ => {}
            }
        }
        report
    }
}

impl Layout {
    fn new(pdos: &[Pdo]) -> Self {
        let mut layout = Layout::default();
        for e in pdos.iter().flat_map(|p| &p.entries) {
            let place = Place { at: layout.bytes, bits: e.bits };
            layout.places.push((e.role, place));
            layout.bytes += usize::from(e.bits / 8);
        }
        layout
    }
}

impl Place {
    fn put(self, value: i32, out: &mut [u8]) {
        let n = usize::from(self.bits / 8);
        out[self.at..self.at + n].copy_from_slice(&value.to_le_bytes()[..n]);
    }

    /// Saturates to the signed range of the entry.
    fn fitting(self, value: i32) -> i32 {
        let most = i32::MAX >> (32 - self.bits);
        value.clamp(-most, most)
    }

    fn get(self, data: &[u8]) -> i32 {
        let b = &data[self.at..];
        match self.bits {
            8 => i32::from(b[0] as i8),
            16 => i32::from(i16::from_le_bytes([b[0], b[1]])),
            _ => i32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }
}

#[cfg(test)]
#[path = "drives_tests.rs"]
mod tests;
