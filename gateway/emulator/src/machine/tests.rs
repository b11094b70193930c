//! The cycle, its start, watchdog and every fault at its exact cycle.
use super::*;
use crate::bench::{inputs, Bench};

fn running(options: &str) -> Bench {
    let mut bench = Bench::new(options);
    bench.enable();
    bench.events();
    bench
}

fn fault(text: &str) -> Bench {
    running(&format!("drives.count = 6\n[[fault]]\n{text}"))
}

const ENABLED: u16 = 0x0237;

/// Statuswords (without bits 4 and 9) and counter of the next cycles.
fn states(bench: &mut Bench, count: usize) -> Vec<Option<(Vec<u16>, u16)>> {
    let one = |bench: &mut Bench| {
        let (inputs, counter) = bench.cycle(15, 100)?;
        Some((inputs.iter().map(|one| one.status & 0x6F).collect(), counter))
    };
    (0..count).map(|_| one(bench)).collect()
}

#[test]
fn the_plant_is_held_until_a_reply_says_that_all_are_enabled() {
    let mut bench = running("drives.count = 6");
    // the outputs of the frame that says so drive the step 0 -> 1
    let (first, counter) = bench.cycle(15, 1000).unwrap();
    assert_eq!(counter, 18);
    assert!(first.iter().all(|one| one.status == ENABLED && one.position == 0));
    assert_eq!(bench.machine.cycle(), Some(1));
    let (second, _) = bench.cycle(15, 0).unwrap();
    // 3 N m on 0.05 kg m2 for one step of 0.25 ms: 3.75e-6 rad of 2^32 counts a turn
    let counts = 3.0 / 0.05 * 0.00025 * 0.00025 / std::f64::consts::TAU * 4_294_967_296.0;
    assert_eq!(second[0].position, counts.round() as i32);
    assert_eq!(second[0].current, 1000);
    assert!(bench.events().contains(&(Some(0), EventKind::Enabled)));
}

#[test]
fn inputs_are_latched_before_outputs_act() {
    let mut bench = running("drives.count = 6");
    bench.cycle(15, 0);
    let (now, _) = bench.cycle(0, 0).unwrap();
    assert_eq!(now[0].status, ENABLED, "this frame disables, the next says it");
    assert_ne!(bench.cycle(0, 0).unwrap().0[0].status, ENABLED);
}

#[test]
fn a_disabled_drive_pushes_no_more_and_the_plant_goes_on() {
    let mut bench = running("drives.count = 6");
    for _ in 0..100 {
        bench.cycle(15, 1000);
    }
    bench.cycle(0, 1000);
    let (before, _) = bench.cycle(0, 1000).unwrap();
    let (after, _) = bench.cycle(0, 1000).unwrap();
    assert_eq!(after[0].current, 0);
    assert!(after[0].position > before[0].position, "it coasts");
    assert!(bench.events().contains(&(Some(100), EventKind::TorqueZero { position: 0 })));
}

#[test]
fn the_order_of_the_bus_need_not_be_that_of_the_axes() {
    let mut bench = running("drives.count = 6\ndrives.order = [1, 0, 2, 3, 4, 5]");
    let mut bytes = bench.process_data(15, 0);
    // 16 bytes of headers, ten of the datagram, target of the first drive at 4
    bytes[30..34].copy_from_slice(&1000i32.to_le_bytes());
    bench.replies(&bytes);
    let (after, _) = bench.cycle(15, 0).unwrap();
    assert_eq!((after[0].current, after[1].current), (1000, 0));
    assert!(bench.machine.theta[1] > 0.0 && bench.machine.theta[0] == 0.0);
}

