use super::{parse, Role, Scale};
use flexhex_system::Value;

const AKD: &str = include_str!("../../machines/akd.toml");
const CIA402: &str = include_str!("../../machines/cia402.toml");

fn refused(from: &str, to: &str) -> String {
    assert!(AKD.contains(from), "{from}");
    parse(&AKD.replacen(from, to, 1)).unwrap_err().to_string()
}

#[test]
fn both_templates_are_good() {
    for text in [AKD, CIA402] {
        assert!(parse(text).is_ok(), "{:?}", parse(text).err());
    }
}

#[test]
fn mistakes_name_key_value_and_range() {
    for (from, to, wanted) in [
        ("torque_N_m = 27.0", "torque_N_m = 0.0", "limits.torque_N_m = 0, allowed 0.001 to 10000"),
        ("watchdog_ms = 5", "watchdog_ms = 0", "bus.watchdog_ms = 0, allowed 1 to 6000"),
        ("position = 1", "position = 0", "drive[1].position = 0"),
        (
            "sync0_shift_us = 0",
            "clock_difference_ns = 5",
            "bus.clock_difference_ns = 5, allowed 10 to 1000000",
        ),
        ("mode = 4 ", "mode = 8 ", "profile.mode = 8: no torque mode: allowed 4 (torque)"),
        (
            "# rest_rad = [-0.34, -0.35,",
            "rest_rad = [-0.34, nan,",
            "landing.rest_rad[1] = NaN, allowed -10 to 10",
        ),
        (
            "rest_speed_rad_per_s = 0.1",
            "rest_speed_rad_per_s = 1.1",
            "landing.rest_speed_rad_per_s = 1.1, allowed 0.0001 to 1",
        ),
        (
            "object = 0x605A",
            "object = 0x6040",
            "profile.startup[0]: 0x6040:0 (quick stop: ramp, then disabled) is in profile.rx",
        ),
        (
            "# serial = 1001",
            "startup = [{ object = 0x2071, type = \"i32\", value = 9 }]",
            "drive[0].startup[0]: 0x2071:0 is in profile.rx",
        ),
        ("direction = 1", "direction = 2", "drive[0].direction = 2, allowed 1 or -1"),
        (
            "position_min_rad = -0.52",
            "position_min_rad = 0.6",
            "limits.position_min_rad = 0.6 is not below",
        ),
        (
            "role = \"target_torque\"",
            "role = \"position\"",
            "profile.rx: 0 entries have the role TargetTorque",
        ),
        ("bits = 32", "bits = 12", "profile.rx: TargetTorque has bits = 12"),
    ] {
        let text = refused(from, to);
        assert!(text.contains(wanted), "{text}");
    }
}

#[test]
fn unknown_and_missing_keys_are_refused_by_name() {
    assert!(refused("watchdog_ms", "watchdog_s").contains("unknown field `watchdog_s`"));
    assert!(refused("mode = 4 ", "# mode = 4 ").contains("missing field `mode`"));
    assert!(refused("drive_fault = \"damp\"", "drive_fault = \"panic\"").contains("panic"));
    assert!(refused("[reactions]", "[reactions]\nvelocity = \"zero\"").contains("velocity"));
}

#[test]
fn five_drives_are_not_enough() {
    let at = AKD.rfind("[[drive]]").unwrap();
    let text = parse(&AKD[..at]).unwrap_err().to_string();
    assert!(text.contains("drive: 5 entries"), "{text}");
}

#[test]
fn steps_are_the_products_that_the_plant_takes() {
    let akd = parse(AKD).unwrap();
    assert_eq!(akd.profile.scale.tau_step(), 3.0 * 0.001);
    assert_eq!(akd.theta_step(), std::f64::consts::TAU / 4294967296.0);
    let cia402 = parse(CIA402).unwrap();
    assert!(matches!(cia402.profile.scale, Scale::RatedTorque { .. }));
    assert_eq!(cia402.profile.scale.tau_step(), 9.0 * 0.001);
    assert_eq!(akd.profile.rx[0].entries[3].role, Role::TargetTorque);
}

#[test]
fn single_values_are_changed_and_checked_like_the_file() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/akd.toml");
    let read = |change: &str| super::read(&file, &[change.to_owned()]);
    assert_eq!(read("safety.overrun_us=20000").unwrap().safety.overrun_us, 20000);
    assert_eq!(read("bus.interface=veth7").unwrap().bus.interface, "veth7");
    for (change, wanted) in [
        ("bus.watchdog_ms=0", "bus.watchdog_ms = 0, allowed 1 to 6000"),
        ("bus.watchdog=5", "akd.toml: --set watchdog = 5: unknown field `watchdog`"),
        ("reactions.jump=ramp", "akd.toml: --set jump = \"ramp\": unknown variant `ramp`"),
        ("cable.length=5", "\"cable\""),
        ("nothing", "KEY=VALUE"),
    ] {
        let text = read(change).unwrap_err().to_string();
        assert!(text.contains(wanted), "{text}");
    }
}

#[test]
fn parameters_are_numbers_flags_or_items() {
    let to = |value: &str| {
        let key = "feedforward = \"F.tau_ff\"";
        (key, format!("parameters = {{ \"K.x\" = {value} }}\n{key}"))
    };
    for (value, wanted) in [
        ("2", Value::Number(2.0)),
        ("0.5", Value::Number(0.5)),
        ("false", Value::Flag(false)),
        ("\"hold\"", Value::Item("hold".into())),
    ] {
        let (key, text) = to(value);
        let config = parse(&AKD.replacen(key, &text, 1)).unwrap();
        assert_eq!(config.system.parameters["K.x"], wanted);
    }
    let (key, text) = to("[1.0]");
    let text = refused(key, &text);
    assert!(text.contains("expected a number, true, false or the name of an item"), "{text}");
}

#[test]
fn values_of_a_wrong_type_are_refused_with_their_line() {
    for (from, to, wanted) in [
        ("mode = 4 ", "mode = 4.5", "line 37 `mode = 4.5`: invalid type: floating point `4.5`, expected a whole number from -128 to 127"),
        ("watchdog_ms = 5", "watchdog_ms = -5", "line 20 `watchdog_ms = -5`: invalid value: integer `-5`, expected a whole number, 0 or more"),
        ("torque_N_m = 27.0", "torque_N_m = \"27\"", "`torque_N_m = \"27\"`: invalid type: string \"27\", expected a number"),
        ("feedback = [2.0]", "feedback = 2.0", "expected a list such as [2.0]"),
        ("watchdog_ms = 5", "watchdog_ms = 5\nwatchdog_ms = 6", "line 21 `watchdog_ms = 6`: duplicate key"),
        ("lock_memory = true", "lock_memory = 1", "expected true or false"),
        ("index = 0x1600", "index = 0x16000", "`index = 0x16000`"),
        ("# cpu = 1 ", "cpu = 5000 #", "real_time.cpu = 5000, allowed 0 to 1023"),
    ] {
        let text = refused(from, to);
        assert!(text.contains(wanted), "{text}");
    }
}

#[test]
fn two_drives_have_two_serial_numbers() {
    let named = AKD.replace("# serial = 1001", "serial = 1001");
    assert!(parse(&named.replace("# serial = 1002", "serial = 1002")).is_ok());
    let text = parse(&named.replace("# serial = 1002", "serial = 1001")).unwrap_err().to_string();
    assert!(text.contains("drive[1].serial = 1001: also that of another drive"), "{text}");
}
