//! One servo drive: objects, process data, quantised current and encoder. The plant computes the motion.
mod bytes;
pub mod cia402;
pub mod kind;
pub mod parameters;
mod setting;

use crate::coe::abort;
use bytes::signed;
use cia402::{Machine, State};
use kind::{Kind, Use};
use parameters::Parameters;
pub use setting::Setting;

/// Heartbeat or watchdog error in object 0x603F; the AKD shows it as F706.
pub const ERROR_WATCHDOG: u16 = 0x8130;

/// Faults of the encoder.
#[derive(Debug, Clone, Copy, Default)]
pub struct Encoder {
    pub jump: i64,
    /// It counts against the axis.
    pub reversed: bool,
    /// Shown instead of the position.
    pub frozen: Option<i64>,
}

pub struct Drive {
    pub setting: Setting,
    pub machine: Machine,
    pub encoder: Encoder,
    pub parameters: Parameters,
    /// Shown and used in place of the mode that was set.
    pub forced_mode: Option<i8>,
    pub warning: bool,
    /// Controlwords have no effect.
    pub deaf: bool,
    /// It follows its controlword in every frame of so many; 0: in all.
    pub slow: u32,
    frames: u32,
    /// Shown whatever the state is.
    pub status_frozen: Option<u16>,
    /// Used in place of its target.
    pub target_frozen: Option<i64>,
    control: u16,
    mode: i8,
    mode_display: i8,
    target: i64,
    /// Counts, 1 mA or 0.1 % steps, mrpm.
    position: i64,
    torque: i64,
    velocity: i64,
    angle: Option<f64>,
    /// Of the axis `[rad/s]`.
    rate: f64,
}

impl Drive {
    pub fn new(setting: Setting, state: State, error: u16) -> Drive {
        Drive {
            parameters: Parameters::new(&setting),
            forced_mode: None,
            warning: false,
            setting,
            machine: Machine::new(state, error),
            encoder: Encoder::default(),
            deaf: false,
            slow: 0,
            frames: 0,
            status_frozen: None,
            target_frozen: None,
            control: 0,
            mode: 0,
            mode_display: 0,
            target: 0,
            position: 0,
            torque: 0,
            velocity: 0,
            angle: None,
            rate: 0.0,
        }
    }

    /// Outputs of a frame act: one transition of the state machine.
    pub fn act(&mut self) {
        if self.setting.kind.modes().contains(&self.mode) {
            self.mode_display = self.mode;
        }
        self.mode_display = self.forced_mode.unwrap_or(self.mode_display);
        self.frames = self.frames.wrapping_add(1);
        if !self.deaf && self.frames.is_multiple_of(self.slow.max(1)) {
            self.machine.control(self.control);
        }
    }

    /// Torque on the axis [N m]: of the braked motor, unless enabled in the torque mode.
    pub fn torque(&self) -> f64 {
        if self.machine.state != State::OperationEnabled {
            return self.braking();
        }
        if self.mode_display != self.setting.kind.torque_mode() {
            return 0.0;
        }
        let steps = self
            .target_frozen
            .unwrap_or(self.target)
            .clamp(-self.setting.limit, self.setting.limit);
        (self.setting.direction * steps) as f64 * self.setting.torque_step()
    }

    /// Torque of the motor whose windings are short-circuited [N m].
    pub fn braking(&self) -> f64 {
        // no negative zero: a drive that coasts gives 0
        0.0 - self.setting.braking * self.rate
    }

    /// Speed of the axis [rad/s].
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Takes the measurements of the plant `[rad]`, `[N m]`; dt `[s]` since the last call, None: at rest.
    pub fn measure(&mut self, angle: f64, torque: f64, dt: Option<f64>) {
        let setting = &self.setting;
        let steps = (angle / setting.angle_step()).round_ties_even() as i64;
        self.position = setting.direction.wrapping_mul(steps).wrapping_add(setting.offset);
        let current = (torque / setting.torque_step()).round_ties_even() as i64;
        self.torque = setting.direction.wrapping_mul(current);
        if let Some(dt) = dt {
            let before = self.angle.unwrap_or(angle);
            self.rate = (angle - before) / dt;
            let mrpm = self.rate / std::f64::consts::TAU * 60_000.0;
            self.velocity = setting.direction.wrapping_mul(mrpm.round() as i64);
        }
        self.angle = Some(angle);
    }