#[test]
fn the_watchdog_zeroes_the_torque_at_its_exact_cycle() {
    let lost = "kind = 'frame_lost'\ncycle = 10\ncount = 20";
    let mut bench = Bench::new(&format!("drives.count = 6\n[[fault]]\n{lost}"));
    bench.reach_pre_op();
    for position in 0..6 {
        // 25 ticks of 100 us: 10 cycles
        bench.write(position, 0x0420, &[25, 0]);
        bench.configure(position);
        bench.request(position, 4);
        bench.request(position, 8);
    }
    for control in [0, 6, 7, 15] {
        bench.cycle(control, 0);
    }
    for _ in 0..10 {
        assert!(bench.cycle(15, 100).is_some());
    }
    for _ in 0..20 {
        assert!(bench.cycle(15, 100).is_none());
    }
    // frame 9 was the last that acted, so 2.5 ms have passed at cycle 19
    let events = bench.events();
    for position in 0..6 {
        assert!(events.contains(&(Some(19), EventKind::Watchdog { position })));
        assert!(events.contains(&(Some(19), EventKind::TorqueZero { position })));
        assert_eq!(bench.read(position, 0x0130, 6).data, [0x14, 0, 0, 0, 0x1B, 0]);
        assert_eq!(bench.read(position, 0x0442, 1).data, [1]);
    }
    let (inputs, counter) = bench.cycle(15, 100).unwrap();
    assert_eq!((inputs[0].status & 0x4F, counter), (0x08, 18), "fault, and a full counter");
    assert_eq!(bench.machine.devices[0].drive().machine.error, 0x8130);
}

#[test]
fn a_drive_fault_is_seen_at_its_cycle() {
    let mut bench = fault("kind = 'drive_fault'\ncycle = 5\nposition = 2\ncode = 8976");
    let seen = states(&mut bench, 7);
    let third: Vec<u16> = seen.iter().map(|one| one.as_ref().unwrap().0[2]).collect();
    assert_eq!(third, [0x27, 0x27, 0x27, 0x27, 0x27, 0x0F, 0x08 & 0x6F]);
    assert!(bench.events().contains(&(Some(5), EventKind::TorqueZero { position: 2 })));
    assert_eq!(bench.machine.devices[2].drive().machine.error, 0x2310);
}

#[test]
fn an_encoder_jumps_and_comes_back() {
    let mut bench = fault("kind = 'encoder_jump'\ncycle = 3\ncount = 2\nposition = 1\nsize = 5000");
    let shown: Vec<i32> = (0..6).map(|_| bench.cycle(15, 0).unwrap().0[1].position).collect();
    assert_eq!(shown, [0, 0, 0, 5000, 5000, 0]);
}

#[test]
fn a_frozen_encoder_stands_while_the_plant_moves() {
    let mut bench = fault("kind = 'encoder_frozen'\ncycle = 4\ncount = 4\nposition = 0");
    let shown: Vec<i32> = (0..9).map(|_| bench.cycle(15, 1000).unwrap().0[0].position).collect();
    assert!(shown[3] < shown[4]);
    assert_eq!(shown[4..8], [shown[4]; 4]);
    // torque is constant, so from rest the angle grows as n (n + 1) / 2, less a little friction
    let wanted = f64::from(shown[1]) * 36.0;
    assert!((f64::from(shown[8]) / wanted - 1.0).abs() < 0.01, "{} {wanted}", shown[8]);
}

#[test]
fn a_drive_in_safe_op_still_counts_fully() {
    let mut bench = fault("kind = 'safe_op'\ncycle = 2\nposition = 5");
    let seen = states(&mut bench, 4);
    assert!(seen.iter().all(|one| one.as_ref().unwrap().1 == 18));
    assert_eq!(bench.read(5, 0x0130, 6).data, [0x14, 0, 0, 0, 0x1A, 0]);
    assert!(bench.events().contains(&(Some(2), EventKind::TorqueZero { position: 5 })));
}

#[test]
fn a_deaf_drive_shortens_the_counter_for_its_cycles() {
    let mut bench = fault("kind = 'wkc_short'\ncycle = 2\ncount = 3\nposition = 1");
    let counters: Vec<u16> = (0..7).map(|_| bench.cycle(15, 0).unwrap().1).collect();
    assert_eq!(counters, [18, 18, 15, 15, 15, 18, 18]);
}

