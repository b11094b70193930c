//! Limits that contradict each other, the cycle time, or the stroke of the machine.

use flexhex_system::{Component, System};

use crate::config::{Config, Limits, AXES};
use crate::mismatch::Mismatch;

/// Encoder resolution, an object of the drive.
const ENCODER: u16 = 0x608f;

/// Err with every contradiction: keys, values, remedy.
pub fn check(config: &Config, system: &System) -> Result<(), Mismatch> {
    let host = system.component(&config.system.host);
    let stroke = host.and_then(|host: &Component| host.parameter("stroke"));
    let mut wrong = contradictions(config, system.base_step());
    for (axis, l) in once(config) {
        if let Some(stroke) = stroke.filter(|s| l.position_min < -s || l.position_max > *s) {
            let own = config.drive[axis].limits.is_some();
            let at = if own { format!("drive[{axis}].limits") } else { "limits".to_owned() };
            wrong.push(format!(
                "{at}: position limits {} to {} rad: the stroke ends at -{stroke} and {stroke} \
                 rad, so the rule could not trip before the end stop: set position_min_rad and \
                 position_max_rad inside",
                l.position_min, l.position_max
            ));
        }
    }
    match wrong.is_empty() {
        true => Ok(()),
        false => Err(Mismatch::Limits(wrong)),
    }
}

fn contradictions(config: &Config, base_step: f64) -> Vec<String> {
    let (b, s) = (&config.bus, &config.safety);
    let watchdog = f64::from(b.watchdog_ms) * 1e-3;
    let lost = f64::from(s.lost_frame_limit) * base_step;
    let mut wrong = Vec::new();
    if lost >= watchdog {
        wrong.push(format!(
            "safety.lost_frame_limit = {} cycles last {} ms, but bus.watchdog_ms = {}: the drives would \
             stop before the gateway: lower one or raise the other",
            s.lost_frame_limit,
            lost * 1e3,
            b.watchdog_ms
        ));
    }
    if f64::from(s.overrun_us) * 1e-6 > watchdog {
        wrong.push(format!(
            "safety.overrun_us = {} is longer than bus.watchdog_ms = {}: the drives would stop before \
             the gateway: lower one or raise the other",
            s.overrun_us, b.watchdog_ms
        ));
    }
    if config.profile.unchecked.contains(&ENCODER) && config.landing.rest.is_none() {
        wrong.push(
            "profile.unchecked = [0x608f] leaves the encoder scale out, and without landing.rest_rad nothing \
             else would show a wrong one: measure the rest pose by another means and set it"
                .to_owned(),
        );
    }
    for (_, l) in once(config) {
        wrong.extend(of_axis(l, s.frozen_motion_rad, base_step));
        wrong.extend(of_landing(config, l));
    }
    for (axis, rest) in config.landing.rest.iter().flatten().enumerate() {
        let l = config.limits(axis);
        let (low, high) = (l.position_min - l.following_error, l.position_max + l.following_error);
        if !(low..=high).contains(rest) {
            wrong.push(format!(
                "landing.rest_rad[{axis}] = {rest} is outside {low:.3} to {high:.3} rad, the position limits with \
                 following_error_rad: no drive could be enabled: correct the one or the other"
            ));
        }
    }
    wrong
}

/// Lift-off and landing against the limits that are judged in them, and what a drive can be told.
fn of_landing(config: &Config, l: &Limits) -> Vec<String> {
    let (landing, most) = (&config.landing, config.profile.scale.tau_step() * f64::from(i16::MAX));
    let mut wrong = Vec::new();
    for (what, value, name, limit, why) in [
        (
            "landing.torque_N_m",
            landing.torque,
            "limits.torque_N_m",
            l.torque,
            "`torque` would trip in a landing",
        ),
        (
            "landing.speed_rad_per_s",
            landing.speed,
            "limits.speed_rad_per_s",
            l.speed,
            "`speed` would trip in a lift-off",
        ),
        (
            "limits.torque_N_m",
            l.torque,
            "the largest 0x6071",
            most,
            "no drive can be told so: is the unit N m?",
        ),
    ] {
        if value > limit {
            wrong.push(format!("{what} = {value} is above {name} = {limit:.6}: {why}: lower it"));
        }
    }
    wrong
}