    /// Position as the encoder shows it `[counts]`.
    pub fn shown_position(&self) -> i64 {
        let position = match self.encoder.reversed {
            true => self.setting.offset.wrapping_mul(2).wrapping_sub(self.position),
            false => self.position,
        };
        self.encoder.frozen.unwrap_or(position.wrapping_add(self.encoder.jump))
    }

    /// The torque does not follow the target any more.
    pub fn freeze_target(&mut self) {
        self.target_frozen.get_or_insert(self.target);
    }

    pub fn statusword(&self) -> u16 {
        let warning = u16::from(self.warning) << 7;
        self.status_frozen.unwrap_or(self.machine.state.statusword() | warning)
    }

    /// The low bits of an object; None where the drive has none.
    pub fn value(&self, index: u16) -> Option<i64> {
        self.setting.kind.object(index)?;
        Some(match index {
            kind::CONTROLWORD => i64::from(self.control),
            kind::STATUSWORD => i64::from(self.statusword()),
            kind::MODE => i64::from(self.mode),
            kind::MODE_DISPLAY => i64::from(self.mode_display),
            kind::ERROR_CODE => i64::from(self.machine.error),
            kind::POSITION | kind::POSITION_INTERNAL => self.shown_position(),
            kind::VELOCITY => self.velocity,
            kind::TARGET_CURRENT | kind::TARGET_TORQUE => self.target,
            kind::CURRENT => self.torque,
            kind::TORQUE => self.torque_per_mille(),
            kind::RATED_CURRENT => self.rated_current_ma() as i64,
            kind::RATED_TORQUE => i64::from(self.setting.rated_torque_mnm),
            kind::SUPPORTED_MODES => i64::from(self.setting.kind.supported_modes()),
            _ => return None,
        })
    }

    fn rated_current_ma(&self) -> f64 {
        f64::from(self.setting.rated_torque_mnm) / self.setting.torque_constant
    }

    fn torque_per_mille(&self) -> i64 {
        match self.setting.kind {
            Kind::Cst => self.torque,
            Kind::Akd => (1000.0 * self.torque as f64 / self.rated_current_ma()).round() as i64,
        }
    }

    /// From the bus: the outputs of a frame, or an SDO. Data has the object's size.
    pub fn set(&mut self, index: u16, data: &[u8]) {
        let value = signed(data);
        match index {
            kind::CONTROLWORD => self.control = value as u16,
            kind::MODE => self.mode = value as i8,
            kind::TARGET_CURRENT => self.target = value,
            kind::TARGET_TORQUE => self.target = self.per_mille_to_steps(value),
            _ => {}
        }
    }

    fn per_mille_to_steps(&self, value: i64) -> i64 {
        match self.setting.kind {
            Kind::Cst => value,
            Kind::Akd => (value as f64 * 0.001 * self.rated_current_ma()).round() as i64,
        }
    }

    pub fn upload(&self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        if self.parameters.has(index) {
            return self.parameters.upload(index, sub);
        }
        let object = self.setting.kind.object(index).ok_or(abort::NO_OBJECT)?;
        if sub != 0 {
            return Err(abort::NO_SUBINDEX);
        }
        let value = self.value(index).ok_or(abort::NO_OBJECT)?;
        Ok(value.to_le_bytes()[..usize::from(object.bits / 8)].to_vec())
    }

    pub fn download(&mut self, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        if self.parameters.has(index) {
            return self.parameters.download(index, sub, data);
        }
        let object = self.setting.kind.object(index).ok_or(abort::NO_OBJECT)?;
        if sub != 0 {
            return Err(abort::NO_SUBINDEX);
        }
        if object.role != Use::Output {
            return Err(abort::READ_ONLY);
        }
        if data.len() != usize::from(object.bits / 8) {
            return Err(abort::LENGTH);
        }
        if index == kind::MODE && !self.setting.kind.modes().contains(&(data[0] as i8)) {
            return Err(abort::VALUE_RANGE);
        }
        self.set(index, data);
        if matches!(index, kind::CONTROLWORD | kind::MODE) {
            self.act();
        }
        Ok(())
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
