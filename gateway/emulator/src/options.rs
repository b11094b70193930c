//! Options of the emulator, read from a TOML file, with defaults.
use crate::application::DeviceSettings;
use crate::drive::cia402::State;
use crate::drive::kind::Kind;
use crate::drive::{Drive, Setting};
use crate::drive_options::{DriveOptions, Initial};
use crate::error::Error;
use crate::esc::clock::Clock;
use crate::faults::{chance, Fault};
use crate::plant::AXES;
use crate::sii::Identity;
use crate::subdevice::SubDevice;
use flexhex_system::Value;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Vendor and product of a device that is no drive.
const OTHER: (u32, u32) = (0x0000_0F1E, 0x1008_0000);

/// The options file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    pub interface: String,
    pub lockstep: bool,
    pub json: bool,
    pub log: Option<PathBuf>,
    pub cycles: Option<u64>,
    /// Lockstep: wall-clock seconds without a frame after which the plant continues until all torques
    /// are zero; none: it waits without limit.
    pub silence_s: Option<f64>,
    pub plant: PlantOptions,
    pub drives: Drives,
    /// Single drives, by position on the bus.
    pub drive: Vec<DriveOptions>,
    pub fault: Vec<Fault>,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlantOptions {
    /// None: six flywheels replace the FMU.
    pub system: Option<PathBuf>,
    pub component: Option<String>,
    pub fmu: Option<PathBuf>,
    /// "plant.name" = value; replaces the value of the system.
    pub parameters: BTreeMap<String, Value>,
    /// Time without torque before the first frame `[s]`: the machine comes to rest under its weight
    /// and moves from then on. None: something holds it until all drives are enabled.
    pub resting_s: Option<f64>,
}

/// Settings of all drives.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Drives {
    pub kind: Kind,
    pub count: usize,
    /// Positions on the bus of further devices, which have no axis.
    pub others: Vec<usize>,
    /// Axis (from 0) of each position on the bus; empty: in order.
    pub order: Vec<usize>,
    pub torque_constant: f64,
    pub rated_torque_mnm: u32,
    /// Largest current [mA] or torque [0.1 %]; none: 9 A, or three times the rated torque.
    pub limit: Option<i64>,
    pub counts_per_rev: f64,
    /// Dynamic braking of drives without power `[N m s/rad]`; 0: they coast.
    pub braking: f64,
    /// Largest relative error of the clocks.
    pub drift_ppm: f64,
    pub seed: u64,
    /// None: 512 bytes (AKD) or 128.
    pub mailbox_bytes: Option<u16>,
}

impl Default for Drives {
    fn default() -> Drives {
        Drives {
            kind: Kind::Akd,
            count: AXES,
            others: Vec::new(),
            order: Vec::new(),
            torque_constant: 3.0,
            rated_torque_mnm: 9000,
            limit: None,
            counts_per_rev: 4_294_967_296.0,
            braking: 0.0,
            drift_ppm: 30.0,
            seed: 1,
            mailbox_bytes: None,
        }
    }
}