/// Limits that axes share once, with their first axis: each contradiction is reported once.
fn once(config: &Config) -> Vec<(usize, &Limits)> {
    let mut seen: Vec<(usize, &Limits)> = Vec::new();
    for axis in 0..AXES {
        let l = config.limits(axis);
        if !seen.iter().any(|(_, known)| std::ptr::eq(*known, l)) {
            seen.push((axis, l));
        }
    }
    seen
}

fn of_axis(l: &Limits, frozen_motion: f64, base_step: f64) -> Vec<String> {
    let mut wrong = Vec::new();
    let step = l.speed * base_step;
    if l.jump < step {
        wrong.push(format!(
            "limits.jump_rad = {} is less than {step} rad, the motion of one cycle at \
             limits.speed_rad_per_s = {}: the rule `jump` would trip at a permitted speed: raise \
             jump_rad or lower the speed",
            l.jump, l.speed
        ));
    }
    if frozen_motion >= l.following_error {
        wrong.push(format!(
            "safety.frozen_motion_rad = {frozen_motion} is not below limits.following_error_rad = {}: \
             the rule `frozen_encoder` could never trip: lower frozen_motion_rad",
            l.following_error
        ));
    }
    let span = l.position_max - l.position_min;
    if l.following_error >= span {
        wrong.push(format!(
            "limits.following_error_rad = {} is not below the {span} rad between position_min_rad and \
             position_max_rad: the rule `following_error` could never trip: lower it",
            l.following_error
        ));
    }
    wrong
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    const STEP: f64 = 0.00025;

    fn config() -> Config {
        parse(include_str!("../machines/akd.toml")).unwrap()
    }

    fn outside(bend: impl Fn(&mut Config)) -> Vec<String> {
        let mut config = config();
        bend(&mut config);
        contradictions(&config, STEP)
    }

    #[test]
    fn the_template_does_not_contradict_itself() {
        assert_eq!(outside(|_| ()), Vec::<String>::new());
    }

    #[test]
    fn each_contradiction_is_named_on_its_side_of_the_bound() {
        let one = |bend: fn(&mut Config), wanted: &str| {
            let all = outside(bend);
            assert!(all.len() == 1 && all[0].contains(wanted), "{wanted}: {all:?}");
        };
        let none = |bend: fn(&mut Config)| assert_eq!(outside(bend), Vec::<String>::new());
        // 5 ms are 20 cycles
        one(|c| c.safety.lost_frame_limit = 20, "lost_frame_limit = 20 cycles last 5 ms");
        none(|c| c.safety.lost_frame_limit = 19);
        one(|c| c.safety.overrun_us = 5001, "overrun_us = 5001");
        none(|c| c.safety.overrun_us = 5000);
        // 3 rad/s move 0.75 mrad in a cycle
        one(|c| c.limits.jump = 0.0007, "limits.jump_rad = 0.0007 is less than 0.00075");
        none(|c| c.limits.jump = 0.00075);
        one(|c| c.safety.frozen_motion_rad = 0.05, "frozen_motion_rad = 0.05");
        one(|c| c.profile.unchecked = vec![0x608f], "without landing.rest_rad");
        none(|c| (c.profile.unchecked, c.landing.rest) = (vec![0x608f], Some([-0.3; 6])));
        one(|c| c.limits.following_error = 1.5, "following_error_rad = 1.5");
        one(
            |c| c.landing.torque = 27.1,
            "landing.torque_N_m = 27.1 is above limits.torque_N_m = 27",
        );
        one(|c| c.landing.speed = 3.1, "landing.speed_rad_per_s = 3.1 is above");
        // 16 bits of 3 mN m
        one(
            |c| c.limits.torque = 98.4,
            "limits.torque_N_m = 98.4 is above the largest 0x6071 = 98.301",
        );
        none(|c| c.limits.torque = 98.3);
        one(
            |c| c.landing.rest = Some([0.0, 0.0, 0.58, 0.0, 0.0, 0.0]),
            "landing.rest_rad[2] = 0.58",
        );
        none(|c| c.landing.rest = Some([-0.56; 6]));
    }

    #[test]
    fn an_axis_with_limits_of_its_own_is_judged_by_them() {
        let own = |jump| {
            outside(|c| {
                let limits = crate::config::Limits { jump, ..c.limits.clone() };
                c.drive[3].limits = Some(limits);
            })
        };
        assert_eq!(own(0.0001).len(), 1);
        assert!(own(0.01).is_empty());
    }
}
