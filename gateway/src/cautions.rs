//! What the configuration may choose but a lab should know: stops that may be worse than the fault, with what was
//! measured, and drives that may be exchanged.

use std::fmt::{self, Display, Formatter};

use crate::config::{Config, Homed};
use crate::rules::{ReactionKind, Reactions};

/// Rules that an encoder trips: what it shows afterwards is not true.
const OF_ENCODERS: [&str; 2] = ["jump", "frozen_encoder"];
/// Rules after which a drive does not hear or obey any more: of one axis, and of all or of unknown ones.
const OF_DRIVES: [&str; 4] = ["drive_fault", "drive_state", "mode", "measured_torque"];
const OF_THE_BUS: [&str; 3] = ["lost_frames", "working_counter", "al_state"];

/// Rules by name.
#[derive(Debug, PartialEq)]
pub enum Caution {
    /// `land` by the encoder that has just failed.
    Encoder(Vec<&'static str>),
    /// A stop that wants torque of a drive that is lost.
    Drive(Vec<&'static str>),
    /// The end of every run is a fall.
    Fall(Vec<&'static str>),
    /// Axes, from 1, whose drive may be any.
    AnyDrive(Vec<usize>),
    /// Nobody knows where the machine rests without power.
    NoRest,
}

/// All that hold for this configuration.
pub fn of(config: &Config) -> Vec<Caution> {
    let drives = config.drive.iter().enumerate();
    let any: Vec<_> = drives.filter(|(_, d)| d.serial.is_none()).map(|(k, _)| k + 1).collect();
    let mut all = of_reactions(&config.reactions);
    all.extend((!any.is_empty()).then_some(Caution::AnyDrive(any)));
    let rest = config.landing.rest.or(config.homed.as_ref().and_then(Homed::rest));
    all.extend(rest.is_none().then_some(Caution::NoRest));
    all
}

fn of_reactions(reactions: &Reactions) -> Vec<Caution> {
    let [damp, land] = [ReactionKind::Damp, ReactionKind::Land].map(|kind| reactions.with(kind));
    let powered = [damp, land.clone()].concat();
    let among = |all: &[&'static str], some: &[&str]| {
        all.iter().copied().filter(|name| some.contains(name)).collect::<Vec<_>>()
    };
    let fall = [ReactionKind::QuickStop, ReactionKind::Zero].map(|kind| reactions.with(kind));
    let all = [
        Caution::Encoder(among(&land, &OF_ENCODERS)),
        Caution::Drive([among(&powered, &OF_THE_BUS), among(&land, &OF_DRIVES)].concat()),
        Caution::Fall(among(&fall.concat(), &["stopped"])),
    ];
    all.into_iter().filter(|caution| !caution.rules().is_empty()).collect()
}

impl Caution {
    fn rules(&self) -> &[&'static str] {
        match self {
            Caution::Encoder(rules) | Caution::Drive(rules) | Caution::Fall(rules) => rules,
            Caution::AnyDrive(_) | Caution::NoRest => &[],
        }
    }
}

impl Display for Caution {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let rules = self.rules().join(", reactions.");
        match self {
            Caution::Encoder(_) => write!(
                f,
                "reactions.{rules} = land: the landing trusts the encoder that has just failed: use `damp`"
            ),
            Caution::Drive(_) => write!(
                f,
                "reactions.{rules}: a drive that is lost or does not obey cannot land: use `zero`, or `damp` \
                 where only the drive of one axis does not"
            ),
            Caution::AnyDrive(axes) => write!(
                f,
                "axes {axes:?} accept any drive: where two cables are exchanged, no rule sees it and the platform \
                 moves elsewhere: set drive.serial (`check --bus` shows them), or homing.file"
            ),
            Caution::NoRest => f.write_str(
                "it is not known where the machine rests: an encoder offset that is wrong is not seen before power: \
                 set landing.rest_rad, or home with `home --stops` or `home --rest`",
            ),
            Caution::Fall(_) => write!(
                f,
                "reactions.{rules}: at the end of every run the machine falls onto its stops: use `land`"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    const HOMED: &str =
        "date = 'today'\nmethod = 'pose'\npose_rad = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n\
        axis = [{ serial = 1, offset_counts = 0 }, { serial = 2, offset_counts = 0 }, \
        { serial = 3, offset_counts = 0 }, { serial = 4, offset_counts = 0 }, \
        { serial = 5, offset_counts = 0 }, { serial = 6, offset_counts = 0 }]";

    #[test]
    fn the_defaults_need_none_and_each_choice_has_its_own() {
        let chosen = |text: &str| of_reactions(&toml::from_str(text).unwrap());
        assert_eq!(chosen(""), []);
        assert_eq!(chosen("speed = 'damp'\nmode = 'damp'"), []);
        assert_eq!(chosen("stopped = 'zero'"), [Caution::Fall(vec!["stopped"])]);
        assert_eq!(chosen("jump = 'land'"), [Caution::Encoder(vec!["jump"])]);
        let lost = [Caution::Drive(vec!["lost_frames", "mode"])];
        assert_eq!(chosen("lost_frames = 'damp'\nmode = 'land'"), lost);
        let text = chosen("jump = 'land'\nfrozen_encoder = 'land'")[0].to_string();
        assert!(text.starts_with("reactions.jump, reactions.frozen_encoder = land: "), "{text}");
    }

    #[test]
    fn drives_without_a_serial_number_are_named() {
        let mut config = parse(include_str!("../machines/akd.toml")).unwrap();
        for (k, drive) in config.drive.iter_mut().enumerate() {
            drive.serial = Some(1000 + k as u32);
        }
        config.landing.rest = Some([-0.3; 6]);
        assert_eq!(of(&config), []);
        config.drive[2].serial = None;
        assert_eq!(of(&config), [Caution::AnyDrive(vec![3])]);
    }

    #[test]
    fn a_rest_pose_that_nobody_knows_is_said() {
        let mut config = parse(include_str!("../machines/akd.toml")).unwrap();
        assert!(of(&config).contains(&Caution::NoRest));
        config.homed = Some(Homed::parse(HOMED).unwrap());
        assert!(of(&config).contains(&Caution::NoRest), "a pose in a jig");
        let text =
            HOMED.replace("pose_rad", "rest_rad = [-0.3, -0.3, -0.3, -0.3, -0.3, -0.3]\npose_rad");
        config.homed = Some(Homed::parse(&text).unwrap());
        assert!(!of(&config).contains(&Caution::NoRest));
    }
}
