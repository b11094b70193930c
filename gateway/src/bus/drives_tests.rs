use super::*;
use crate::config::{parse, Config};

fn config(name: &str) -> Config {
    parse(match name {
        "akd" => include_str!("../../machines/akd.toml"),
        _ => include_str!("../../machines/cia402.toml"),
    })
    .unwrap()
}

/// Numbers spread over a range, always the same.
fn spread(n: usize, most: i32) -> impl Iterator<Item = i32> {
    let mut x = 1u64;
    (0..n).map(move |_| {
        x = x.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (x >> 33) as i32 % most
    })
}

#[test]
fn whole_steps_of_the_plant_come_back_as_the_same_counts() {
    let drives = Drives::new(&config("akd"));
    let step = 3.0 * 0.001;
    for k in spread(10_000, 9000) {
        let tau = step * f64::from(k);
        assert_eq!(drives.counts(0, tau), k);
        assert_eq!(drives.torque(0, k), tau);
    }
    let step = 2.0 * std::f64::consts::PI / 4294967296.0;
    for k in spread(10_000, 400_000_000) {
        assert_eq!(drives.angle(0, k), step * f64::from(k));
    }
}

#[test]
fn direction_and_offset_turn_both_ways() {
    let mut config = config("akd");
    config.drive[1].direction = -1;
    config.drive[1].offset_counts = i32::MAX - 10;
    let drives = Drives::new(&config);
    assert_eq!(drives.counts(1, 3.0), -1000);
    assert_eq!(drives.torque(1, -1000), 3.0);
    // one count beyond the end of 32 bits is one count further, not a revolution back
    let step = config.theta_step();
    assert_eq!(drives.angle(1, i32::MIN), -11.0 * step);
}

#[test]
fn process_data_lies_where_the_map_says() {
    let drives = Drives::new(&config("akd"));
    assert_eq!(drives.bytes(), (8, 16));
    let mut out = [0xff; 8];
    drives.write(0, 0x000f, -3.0, &mut out);
    assert_eq!(out, [0x0f, 0, 4, 0, 0x18, 0xfc, 0xff, 0xff]);
    let data = [0x37, 0x16, 4, 0, 2, 0, 0, 0, 0x18, 0xfc, 0xff, 0xff, 1, 2, 3, 4];
    let report = drives.read(0, &data);
    let theta = 2.0 * config("akd").theta_step();
    let mode = Some(4);
    assert_eq!(report, Report { statusword: 0x1637, error_code: 0, theta, tau: -3.0, mode });
}

#[test]
fn sixteen_bits_are_not_overrun() {
    let drives = Drives::new(&config("cia402"));
    assert_eq!(drives.bytes(), (6, 12));
    let mut out = [0; 6];
    for (tau, wanted) in [(1e9, i16::MAX), (-1e9, -i16::MAX), (300.0, i16::MAX), (-9.0, -1000)] {
        drives.write(0, 0, tau, &mut out);
        assert_eq!(i16::from_le_bytes([out[4], out[5]]), wanted, "{tau}");
    }
    let data = [0x18, 0x02, 10, 0, 0, 0, 0, 0, 0x18, 0xfc, 0x11, 0x86];
    let report = drives.read(0, &data);
    assert_eq!((report.tau, report.error_code), (-1000.0 * (9.0 * 0.001), 0x8611));
}
