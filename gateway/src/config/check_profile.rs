//! Checks the profile of a drive.

use super::mistakes::Mistakes;
use super::{startup, Pdo, Profile, Role, Scale};

/// Mistakes of a profile.
pub(super) fn profile(p: &Profile, mistakes: &mut Mistakes) {
    // in any other mode of CiA 402 the drive would go for a position or a speed that nobody sends
    if !matches!(p.mode, i8::MIN..=-1 | 4 | 10) {
        mistakes.add(format!(
            "profile.mode = {}: no torque mode: allowed 4 (torque), 10 (cyclic synchronous torque), or a \
             negative mode of the maker",
            p.mode
        ));
    }
    mistakes.check_range(
        "profile.counts_per_revolution",
        p.counts_per_revolution,
        1.0..=4_294_967_296.0,
        "counts of the position object in one revolution",
    );
    scale(&p.scale, mistakes);
    startup::check("profile.startup", &p.startup, &p.sent(), mistakes);
    pdos(
        "profile.rx",
        &p.rx,
        &[Role::Controlword, Role::TargetTorque],
        &[Role::Mode, Role::Unused, Role::Gap],
        mistakes,
    );
    pdos(
        "profile.tx",
        &p.tx,
        &[Role::Statusword, Role::Position, Role::ActualTorque],
        &[Role::ModeDisplay, Role::ErrorCode, Role::Unused, Role::Gap],
        mistakes,
    );
}

fn scale(s: &Scale, mistakes: &mut Mistakes) {
    match s {
        Scale::Current { step, torque_constant } => {
            mistakes.check_range(
                "profile.scale.current.step_mA",
                *step,
                1e-3..=1e4,
                "current of one count",
            );
            mistakes.check_range(
                "profile.scale.current.torque_constant_N_m_per_A",
                *torque_constant,
                1e-4..=1e3,
                "N m per A, as the drive's current is defined (peak or rms)",
            );
        }
        Scale::RatedTorque { step, rated_torque } => {
            mistakes.check_range(
                "profile.scale.rated_torque.step_per_mille",
                *step,
                1e-3..=1e3,
                "per mille of the rated torque for one count",
            );
            mistakes.check_range(
                "profile.scale.rated_torque.rated_torque_N_m",
                *rated_torque,
                1e-3..=1e4,
                "object 0x6076 of the drive",
            );
        }
    }
}

fn pdos(at: &str, pdos: &[Pdo], needed: &[Role], also: &[Role], mistakes: &mut Mistakes) {
    let entries = || pdos.iter().flat_map(|p| &p.entries);
    for role in needed {
        let n = entries().filter(|e| e.role == *role).count();
        if n != 1 {
            mistakes.add(format!("{at}: {n} entries have the role {role:?}, expected 1"));
        }
    }
    for e in entries() {
        if !needed.contains(&e.role) && !also.contains(&e.role) {
            mistakes.add(format!(
                "{at}: role {:?} belongs to the other direction (rx: to the drive, tx: from it)",
                e.role
            ));
        }
        if ![8, 16, 32].contains(&e.bits) {
            mistakes.add(format!("{at}: {:?} has bits = {}, allowed 8, 16 or 32", e.role, e.bits));
        }
        if (e.object == 0) != (e.role == Role::Gap) {
            mistakes.add(format!(
                "{at}: {:?} has object = {:#06x}: only a gap has object 0",
                e.role, e.object
            ));
        }
    }
}
