//! Reads a configuration and reports all of its mistakes at once.

use std::path::Path;

use super::hash::hash;
use super::mistakes::{ConfigError, Mistake, Mistakes};
use super::{check_profile, startup, toml_error, Config, Limits, AXES};

/// The configuration in `file`, or every mistake with key, value, range and remedy.
/// `changes`: `key=value`, each replaces one value of the file.
pub fn read(file: &Path, changes: &[String]) -> Result<Config, ConfigError> {
    let mend = "give a configuration file, for example gateway/machines/akd.toml";
    let named = |why: ConfigError| why.of(file);
    let text = std::fs::read_to_string(file);
    let file_text = text.map_err(|why| named(Mistake::Unreadable(why, mend).into()))?;
    let text = changed(&file_text, changes).map_err(|mistake| named(mistake.into()))?;
    let formed = toml::from_str::<Config>(&text).map_err(|why| {
        toml::from_str::<Config>(&file_text).map_or_else(
            |of_file| toml_error::describe(&file_text, &of_file),
            |_| toml_error::describe_change(&text, &why),
        )
    });
    formed.map_err(|mistake| named(mistake.into()))?;
    let mut config = parse(&text).map_err(named)?;
    config.hash = hash(&text);
    config.system.ssp = Config::place(file, &config.system.ssp);
    let pose_fmu = config.system.pose_fmu.take();
    config.system.pose_fmu = pose_fmu.map(|path| Config::place(file, &path));
    config.recorder.folder = Config::place(file, &config.recorder.folder);
    let resume = config.estimate.resume.take();
    config.estimate.resume = resume.map(|path| Config::place(file, &path));
    let homing = config.homing.file.take();
    config.homing.file = homing.map(|path| Config::place(file, &path));
    Ok(config)
}

/// The text with single values replaced; unchanged text keeps its line numbers for errors.
fn changed(text: &str, changes: &[String]) -> Result<String, Mistake> {
    if changes.is_empty() {
        return Ok(text.to_owned());
    }
    let mut all: toml::Table =
        toml::from_str(text).map_err(|why| toml_error::describe(text, &why))?;
    for change in changes {
        let wrong = |why: &str| Mistake::Change { change: change.clone(), why: why.to_owned() };
        let (key, value) = change.split_once('=').ok_or_else(|| wrong("write it as KEY=VALUE"))?;
        let value: toml::Table = toml::from_str(&format!("value = {value}"))
            .or_else(|_| toml::from_str(&format!("value = {value:?}")))
            .map_err(|_| wrong("not a valid TOML value"))?;
        let (tables, last) = key.rsplit_once('.').unwrap_or(("", key));
        let mut table = &mut all;
        for name in tables.split('.').filter(|name| !name.is_empty()) {
            let inner = table.get_mut(name).and_then(toml::Value::as_table_mut);
            table = inner.ok_or_else(|| wrong(&format!("there is no table {name:?}")))?;
        }
        table.insert(last.to_owned(), value["value"].clone());
    }
    toml::to_string(&all).map_err(|why| Mistake::Form(why.to_string()))
}

/// The configuration in a text, or its mistakes.
pub fn parse(text: &str) -> Result<Config, ConfigError> {
    let config: Config = toml::from_str(text).map_err(|why| toml_error::describe(text, &why))?;
    check(&config)?;
    Ok(config)
}

fn check(config: &Config) -> Result<(), ConfigError> {
    let mut mistakes = Mistakes::default();
    for (key, value, low, high, mend) in numbers(config) {
        mistakes.check_range(key, value, low..=high, mend);
    }
    if let Some(cpu) = config.real_time.cpu {
        let mend = "`nproc --all` prints the number of CPUs, the first is 0";
        mistakes.check_range("real_time.cpu", cpu as f64, 0.0..=1023.0, mend);
    }
    if let Some(bound) = config.bus.clock_difference_ns {
        let mend = "largest difference of two clocks; controllers settle to some tens of ns, and a cycle must be longer";
        mistakes.check_range("bus.clock_difference_ns", bound.into(), 10.0..=1e6, mend);
    }
    interface(config, &mut mistakes);
    for (k, limit) in config.pose.iter().enumerate() {
        // also of what is no number
        let ascending = limit.min < limit.max;
        if !ascending {
            let (min, max) = (limit.min, limit.max);
            mistakes.add(format!("pose[{k}].min = {min} is not below max = {max}: swap them"));
        }
    }
    config.landing.check(&mut mistakes);
    config.estimate.check(&mut mistakes);
    config.homing.check(config.landing.torque, &mut mistakes);
    check_profile::profile(&config.profile, &mut mistakes);
    check_limits("limits", &config.limits, &mut mistakes);
    for (k, drive) in config.drive.iter().enumerate() {
        let (at, sent) = (format!("drive[{k}].startup"), config.profile.sent());
        startup::check(&at, &drive.startup, &sent, &mut mistakes);
        if let Some(limits) = &drive.limits {
            check_limits(&format!("drive[{k}].limits"), limits, &mut mistakes);
        }
    }
    drives(config, &mut mistakes);
    mistakes.into_result()
}

fn check_limits(at: &str, l: &Limits, mistakes: &mut Mistakes) {
    for (name, value, low, high, mend) in limits(l) {
        mistakes.check_range(&format!("{at}.{name}"), value, low..=high, mend);
    }
    if l.position_min >= l.position_max {
        let (low, high) = (l.position_min, l.position_max);
        mistakes.add(format!(
            "{at}.position_min_rad = {low} is not below position_max_rad = {high}: swap them"
        ));
    }
}

/// A number of the configuration: key, value, smallest and largest, how to mend it.
type Row<'a> = (&'a str, f64, f64, f64, &'a str);