impl Options {
    pub fn check(&self) -> Result<(), Error> {
        let drives = &self.drives;
        let wrong = |what: String| Err(Error::new(what));
        if self.interface.is_empty() {
            return wrong(
                "no network interface: give --interface NAME (`ip link` lists them)".into(),
            );
        }
        if !(1..=AXES).contains(&drives.count) {
            return wrong(format!("drives.count = {}, allowed 1 to {AXES}", drives.count));
        }
        let mut axes = self.axes();
        axes.sort_unstable();
        axes.dedup();
        if axes.len() != drives.count || axes.last().is_some_and(|axis| *axis >= AXES) {
            let order = &drives.order;
            return wrong(format!(
                "drives.order = {order:?}: give each drive one axis, 0 to 5, and no axis twice"
            ));
        }
        for (name, value) in [
            ("torque_constant", drives.torque_constant),
            ("counts_per_rev", drives.counts_per_rev),
            ("rated_torque_mnm", f64::from(drives.rated_torque_mnm)),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(format!("drives.{name} = {value}, must be above 0"));
            }
        }
        let last = self.devices() - 1;
        if drives.others.iter().any(|position| *position > last) {
            return wrong(format!("drives.others = {:?}, allowed 0 to {last}", drives.others));
        }
        if drives.mailbox_bytes.is_some_and(|bytes| !(24..=1024).contains(&bytes)) {
            return wrong("drives.mailbox_bytes: allowed 24 to 1024".into());
        }
        if drives.limit.is_some_and(|limit| !(0..=1_000_000).contains(&limit)) {
            return wrong("drives.limit: allowed 0 to 1000000".into());
        }
        if !(0.0..=100.0).contains(&drives.braking) {
            return wrong("drives.braking: allowed 0 to 100".into());
        }
        if self.plant.resting_s.is_some_and(|time| !(0.0..=3600.0).contains(&time)) {
            return wrong("plant.resting_s: allowed 0 to 3600".into());
        }
        if self.silence_s.is_some_and(|time| !(0.0..=3600.0).contains(&time)) {
            return wrong("silence_s: allowed 0 to 3600".into());
        }
        for special in &self.drive {
            if special.position >= self.devices() {
                let (position, last) = (special.position, self.devices() - 1);
                return wrong(format!("drive.position = {position}, allowed 0 to {last}"));
            }
            if !matches!(special.direction, None | Some(1 | -1)) {
                return wrong("drive.direction: allowed 1 or -1".into());
            }
        }
        let faults = self.fault.iter().enumerate();
        faults.into_iter().try_for_each(|(place, fault)| fault.check(place, self.devices()))
    }

    pub fn setting(&self) -> Setting {
        let drives = &self.drives;
        let limit = if drives.kind == Kind::Akd { 9000 } else { 3000 };
        Setting {
            kind: drives.kind,
            torque_constant: drives.torque_constant,
            rated_torque_mnm: drives.rated_torque_mnm,
            limit: drives.limit.unwrap_or(limit),
            counts_per_rev: drives.counts_per_rev,
            direction: 1,
            offset: 0,
            braking: drives.braking,
        }
    }

    pub fn device(&self, position: usize) -> SubDevice {
        let drives = &self.drives;
        let (vendor, product) = match drives.others.contains(&position) {
            true => OTHER,
            false => drives.kind.identity(),
        };
        let serial = 1000 + position as u32;
        let mut setting = self.setting();
        let mailbox_bytes = drives.mailbox_bytes.unwrap_or(drives.kind.mailbox_bytes());
        let mut settings = DeviceSettings {
            identity: Identity { vendor, product, revision: 2, serial, alias: 0 },
            mailbox_bytes,
            maps_fixed: false,
            extra_input_bytes: 0,
            output_control: 0x64,
            trigger_fixed: false,
            watchdog_dead: false,
            period_checked: false,
            emergencies: 0,
        };
        let (mut initial, mut forced_mode, mut objects) = (Initial::Ready, None, Vec::new());
        let (mut never_enabled, mut reversed, mut slow) = (false, false, 0);
        let (mut registers, mut drift_ppm, mut free) = (Vec::new(), None, false);
        for special in self.drive.iter().filter(|special| special.position == position) {
            let identity = &mut settings.identity;
            identity.vendor = special.vendor.unwrap_or(identity.vendor);
            identity.product = special.product.unwrap_or(identity.product);
            identity.revision = special.revision.unwrap_or(identity.revision);
            identity.serial = special.serial.unwrap_or(identity.serial);
            identity.alias = special.alias.unwrap_or(identity.alias);
            setting.direction = special.direction.unwrap_or(setting.direction);
            setting.offset = special.offset.unwrap_or(setting.offset);
            setting.counts_per_rev = special.counts_per_rev.unwrap_or(setting.counts_per_rev);
            initial = special.initial.unwrap_or(initial);
            forced_mode = special.forced_mode.or(forced_mode);
            objects.extend(&special.objects);
            never_enabled |= special.never_enabled;
            reversed |= special.encoder_reversed;
            slow = slow.max(special.slow);
            registers.extend(&special.registers);
            drift_ppm = special.drift_ppm.or(drift_ppm);
            free |= special.clock_free;
            settings.maps_fixed |= special.maps_fixed;
            settings.extra_input_bytes += special.extra_input_bytes;
            settings.output_control = special.output_control.unwrap_or(settings.output_control);
            settings.trigger_fixed |= special.trigger_fixed;
            settings.watchdog_dead |= special.watchdog_dead;
            settings.period_checked |= special.period_checked;
            settings.emergencies += special.emergencies;
        }
        let (state, error) = match initial {
            Initial::Ready => (State::SwitchOnDisabled, 0),
            Initial::ReadyToSwitchOn => (State::ReadyToSwitchOn, 0),
            Initial::Enabled => (State::OperationEnabled, 0),
            Initial::Fault => (State::Fault, 0x7305),
        };
        let drawn = drives.drift_ppm * (2.0 * chance(drives.seed, position, 0) - 1.0);
        let power_up = (chance(drives.seed, position, 1) * 1e10) as i64;
        let mut clock = Clock::new(power_up, drift_ppm.unwrap_or(drawn) * 1e-6);
        clock.free = free;
        let mut drive = Drive::new(setting, state, error);
        drive.parameters.replace(&objects);
        drive.forced_mode = forced_mode;
        drive.machine.never_enabled = never_enabled;
        drive.encoder.reversed = reversed;
        drive.slow = slow;
        let mut device = SubDevice::new(drive, settings, clock);
        for (address, value) in registers {
            device.esc.put(address, &[value]);
        }
        device
    }
}

#[cfg(test)]
#[path = "options_tests.rs"]
mod tests;
