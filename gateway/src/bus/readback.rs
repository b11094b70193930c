//! What a drive says about its encoder, gear, polarity, modes and torque, compared before power.

use super::difference::Difference;
use super::sdo::{read, read_if_there, Device, SdoError};
use crate::config::{Config, Scale};

const POLARITY: u16 = 0x607e;
const RATED_CURRENT: u16 = 0x6075;
const RATED_TORQUE: u16 = 0x6076;
const ENCODER: u16 = 0x608f;
const GEAR: u16 = 0x6091;
const SUPPORTED_MODES: u16 = 0x6502;
/// The counts of one revolution that do not fit into 0x608F.
const LARGEST: f64 = 4_294_967_296.0;

/// Every value of a drive that contradicts the profile. Reads only.
pub async fn differences(
    config: &Config,
    device: &Device<'_>,
) -> Result<Vec<Difference>, SdoError> {
    let p = &config.profile;
    let judged = |object: u16| !p.unchecked.contains(&object);
    let mut differences = Vec::new();
    if judged(ENCODER) {
        differences.extend(encoder(p.counts_per_revolution, device).await?);
    }
    if judged(GEAR) {
        let motor: Option<u32> = read_if_there(device, GEAR, 1).await?;
        let shaft: Option<u32> = read_if_there(device, GEAR, 2).await?;
        if let (Some(motor), Some(shaft)) = (motor, shaft) {
            if motor != shaft {
                let mend =
                    "angles and torques would be scaled twice: set 1:1 in the drive and put \
                            the gear into counts_per_revolution and scale";
                let actual = format!("{motor}:{shaft}");
                differences.push(Difference::new("gear ratio 0x6091", actual, "1:1", mend));
            }
        }
    }
    if judged(POLARITY) {
        if let Some(bits @ 1..) = read_if_there::<u8>(device, POLARITY, 0).await? {
            let mend = "set 0 in the drive; the sign of an axis is drive.direction alone";
            differences.push(Difference::new(
                "polarity 0x607e",
                format!("{bits:#04x}"),
                "0x00",
                mend,
            ));
        }
    }
    if judged(SUPPORTED_MODES) {
        if let Some(modes) = read_if_there::<u32>(device, SUPPORTED_MODES, 0).await? {
            let wanted = 1u32 << (p.mode - 1);
            if modes & wanted == 0 {
                differences.push(Difference::new(
                    "bits of the supported modes 0x6502",
                    format!("{modes:#010x}"),
                    format!("{wanted:#010x} among them (mode {})", p.mode),
                    "set profile.mode to a torque mode that the drive has",
                ));
            }
        }
    }
    if judged(RATED_CURRENT) {
        differences.extend(torque_constant(&p.scale, device).await?);
    }
    if let (Scale::RatedTorque { rated_torque, .. }, true) = (&p.scale, judged(RATED_TORQUE)) {
        let (rated, expected): (u32, _) =
            (read(device, RATED_TORQUE, 0).await?, (rated_torque * 1000.0).round());
        if f64::from(rated) != expected {
            differences.push(Difference::new(
                "rated torque 0x6076",
                format!("{rated} mN m"),
                format!("{expected} mN m"),
                "set profile.scale.rated_torque.rated_torque_N_m or the drive",
            ));
        }
    }
    Ok(differences)
}

/// The drive's own torque per ampere, 0x6076 [mN m] / 0x6075 [mA], where it is scaled in ampere and has both. Rated
/// values are rounded, and a motor has less torque at its rated current: only another kind of ampere is refused.
async fn torque_constant(
    scale: &Scale,
    device: &Device<'_>,
) -> Result<Option<Difference>, SdoError> {
    let Scale::Current { torque_constant, .. } = scale else { return Ok(None) };
    let [torque, current] = rated(device).await?;
    // 0: nobody has set it
    let (Some(torque @ 1..), Some(current @ 1..)) = (torque, current) else { return Ok(None) };
    let actual = f64::from(torque) / f64::from(current);
    let mend = "peak and rms ampere differ by 1.41: set torque_constant_N_m_per_A in profile.scale as the drive's \
                current is defined, or the rated values of the drive; `calibrate torque` measures it. If only they are \
                wrong, profile.unchecked = [0x6075]";
    let what = "torque constant 0x6076 / 0x6075";
    let differs = !scale.agrees(actual);
    Ok(differs.then(|| {
        Difference::new(
            what,
            format!("{actual:.3} N m/A"),
            format!("{torque_constant} N m/A"),
            mend,
        )
    }))
}

/// Rated torque [mN m] and rated current [mA] of a drive that has them.
async fn rated(device: &Device<'_>) -> Result<[Option<u32>; 2], SdoError> {
    let torque = read_if_there(device, RATED_TORQUE, 0).await?;
    Ok([torque, read_if_there(device, RATED_CURRENT, 0).await?])
}

/// Why the torque constant of a drive that is scaled in ampere is not compared; None where it is, or is not to be.
pub async fn uncompared(config: &Config, device: &Device<'_>) -> Result<Option<String>, SdoError> {
    let in_ampere = matches!(config.profile.scale, Scale::Current { .. });
    if !in_ampere || config.profile.unchecked.contains(&RATED_CURRENT) {
        return Ok(None);
    }
    let names = [(RATED_TORQUE, "rated torque"), (RATED_CURRENT, "rated current")];
    let missing =
        names.into_iter().zip(rated(device).await?).filter_map(|((object, name), value)| {
            let what = match value {
                None => "not in the drive",
                Some(0) => "0",
                Some(_) => return None,
            };
            Some(format!("{name} {object:#06x} is {what}"))
        });
    let missing: Vec<_> = missing.collect();
    Ok((!missing.is_empty()).then(|| {
        format!(
            "torque constant not compared, {}: compare torque_constant_N_m_per_A with the data sheet (peak or rms \
             ampere), `calibrate torque` measures it",
            missing.join(" and ")
        )
    }))
}

/// Counts of one revolution: 0x608F:1 / 0x608F:2. Kollmorgen AKD: 2^FB1.PSCALE.
async fn encoder(expected: f64, device: &Device<'_>) -> Result<Option<Difference>, SdoError> {
    let what = "counts of one revolution 0x608f";
    let counts: Option<u32> = read_if_there(device, ENCODER, 1).await?;
    let turns: Option<u32> = read_if_there(device, ENCODER, 2).await?;
    let Some(counts) = counts else {
        let mend = "check by hand that one revolution gives profile.counts_per_revolution counts, \
                    then set profile.unchecked = [0x608F]";
        return Ok(Some(Difference::new(what, "not in the drive", expected, mend)));
    };
    let actual = match counts {
        // 2^32 does not fit into 32 bits
        0 | u32::MAX => LARGEST,
        counts => f64::from(counts) / f64::from(turns.unwrap_or(1).max(1)),
    };
    let mend =
        "set the encoder scale of the drive (Kollmorgen AKD: FB1.PSCALE, the power of two), \
                or profile.counts_per_revolution if the drive is right";
    Ok((actual != expected).then(|| Difference::new(what, actual, expected, mend)))
}
