use super::*;

fn fault(text: &str) -> Fault {
    toml::from_str(text).unwrap()
}

#[test]
fn a_fault_begins_and_ends_at_its_exact_cycle() {
    let short = fault("kind = 'wkc_short'\ncycle = 100\ncount = 3");
    let cycles: Vec<u64> = (90..120).filter(|n| short.acts(0, *n)).collect();
    assert_eq!(cycles, [100, 101, 102]);
    assert!(short.ends(103) && !short.ends(102));
    let ever = fault("kind = 'cable_cut'\ncycle = 100");
    assert!(ever.acts(0, u64::MAX) && !ever.acts(0, 99) && !ever.ends(0));
}

#[test]
fn a_burst_comes_again_and_again() {
    let often = fault("kind = 'frame_lost'\ncycle = 10\ncount = 9\nburst = 2\nevery = 4");
    let cycles: Vec<u64> = (0..40).filter(|n| often.acts(0, *n)).collect();
    assert_eq!(cycles, [10, 11, 14, 15, 18]);
}

#[test]
fn a_chance_is_what_it_says_and_repeats() {
    let lost = fault("kind = 'frame_lost'\ncycle = 1\ncount = 0\nprobability = 0.1\nseed = 7");
    let hits = |fault: &Fault, place| (1..100_001).filter(|n| fault.acts(place, *n)).count();
    // 10 000 expected, standard deviation 95
    assert!((9_600..10_400).contains(&hits(&lost, 0)), "{}", hits(&lost, 0));
    assert_eq!(hits(&lost, 0), hits(&lost.clone(), 0));
    assert_ne!(hits(&lost, 0), hits(&lost, 1));
}

#[test]
fn impossible_faults_are_refused_with_the_allowed_range() {
    let text = |toml: &str| fault(toml).check(0, 6).unwrap_err().to_string();
    assert!(text("kind = 'frame_lost'\ncycle = 0").contains("allowed 1 and up"));
    assert!(text("kind = 'safe_op'\ncycle = 5\nposition = 6").contains("allowed 0 to 5"));
    assert!(text("kind = 'cable_cut'\ncycle = 5\nposition = 7").contains("allowed 0 to 6"));
    assert!(text("kind = 'frame_lost'\ncycle = 5\nprobability = 2.0").contains("0 to 1"));
    assert!(text("kind = 'frame_lost'\ncycle = 5\nburst = 2").contains("burst <= every"));
    assert!(text("kind = 'link_noise'\ncycle = 5\nport = 2").contains("0 (IN) and 1 (OUT)"));
    assert!(text("kind = 'sto'\ncycle = 5\ncounting = 'frames'").contains("is for frames"));
    assert!(text("kind = 'sto'\ncycle = 5\ncounting = 'any_frames'").contains("for a pause"));
}
