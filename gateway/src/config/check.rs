//! Reading a configuration and saying all that is wrong in it at once.

use std::ops::RangeInclusive;
use std::path::Path;

use super::{Config, Limits, AXES};

/// The configuration in `file`, or every mistake with key, value, range and how to mend it.
/// `changes`: `key=value` of single values, over what the file says.
pub fn read(file: &Path, changes: &[String]) -> Result<Config, String> {
    let name = file.display();
    let text = std::fs::read_to_string(file).map_err(|why| {
        format!("{name}: {why}: give a configuration, such as gateway/machines/akd.toml")
    })?;
    let named = |all: String| {
        let lines: Vec<_> = all.lines().map(|m| format!("{name}: {m}")).collect();
        lines.join("\n")
    };
    let text = changed(&text, changes).map_err(named)?;
    let mut config = parse(&text).map_err(named)?;
    config.system.ssp = Config::place(file, &config.system.ssp);
    config.recorder.folder = Config::place(file, &config.recorder.folder);
    Ok(config)
}

/// The text with single values changed; as it is, line by line, where nothing is.
fn changed(text: &str, changes: &[String]) -> Result<String, String> {
    if changes.is_empty() {
        return Ok(text.to_owned());
    }
    let mut all: toml::Table = toml::from_str(text).map_err(|why| super::words::of(text, &why))?;
    for change in changes {
        let wrong = |why: &str| format!("--set {change}: {why}");
        let (key, value) = change.split_once('=').ok_or_else(|| wrong("wants KEY=VALUE"))?;
        let value: toml::Table = toml::from_str(&format!("value = {value}"))
            .or_else(|_| toml::from_str(&format!("value = {value:?}")))
            .map_err(|_| wrong("the value is none of TOML's"))?;
        let (tables, last) = key.rsplit_once('.').unwrap_or(("", key));
        let mut table = &mut all;
        for name in tables.split('.').filter(|name| !name.is_empty()) {
            let inner = table.get_mut(name).and_then(toml::Value::as_table_mut);
            table = inner.ok_or_else(|| wrong(&format!("there is no table {name:?}")))?;
        }
        table.insert(last.to_owned(), value["value"].clone());
    }
    toml::to_string(&all).map_err(|why| why.to_string())
}

/// The configuration in a text, or its mistakes, a line each.
pub fn parse(text: &str) -> Result<Config, String> {
    let config: Config = toml::from_str(text).map_err(|why| super::words::of(text, &why))?;
    let mistakes = check(&config);
    if mistakes.is_empty() {
        Ok(config)
    } else {
        Err(mistakes.join("\n"))
    }
}

/// Mistakes of a configuration, each `key = value, allowed range: how to mend it`.
fn check(config: &Config) -> Vec<String> {
    let mut found = Found::default();
    for (key, value, low, high, mend) in numbers(config) {
        found.within(key, value, low..=high, mend);
    }
    if let Some(cpu) = config.real_time.cpu {
        found.within(
            "real_time.cpu",
            cpu as f64,
            0.0..=1023.0,
            "`nproc --all` tells how many there are",
        );
    }
    interface(config, &mut found);
    super::check_profile::profile(&config.profile, &mut found);
    found.limits("limits", &config.limits);
    for (k, drive) in config.drive.iter().enumerate() {
        if let Some(limits) = &drive.limits {
            found.limits(&format!("drive[{k}].limits"), limits);
        }
    }
    drives(config, &mut found);
    found.mistakes
}

#[derive(Default)]
pub(super) struct Found {
    mistakes: Vec<String>,
}

impl Found {
    pub fn say(&mut self, text: String) {
        self.mistakes.push(text);
    }

    pub fn within(&mut self, key: &str, value: f64, range: RangeInclusive<f64>, mend: &str) {
        if !range.contains(&value) {
            let (low, high) = range.into_inner();
            self.say(format!("{key} = {value}, allowed {low} to {high}: {mend}"));
        }
    }

    fn limits(&mut self, at: &str, l: &Limits) {
        for (name, value, low, high, mend) in limits(l) {
            self.within(&format!("{at}.{name}"), value, low..=high, mend);
        }
        if l.position_min >= l.position_max {
            let (low, high) = (l.position_min, l.position_max);
            self.say(format!(
                "{at}.position_min_rad = {low} is not below position_max_rad = {high}: swap them"
            ));
        }
    }
}

