use super::*;

#[test]
fn the_example_of_the_readme_is_read() {
    let text = include_str!("../README.md");
    let example = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next());
    let mut options: Options = toml::from_str(example.unwrap()).unwrap();
    options.interface = "veth1".into();
    options.check().unwrap();
    assert_eq!((options.fault.len(), options.order()[2]), (2, Some(3)));
    assert_eq!(options.plant.parameters["plant.f_current"], flexhex_system::Value::Number(800.0));
}

#[test]
fn wrong_options_are_refused_with_what_is_allowed() {
    let said = |text: &str| {
        let mut options: Options = toml::from_str(text).unwrap();
        options.interface = "veth1".into();
        options.check().unwrap_err().to_string()
    };
    assert!(said("drives.count = 7").contains("allowed 1 to 6"));
    assert!(said("drives.order = [0, 0, 1, 2, 3, 4]").contains("one axis"));
    assert!(said("drives.torque_constant = -1.0").contains("above 0"));
    assert!(said("[[drive]]\nposition = 6").contains("allowed 0 to 5"));
    assert!(said("[[drive]]\nposition = 0\ndirection = 2").contains("1 or -1"));
    assert!(said("drives.mailbox_bytes = 8").contains("24 to 1024"));
    assert!(said("drives.others = [7]").contains("allowed 0 to 6"));
    assert!(said("drives.limit = -1").contains("0 to 1000000"));
    assert!(said("silence_s = -1.0").contains("silence_s"));
    assert!(toml::from_str::<Options>("intreface = 'x'").is_err());
}

#[test]
fn other_devices_move_the_drives_along_the_bus() {
    let options: Options = toml::from_str("[drives]\ncount = 3\nothers = [0, 2]").unwrap();
    assert_eq!(options.order(), [None, Some(0), None, Some(1), Some(2)]);
}
