//! The start-up list of a drive: what differs, writing it, storing it in the drive.

use std::time::Duration;

use super::difference::Difference;
use super::sdo::{read_integer, write, write_integer, Device, SdoError};
use crate::config::{Config, Kind, Sdo};

const PERIOD: u16 = 0x60c2;
const SYNC_TYPE: u16 = 0x1c32;
const SYNC0: i64 = 2;
const STORE: u16 = 0x1010;
/// `save` in ASCII [CiA 301].
const SAVE: u32 = 0x6576_6173;

/// The list of an axis: what follows from the cycle, the profile's, and those of the drive itself.
/// The later replaces the earlier of the same object.
pub fn list(config: &Config, axis: usize, cycle: Duration, synced: bool) -> Vec<Sdo> {
    let mut all = computed(cycle, synced);
    all.retain(|sdo| !config.profile.unchecked.contains(&sdo.object));
    for sdo in config.profile.startup.iter().chain(&config.drive[axis].startup) {
        all.retain(|before| !before.same_object(sdo));
        all.push(sdo.clone());
    }
    all
}

/// Cycle time and synchronisation, for drives that have these objects.
fn computed(cycle: Duration, synced: bool) -> Vec<Sdo> {
    let (mut units, mut exponent) = (cycle.as_nanos() as i64, -9);
    while units % 10 == 0 && units > 0 {
        (units, exponent) = (units / 10, exponent + 1);
    }
    let sdo = |object, sub, kind, value, name: &str| Sdo {
        object,
        sub,
        kind,
        value,
        name: name.to_owned(),
        optional: true,
        read_only: false,
    };
    let mut all = Vec::new();
    if units <= u8::MAX.into() {
        all.push(sdo(PERIOD, 1, Kind::U8, units, "cycle time"));
        all.push(sdo(PERIOD, 2, Kind::I8, exponent, "power of ten of the cycle time"));
    }
    if synced {
        all.push(sdo(SYNC_TYPE, 1, Kind::U16, SYNC0, "synchronisation type, 2: SYNC0"));
    }
    all
}

/// Objects of the list that differ in the drive. Reads only.
pub async fn differences(device: &Device<'_>, list: &[Sdo]) -> Result<Vec<Difference>, SdoError> {
    let mut differences = Vec::new();
    for sdo in list {
        differences
            .extend(compare(device, sdo, "written by `run` and `check --bus --write`").await?);
    }
    Ok(differences)
}

async fn compare(
    device: &Device<'_>,
    sdo: &Sdo,
    mend: &str,
) -> Result<Option<Difference>, SdoError> {
    let actual = match read_integer(device, (sdo.object, sdo.sub), sdo.kind).await? {
        Some(actual) if actual == sdo.value => return Ok(None),
        None if sdo.optional => return Ok(None),
        Some(actual) => actual.to_string(),
        None => "not in the drive".to_owned(),
    };
    let mend = match (actual.as_str(), sdo.read_only) {
        ("not in the drive", _) => "remove it from the start-up list or set optional = true",
        (_, true) => "set the drive, or correct the start-up list (it is read_only there)",
        _ => mend,
    };
    Ok(Some(Difference::new(sdo.label(), actual, sdo.value, mend)))
}

/// Write what differs and read it back; what differs afterwards is returned.
pub async fn apply(device: &Device<'_>, list: &[Sdo]) -> Result<Vec<Difference>, SdoError> {
    let mut differences = Vec::new();
    let mut refusals: Vec<Option<SdoError>> = vec![None; list.len()];
    // twice: a drive may refuse an object until its partner is written (0x60C2)
    for _ in 0..2 {
        for (sdo, refusal) in list.iter().zip(&mut refusals) {
            let differs = compare(device, sdo, "").await?.is_some();
            if differs && !sdo.read_only {
                let at = (sdo.object, sdo.sub);
                *refusal = write_integer(device, at, sdo.kind, sdo.value).await.err();
            }
        }
    }
    for (sdo, refusal) in list.iter().zip(&refusals) {
        let mend = match refusal {
            Some(why) => {
                format!("{why}: correct the start-up list, or set it with the drive's tool")
            }
            None => "the drive took it and holds another value: compare with its manual".to_owned(),
        };
        differences.extend(compare(device, sdo, &mend).await?);
    }
    Ok(differences)
}

/// Store all parameters in the drive, so that they outlast its power.
pub async fn store(device: &Device<'_>) -> Result<(), SdoError> {
    write(device, STORE, 1, SAVE).await
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    fn period(us: u64) -> Vec<(u8, i64)> {
        let all = computed(Duration::from_micros(us), false);
        all.iter().map(|sdo| (sdo.sub, sdo.value)).collect()
    }

    #[test]
    fn cycle_times_are_units_and_a_power_of_ten() {
        assert_eq!(period(250), [(1, 25), (2, -5)]);
        assert_eq!(period(125), [(1, 125), (2, -6)]);
        assert_eq!(period(1000), [(1, 1), (2, -3)]);
        assert_eq!(period(1001), [], "1001 units do not fit into 8 bits");
    }

    #[test]
    fn the_list_of_a_drive_replaces_that_of_the_profile_and_the_computed_one() {
        let mut config = parse(include_str!("../../machines/akd.toml")).unwrap();
        let mut own = config.profile.startup[0].clone();
        own.value = 77;
        let sync = Sdo { object: SYNC_TYPE, sub: 1, value: 1, ..own.clone() };
        config.drive[2].startup = vec![own.clone(), sync];
        let all = list(&config, 2, Duration::from_micros(250), true);
        let values = |object| -> Vec<i64> {
            all.iter().filter(|sdo| sdo.object == object).map(|sdo| sdo.value).collect()
        };
        assert_eq!(values(own.object), [77]);
        assert_eq!(values(SYNC_TYPE), [1]);
        assert_eq!(values(PERIOD), [25, -5]);
        config.profile.unchecked = vec![PERIOD];
        let all = list(&config, 0, Duration::from_micros(250), true);
        assert!(all.iter().all(|sdo| sdo.object != PERIOD && sdo.value != 77));
    }
}
