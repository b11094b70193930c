//! Error counters of the controllers, as the cables and their faults make them count.
use crate::bench::Bench;

const COUNTERS: u16 = 0x0300;

fn running(fault: &str) -> Bench {
    let mut bench = Bench::new(&format!("drives.count = 3\n[[fault]]\n{fault}"));
    bench.enable();
    bench
}

/// Registers 0x0300 to 0x0313 that are not 0, of each device, as offset and count.
fn counted(bench: &mut Bench) -> Vec<Vec<(usize, u8)>> {
    let of_one = |position| {
        let bytes = bench.read(position, COUNTERS, 20).data;
        let counts = bytes.into_iter().enumerate();
        counts.filter(|(_, count)| *count > 0).collect()
    };
    (0..3).map(of_one).collect()
}

#[test]
fn a_damaged_frame_is_invalid_at_one_port_and_forwarded_by_all_that_come_after() {
    let mut bench = running("kind = 'frame_damaged'\ncycle = 5\ncount = 2\nposition = 1");
    let answers: Vec<_> = (0..10).map(|_| bench.cycle(15, 100).is_some()).collect();
    assert_eq!(answers.iter().filter(|answered| !**answered).count(), 2);
    let wanted = [vec![(9, 2)], vec![(0, 2), (1, 2), (9, 2)], vec![(8, 2)]];
    assert_eq!(counted(&mut bench), wanted);

    // on its way back, at port OUT of the second: only the first passes it on
    let mut bench = running("kind = 'frame_damaged'\ncycle = 5\nposition = 1\nport = 1");
    (0..10).for_each(|_| drop(bench.cycle(15, 100)));
    assert_eq!(counted(&mut bench), [vec![(9, 1)], vec![(2, 1), (3, 1)], vec![]]);
}

#[test]
fn outputs_of_a_damaged_frame_do_not_act_from_there_on() {
    let mut bench = running("kind = 'frame_damaged'\ncycle = 5\nposition = 1");
    (0..5).for_each(|_| drop(bench.cycle(15, 100)));
    assert_eq!(bench.cycle(0, 0), None);
    let (now, _) = bench.cycle(15, 100).unwrap();
    let enabled: Vec<_> = now.iter().map(|one| one.status & 0x6F == 0x27).collect();
    assert_eq!(enabled, [false, true, true]);
}

#[test]
fn noise_counts_until_255_and_no_frame_is_lost() {
    let mut bench = running("kind = 'link_noise'\ncycle = 5\ncount = 0\nposition = 2");
    for count in [200, 100] {
        (0..count).for_each(|_| assert!(bench.cycle(15, 100).is_some()));
    }
    assert_eq!(counted(&mut bench), [vec![], vec![], vec![(1, 255)]]);
}

#[test]
fn a_cable_that_is_cut_for_a_while_is_a_lost_link_at_both_of_its_ends() {
    let mut bench = running("kind = 'cable_cut'\ncycle = 5\ncount = 2\nposition = 1");
    (0..10).for_each(|_| drop(bench.cycle(15, 100)));
    assert_eq!(counted(&mut bench), [vec![(17, 1)], vec![(16, 1)], vec![]]);
}

#[test]
fn registers_hold_at_power_up_what_the_options_say() {
    let text = "drives.count = 3\n[[drive]]\nposition = 1\nregisters = [[784, 3], [769, 255]]";
    let mut bench = Bench::new(text);
    bench.reach_pre_op();
    assert_eq!(counted(&mut bench), [vec![], vec![(1, 255), (16, 3)], vec![]]);
}

#[test]
fn a_pause_comes_with_a_frame_of_any_kind_or_with_a_cycle_and_once() {
    let counting = "kind = 'pause'\ncycle = 3\ncounting = 'any_frames'";
    let mut bench = Bench::new(&format!("drives.count = 3\n[[fault]]\n{counting}"));
    let pauses = |bench: &mut Bench| {
        bench.read(0, COUNTERS, 1);
        bench.machine.take_pause()
    };
    let seen: Vec<_> = (0..5).map(|_| pauses(&mut bench)).collect();
    assert_eq!(seen, [false, false, true, false, false]);
    bench.enable();
    assert!((0..5).all(|_| bench.cycle(15, 100).is_some() && !bench.machine.take_pause()));

    let mut bench = running("kind = 'pause'\ncycle = 3");
    let cycles = (0..5).map(|_| {
        bench.cycle(15, 100);
        bench.machine.take_pause()
    });
    assert_eq!(cycles.filter(|paused| *paused).count(), 1);
}