/// Numbers that occur once in the file.
#[rustfmt::skip]
fn numbers(c: &Config) -> [Row<'_>; 20] {
    let (b, r, s, w) = (&c.bus, &c.real_time, &c.safety, &c.recorder);
    [
        ("bus.reply_timeout_us", b.reply_timeout_us.into(), 20.0, 10_000.0,
         "longest wait for a reply; well below the cycle time, which must also hold the computation"),
        ("bus.lockstep_timeout_ms", b.lockstep_timeout_ms.into(), 1.0, 10_000.0,
         "wall-clock time after which a lockstep frame counts as lost"),
        ("bus.watchdog_ms", b.watchdog_ms.into(), 1.0, 6000.0,
         "a few cycles, below the watchdog of the drive itself"),
        ("bus.state_timeout_ms", b.state_timeout_ms.into(), 10.0, 60_000.0,
         "longest time of a drive for a change of state"),
        ("bus.sync0_shift_us", b.sync0_shift_us.into(), 0.0, 10_000.0,
         "phase of SYNC0 within the cycle"),
        ("real_time.priority", r.priority.into(), 0.0, 99.0, "0 sets no priority"),
        ("real_time.spin_us", r.spin_us.into(), 0.0, 1000.0,
         "the kernel throttles a thread that spins for whole cycles"),
        ("system.late_limit", c.system.late_limit.into(), 1.0, 1e6,
         "ticks in a row that a component in a thread of its own may leave out"),
        ("safety.lost_frame_limit", s.lost_frame_limit.into(), 1.0, 1000.0,
         "consecutive cycles without a reply"),
        ("safety.working_counter_limit", s.working_counter_limit.into(), 1.0, 1000.0,
         "consecutive cycles with a short working counter"),
        ("safety.speed_cycles", s.speed_cycles.into(), 1.0, 64.0, "window of the mean speed in cycles"),
        ("safety.frozen_cycles", s.frozen_cycles.into(), 2.0, 4000.0,
         "cycles with constant encoder counts"),
        ("safety.frozen_motion_rad", s.frozen_motion_rad, 1e-9, 1.0,
         "motion of the reference within which the encoder counts must change"),
        ("safety.frozen_still_cycles", s.frozen_still_cycles.into(), 0.0, 40_000.0,
         "cycles with constant encoder counts, whatever the reference does"),
        ("safety.feedback_s", s.feedback_s, 1e-3, 100.0, "time constant of the mean feedback torque"),
        ("safety.measured_s", s.measured_s, 1e-3, 100.0, "time constant of the mean difference of torques"),
        ("safety.thermal_s", s.thermal_s, 1e-3, 1e4, "time constant of the motor's temperature"),
        ("safety.overrun_us", s.overrun_us.into(), 1.0, 1_000_000.0, "longest delay of the start of a cycle"),
        ("recorder.keep_s", w.keep_s, 0.0, 60.0, "seconds kept before a trip"),
        ("recorder.buffer_cycles", w.buffer_cycles as f64, 64.0, 1e6,
         "rows between control loop and writer; 4000 are 1 s at 4 kHz"),
    ]
}

/// Limits of an axis by key.
#[rustfmt::skip]
fn limits(l: &Limits) -> [Row<'_>; 10] {
    [
        ("torque_N_m", l.torque, 1e-3, 1e4, "largest torque of this axis"),
        ("speed_rad_per_s", l.speed, 1e-3, 1e3, "highest speed"),
        ("position_min_rad", l.position_min, -10.0, 10.0, "lower limit of the angle"),
        ("position_max_rad", l.position_max, -10.0, 10.0, "upper limit of the angle"),
        ("following_error_rad", l.following_error, 1e-6, 10.0, "largest following error"),
        ("jump_rad", l.jump, 1e-6, 1.0, "largest change of the angle in one cycle"),
        ("torque_step_N_m", l.torque_step, 0.0, 1e4, "largest change of the torque in one cycle"),
        ("measured_torque_N_m", l.measured_torque, 0.0, 1e4, "largest measured less commanded torque"),
        ("rated_torque_N_m", l.rated_torque, 0.0, 1e4, "torque that the motor bears for ever; 0: not judged"),
        ("feedback_torque_N_m", l.feedback_torque, 0.0, 1e4, "largest torque of the feedback alone"),
    ]
}

fn interface(config: &Config, mistakes: &mut Mistakes) {
    let name = &config.bus.interface;
    if name.is_empty() || name.len() > 15 {
        mistakes.add(format!(
            "bus.interface = {name:?}, allowed 1 to 15 characters: `ip link` lists the interfaces"
        ));
    }
}

fn drives(config: &Config, mistakes: &mut Mistakes) {
    if config.drive.len() != AXES {
        mistakes.add(format!(
            "drive: {} entries, expected {AXES}: write one [[drive]] for each axis",
            config.drive.len()
        ));
        return;
    }
    for (k, drive) in config.drive.iter().enumerate() {
        if drive.direction != 1 && drive.direction != -1 {
            mistakes.add(format!("drive[{k}].direction = {}, allowed 1 or -1", drive.direction));
        }
        let double = |serial: &u32| config.drive[..k].iter().any(|d| d.serial == Some(*serial));
        if let Some(serial) = drive.serial.filter(double) {
            mistakes.add(format!(
                "drive[{k}].serial = {serial}: also that of another drive: `check --bus` shows them"
            ));
        }
        mistakes.check_range(
            &format!("drive[{k}].position"),
            drive.position.into(),
            0.0..=15.0,
            "position on the bus, the first drive is 0",
        );
        if config.drive[..k].iter().any(|d| d.position == drive.position) {
            mistakes.add(format!(
                "drive[{k}].position = {}: also used by another drive: give each drive its own position",
                drive.position
            ));
        }
    }
}
