//! Mistakes in what is said of a kind of drive.

use super::check::Found;
use super::{Pdo, Profile, Role, Scale};

/// Mistakes of a profile.
pub(super) fn profile(p: &Profile, found: &mut Found) {
    found.within(
        "profile.mode",
        p.mode.into(),
        1.0..=10.0,
        "4 is torque, 10 cyclic synchronous torque",
    );
    found.within(
        "profile.counts_per_revolution",
        p.counts_per_revolution,
        1.0..=4_294_967_296.0,
        "counts of the position object in one turn",
    );
    match &p.scale {
        Scale::Current { step, torque_constant } => {
            found.within(
                "profile.scale.current.step_mA",
                *step,
                1e-3..=1e4,
                "current of one count",
            );
            found.within(
                "profile.scale.current.torque_constant_N_m_per_A",
                *torque_constant,
                1e-4..=1e3,
                "N m per A, as the drive's current is defined (peak or rms)",
            );
        }
        Scale::RatedTorque { step, rated_torque } => {
            found.within(
                "profile.scale.rated_torque.step_per_mille",
                *step,
                1e-3..=1e3,
                "share of the rated torque that one count is",
            );
            found.within(
                "profile.scale.rated_torque.rated_torque_N_m",
                *rated_torque,
                1e-3..=1e4,
                "object 0x6076 of the drive",
            );
        }
    }
    pdos(
        "profile.rx",
        &p.rx,
        &[Role::Controlword, Role::TargetTorque],
        &[Role::Mode, Role::Unused, Role::Gap],
        found,
    );
    pdos(
        "profile.tx",
        &p.tx,
        &[Role::Statusword, Role::Position, Role::ActualTorque],
        &[Role::ModeDisplay, Role::ErrorCode, Role::Unused, Role::Gap],
        found,
    );
}

fn pdos(at: &str, pdos: &[Pdo], needed: &[Role], also: &[Role], found: &mut Found) {
    let entries = || pdos.iter().flat_map(|p| &p.entries);
    for role in needed {
        let n = entries().filter(|e| e.role == *role).count();
        if n != 1 {
            found.say(format!("{at}: {n} entries have the role {role:?}, wanted 1"));
        }
    }
    for e in entries() {
        if !needed.contains(&e.role) && !also.contains(&e.role) {
            found.say(format!("{at}: role {:?} belongs to the other direction", e.role));
        }
        if ![8, 16, 32].contains(&e.bits) {
            found.say(format!("{at}: {:?} has bits = {}, allowed 8, 16 or 32", e.role, e.bits));
        }
        if (e.object == 0) != (e.role == Role::Gap) {
            found.say(format!(
                "{at}: {:?} has object = {:#06x}: only a gap has none",
                e.role, e.object
            ));
        }
    }
}
