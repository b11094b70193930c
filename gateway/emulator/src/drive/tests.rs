//! Quantisation, limits and objects of a drive.
use super::*;

pub fn setting(kind: Kind) -> Setting {
    Setting {
        braking: 0.0,
        kind,
        torque_constant: 3.0,
        rated_torque_mnm: 9000,
        limit: if kind == Kind::Akd { 9000 } else { 3000 },
        counts_per_rev: 4_294_967_296.0,
        direction: 1,
        offset: 0,
    }
}

fn enabled(setting: Setting) -> Drive {
    let mode = setting.kind.torque_mode();
    let mut drive = Drive::new(setting, State::SwitchOnDisabled, 0);
    drive.set(kind::MODE, &[mode as u8]);
    for word in [6u16, 7, 15] {
        drive.set(kind::CONTROLWORD, &word.to_le_bytes());
        drive.act();
    }
    assert_eq!(drive.machine.state, State::OperationEnabled);
    drive
}

#[test]
fn a_current_comes_out_as_its_exact_multiple_of_the_step() {
    let mut drive = enabled(setting(Kind::Akd));
    for current in [-8999i32, -1, 0, 1, 4321, 9000] {
        drive.set(kind::TARGET_CURRENT, &current.to_le_bytes());
        assert_eq!(drive.torque(), f64::from(current) * (3.0 * 0.001));
        drive.measure(0.0, drive.torque(), None);
        assert_eq!(drive.value(kind::CURRENT), Some(i64::from(current)));
    }
    drive.set(kind::TARGET_CURRENT, &20_000i32.to_le_bytes());
    assert_eq!(drive.torque(), 9000.0 * (3.0 * 0.001), "the peak current limits");
}

#[test]
fn an_angle_comes_back_exactly_whatever_direction_and_offset() {
    for (direction, offset) in [(1, 0), (-1, 12_345), (1, -2_000_000_000)] {
        let mut drive = enabled(Setting { direction, offset, ..setting(Kind::Akd) });
        let step = drive.setting.angle_step();
        for steps in [-400_000_000i64, -1, 0, 7, 399_999_999] {
            drive.measure(steps as f64 * step, 0.0, None);
            let shown = drive.value(kind::POSITION_INTERNAL).unwrap() as i32;
            let back = (shown as i64 - offset) * direction;
            assert_eq!(back as i32, steps as i32);
        }
    }
}

#[test]
fn the_generic_drive_counts_per_mille_of_its_rated_torque() {
    let mut drive = enabled(setting(Kind::Cst));
    drive.set(kind::TARGET_TORQUE, &(-123i16).to_le_bytes());
    assert_eq!(drive.torque(), -123.0 * (9000.0 * 0.001 * 0.001));
    drive.measure(0.0, drive.torque(), None);
    assert_eq!(drive.upload(kind::TORQUE, 0), Ok((-123i16).to_le_bytes().to_vec()));
    assert_eq!(drive.upload(kind::RATED_TORQUE, 0), Ok(9000u32.to_le_bytes().to_vec()));
    assert_eq!(drive.upload(kind::SUPPORTED_MODES, 0), Ok(vec![0x80, 3, 0, 0]));
}

#[test]
fn the_wrong_mode_or_a_fault_gives_no_torque() {
    let mut drive = enabled(setting(Kind::Akd));
    drive.set(kind::TARGET_CURRENT, &100i32.to_le_bytes());
    drive.set(kind::MODE, &[8]);
    drive.act();
    assert_eq!((drive.torque(), drive.value(kind::MODE_DISPLAY)), (0.0, Some(8)));
    drive.set(kind::MODE, &[10]);
    drive.act();
    assert_eq!(drive.value(kind::MODE_DISPLAY), Some(8), "an AKD has no mode 10");
    drive.set(kind::MODE, &[4]);
    drive.act();
    assert!(drive.torque() > 0.0);
    drive.machine.raise(0x7305);
    assert_eq!((drive.torque(), drive.value(kind::ERROR_CODE)), (0.0, Some(0x7305)));
}

#[test]
fn objects_refuse_with_the_right_code() {
    let mut drive = Drive::new(setting(Kind::Cst), State::SwitchOnDisabled, 0);
    assert_eq!(drive.upload(kind::CURRENT, 0), Err(abort::NO_OBJECT), "only the AKD has it");
    assert_eq!(drive.upload(kind::STATUSWORD, 1), Err(abort::NO_SUBINDEX));
    assert_eq!(drive.download(kind::STATUSWORD, 0, &[0, 0]), Err(abort::READ_ONLY));
    assert_eq!(drive.download(kind::CONTROLWORD, 0, &[0]), Err(abort::LENGTH));
    assert_eq!(drive.download(kind::MODE, 0, &[4]), Err(abort::VALUE_RANGE));
    assert_eq!(drive.download(kind::CONTROLWORD, 0, &[6, 0]), Ok(()));
    assert_eq!(drive.machine.state, State::ReadyToSwitchOn);
}

#[test]
fn velocity_is_in_mrpm_of_the_last_step() {
    let mut drive = enabled(setting(Kind::Akd));
    drive.measure(0.0, 0.0, None);
    drive.measure(0.001, 0.0, Some(0.00025));
    // 4 rad/s
    assert_eq!(drive.value(kind::VELOCITY), Some(38_197));
}