#[test]
fn a_cut_cable_takes_away_all_behind_it() {
    for (position, counter) in [(1, 3), (3, 9), (5, 15)] {
        let text = format!("kind = 'cable_cut'\ncycle = 2\ncount = 2\nposition = {position}");
        let mut bench = fault(&text);
        let counters: Vec<u16> = (0..5).map(|_| bench.cycle(15, 0).unwrap().1).collect();
        assert_eq!(counters, [18, 18, counter, counter, 18]);
        assert_eq!(bench.read(position - 1, 0x0311, 1).data, [1], "one lost link");
    }
    let mut bench = fault("kind = 'cable_cut'\ncycle = 2\nposition = 0");
    let answered: Vec<bool> = (0..4).map(|_| bench.cycle(15, 0).is_some()).collect();
    assert_eq!(answered, [true, true, false, false]);
    assert!(bench.send(&[(7, 0, 0x0130, vec![0; 2])]).is_empty());
}

#[test]
fn a_lost_frame_acts_or_does_not() {
    for (acting, current) in [("before", 0), ("after", 700)] {
        let text = format!("kind = 'frame_lost'\ncycle = 1\nacting = '{acting}'");
        let mut bench = fault(&text);
        bench.cycle(15, 0);
        assert!(bench.cycle(15, 700).is_none());
        assert_eq!(bench.machine.cycle(), Some(2), "plant time goes on");
        assert_eq!(bench.cycle(15, 0).unwrap().0[0].current, current);
    }
}

#[test]
fn replies_are_doubled_late_or_out_of_order() {
    let count = |kind: &str, frames: usize| {
        let mut bench = fault(&format!("kind = '{kind}'\ncycle = 1\nframes = {frames}"));
        let one = |bench: &mut Bench, k: i32| {
            let bytes = bench.process_data(15, k);
            let replies = bench.replies(&bytes);
            replies.iter().map(|bytes| inputs(bytes).0[0].current).collect::<Vec<i32>>()
        };
        (1..5).map(|k| one(&mut bench, k)).collect::<Vec<Vec<i32>>>()
    };
    // the reply to frame n carries the current of frame n - 1
    assert_eq!(count("frame_duplicated", 1), [vec![0], vec![1, 1], vec![2], vec![3]]);
    assert_eq!(count("frame_delayed", 2), [vec![0], vec![], vec![2], vec![1, 3]]);
    assert_eq!(count("frame_reordered", 1), [vec![0], vec![], vec![2, 1], vec![3]]);
}

#[test]
fn the_same_frames_give_the_same_bits() {
    let digest = |lost: &str| {
        let mut bench = running(&format!("drives.count = 6\n{lost}"));
        for k in 0..500 {
            bench.cycle(15, k % 37 * 100);
        }
        bench.machine.trajectory.finish().unwrap()
    };
    assert_eq!(digest(""), digest(""));
    let lost = "[[fault]]\nkind = 'frame_lost'\ncycle = 1\ncount = 0\nprobability = 0.1\nseed = 3";
    assert_eq!(digest(lost), digest(lost));
    assert_ne!(digest(""), digest(lost));
}

#[test]
fn a_drive_that_is_energised_already_says_so() {
    let mut bench = Bench::new("drives.count = 1\n[[drive]]\nposition = 0\ninitial = 'enabled'");
    bench.reach_safe_op();
    assert_eq!(bench.cycle(0, 0).unwrap().0[0].status, ENABLED);
    assert_eq!(bench.machine.cycle(), None, "SAFE-OP moves nothing");
}

#[test]
fn leaving_op_with_power_is_a_fault_and_without_is_none() {
    let mut bench = running("drives.count = 6");
    bench.cycle(15, 0);
    bench.request(0, 4);
    assert_eq!(bench.machine.devices[0].drive().machine.error, 0x8130);
    bench.cycle(0, 0);
    bench.request(1, 4);
    assert_eq!(bench.machine.devices[1].drive().machine.error, 0);
}