/// A number of the configuration: key, value, smallest and largest, how to mend it.
type Row<'a> = (&'a str, f64, f64, f64, &'a str);

/// Numbers that stand once in the file.
#[rustfmt::skip]
fn numbers(c: &Config) -> [Row<'_>; 16] {
    let (b, r, s, w) = (&c.bus, &c.real_time, &c.safety, &c.recorder);
    [
        ("bus.reply_timeout_us", b.reply_timeout_us.into(), 20.0, 10_000.0,
         "well below the cycle time, so that the rest of the cycle has its time"),
        ("bus.lockstep_timeout_ms", b.lockstep_timeout_ms.into(), 1.0, 10_000.0,
         "real time that a lockstep cycle waits before it calls its frame lost"),
        ("bus.watchdog_ms", b.watchdog_ms.into(), 1.0, 6000.0,
         "a few cycles, below the drive's own watchdog"),
        ("bus.state_timeout_ms", b.state_timeout_ms.into(), 10.0, 60_000.0,
         "what the slowest drive takes to change its state"),
        ("bus.sync0_shift_us", b.sync0_shift_us.into(), 0.0, 10_000.0,
         "phase of SYNC0 within the cycle"),
        ("real_time.priority", r.priority.into(), 0.0, 99.0, "0 asks for no priority"),
        ("real_time.spin_us", r.spin_us.into(), 0.0, 1000.0,
         "spinning for whole cycles is throttled by the kernel"),
        ("safety.lost_frame_limit", s.lost_frame_limit.into(), 1.0, 1000.0,
         "cycles without a reply, one after the other"),
        ("safety.working_counter_limit", s.working_counter_limit.into(), 1.0, 1000.0,
         "cycles with a short working counter, one after the other"),
        ("safety.speed_cycles", s.speed_cycles.into(), 1.0, 64.0, "cycles of the mean speed"),
        ("safety.frozen_cycles", s.frozen_cycles.into(), 2.0, 4000.0,
         "cycles with the same counts"),
        ("safety.frozen_motion_rad", s.frozen_motion_rad, 1e-9, 1.0,
         "motion of the reference in which an encoder must have moved"),
        ("safety.overrun_us", s.overrun_us.into(), 1.0, 1_000_000.0, "how late a cycle may begin"),
        ("safety.ramp_ms", s.ramp_ms.into(), 0.0, 10_000.0, "how long a ramp takes"),
        ("recorder.keep_s", w.keep_s, 0.0, 60.0, "kept before a trip"),
        ("recorder.buffer_cycles", w.buffer_cycles as f64, 64.0, 1e6,
         "rows that wait for the writer, 4000 are a second"),
    ]
}

/// Limits of an axis, by the names that they have in their table.
#[rustfmt::skip]
fn limits(l: &Limits) -> [Row<'_>; 6] {
    [
        ("torque_N_m", l.torque, 1e-3, 1e4, "the largest torque of this axis"),
        ("speed_rad_per_s", l.speed, 1e-3, 1e3, "the highest speed"),
        ("position_min_rad", l.position_min, -10.0, 10.0, "lower end of the angle"),
        ("position_max_rad", l.position_max, -10.0, 10.0, "upper end of the angle"),
        ("following_error_rad", l.following_error, 1e-6, 10.0, "the largest error"),
        ("jump_rad", l.jump, 1e-6, 1.0, "the largest change in one cycle"),
    ]
}

fn interface(config: &Config, found: &mut Found) {
    let name = &config.bus.interface;
    if name.is_empty() || name.len() > 15 {
        found.say(format!(
            "bus.interface = {name:?}, allowed 1 to 15 characters: `ip link` lists the names"
        ));
    }
}

fn drives(config: &Config, found: &mut Found) {
    if config.drive.len() != AXES {
        found.say(format!(
            "drive: {} of them, wanted {AXES}: one [[drive]] for each axis",
            config.drive.len()
        ));
        return;
    }
    for (k, drive) in config.drive.iter().enumerate() {
        if drive.direction != 1 && drive.direction != -1 {
            found.say(format!("drive[{k}].direction = {}, allowed 1 or -1", drive.direction));
        }
        found.within(
            &format!("drive[{k}].position"),
            drive.position.into(),
            0.0..=15.0,
            "place on the cable, the first is 0",
        );
        if config.drive[..k].iter().any(|d| d.position == drive.position) {
            found.say(format!(
                "drive[{k}].position = {}: another drive has it: give each its own",
                drive.position
            ));
        }
    }
}
