//! Files of estimates: written and read again, bounds on either side, damage.

use super::*;

fn state() -> State {
    let pair = |(name, value): (&str, f64)| (name.to_owned(), value);
    State {
        component: "K".to_owned(),
        guid: "{a}".to_owned(),
        steps: 120,
        parameters: [("p0.m", 0.25), ("scale.m", 0.1), ("R2", 1e-3)].map(pair).to_vec(),
        outputs: [("p.m", 0.1 + 0.2), ("p_std.m", 1.0 / 3.0), ("fault", 0.0)].map(pair).to_vec(),
        bytes: (0..=255).collect(),
    }
}

/// A state whose output `name` is `value`.
fn with(name: &str, value: f64) -> State {
    let mut state = state();
    for output in state.outputs.iter_mut().filter(|(known, _)| known == name) {
        output.1 = value;
    }
    state
}

#[test]
fn what_is_written_is_read_to_the_last_bit() {
    let text = Estimates::text(&[state()], &[("date".to_owned(), "today".to_owned())]);
    assert_eq!(Estimates::states(&text).unwrap(), vec![state()]);
    // 0.30000000000000004 and a third are read as they were written
    assert!(text.contains("0.30000000000000004") && text.contains("\"date\": \"today\""));
}

#[test]
fn an_estimate_is_refused_beyond_its_range_on_either_side() {
    for side in [-1.0, 1.0] {
        check(&with("p.m", 0.25 + side * 0.499), 5.0).unwrap();
        let why = check(&with("p.m", 0.25 + side * 0.501), 5.0).unwrap_err().to_string();
        assert!(why.contains("K.p.m") && why.contains("allowed 5 (estimate.range)"), "{why}");
    }
    assert!(check(&with("p.m", f64::NAN), 5.0).unwrap_err().to_string().contains("must be finite"));
    assert!(check(&with("p_std.m", f64::INFINITY), 5.0).is_err());
    assert!(check(&with("fault", 3.0), 5.0)
        .unwrap_err()
        .to_string()
        .contains("K.fault = 3, must be 0"));
}

#[test]
fn damage_is_refused() {
    let text = Estimates::text(&[state()], &[]);
    let why = |text: &str| Estimates::states(text).unwrap_err().to_string();
    let refused = |old: &str, new: &str, wanted: &str| {
        assert!(text.contains(old), "{old}");
        let refusal = why(&text.replace(old, new));
        assert!(refusal.contains(wanted), "{refusal}");
    };
    refused("estimate 2", "estimate 1", "expected \"flexhex estimate 2\"");
    // a number of the covariance that is NaN now
    refused("08090a0b0c0d0e0f", "000000000000f87f", "not the one that was written");
    refused("0001", "001", "pairs of hexadecimal digits");
    refused("0001", "00+1", "pairs of hexadecimal digits");
    refused("\"guid\"", "\"uid\"", "no estimate");
    assert!(why("time,theta").contains("no estimate"));
    assert!(why(&Estimates::text(&[], &[])).contains("holds no state"));
}

#[test]
fn no_file_is_overwritten() {
    let folder = std::env::temp_dir().join(format!("flexhex-estimate-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let written: Vec<_> =
        (0..2).map(|_| write(&folder.join("a.csv"), &[state()], &[]).unwrap()).collect();
    let names: Vec<_> = written.iter().map(|path| path.file_name().unwrap()).collect();
    assert_eq!(names, ["a-estimate.json", "a-estimate-2.json"]);
    let far = read(&written[0], 0.1).unwrap_err().to_string();
    assert!(far.contains("a-estimate.json: K.p.m"), "{far}");
    assert_eq!(read(&written[1], 100.0).unwrap(), vec![state()]);
    std::fs::remove_dir_all(&folder).unwrap();
}
