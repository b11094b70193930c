//! States, mailbox, maps, clocks and EEPROM of one SubDevice, through frames.
use crate::bench::Bench;
use crate::coe::abort;
use crate::esc::state::code;

fn one() -> Bench {
    Bench::new("drives.count = 1")
}

#[test]
fn pre_op_needs_the_mailbox_that_the_eeprom_names() {
    let mut bench = one();
    bench.send(&[(2, 0, 0x0010, vec![1, 0])]);
    assert_eq!(bench.request(0, 2), (0x11, code::INVALID_MAILBOX));
    bench.set_sm(0, 0, 0x1000, 512, 0x26);
    bench.set_sm(0, 1, 0x1400, 256, 0x22);
    assert_eq!(bench.request(0, 0x12), (0x11, code::INVALID_MAILBOX));
    bench.set_sm(0, 1, 0x1400, 512, 0x22);
    assert_eq!(bench.request(0, 2), (0x11, code::INVALID_MAILBOX), "not acknowledged");
    assert_eq!(bench.request(0, 0x12), (2, 0));
}

#[test]
fn safe_op_needs_the_sizes_of_the_maps() {
    let mut bench = one();
    bench.reach_pre_op();
    bench.configure(0);
    bench.set_sm(0, 2, 0x1800, 6, 0x64);
    assert_eq!(bench.request(0, 4), (0x12, code::INVALID_OUTPUTS));
    bench.set_sm(0, 2, 0x1800, 8, 0x64);
    bench.set_sm(0, 3, 0x1C00, 14, 0x20);
    assert_eq!(bench.request(0, 0x14), (0x12, code::INVALID_INPUTS));
    bench.set_sm(0, 3, 0x1C00, 16, 0x24);
    assert_eq!(bench.request(0, 0x14), (0x12, code::INVALID_INPUTS), "wrong direction");
    bench.set_sm(0, 3, 0x1C00, 16, 0x20);
    assert_eq!(bench.request(0, 0x14), (4, 0));
}

#[test]
fn a_drive_that_wants_more_inputs_refuses_the_maps_it_was_given() {
    let mut bench = Bench::new("drives.count = 1\n[[drive]]\nposition = 0\nextra_input_bytes = 2");
    bench.reach_pre_op();
    bench.configure(0);
    assert_eq!(bench.request(0, 4), (0x12, code::INVALID_INPUTS));
}

#[test]
fn a_sync_cycle_below_250_us_is_refused() {
    let mut bench = one();
    bench.reach_pre_op();
    bench.configure(0);
    bench.write(0, 0x0981, &[3]);
    for (cycle, wanted) in [(125_000u32, 0x12), (260_000, 0x12), (250_000, 4)] {
        bench.write(0, 0x09A0, &cycle.to_le_bytes());
        let (state, code) = bench.request(0, 0x14);
        assert_eq!(state, wanted, "{cycle} ns");
        assert_eq!(code == code::INVALID_SYNC_CYCLE, wanted != 4);
    }
}

#[test]
fn op_comes_with_the_first_outputs() {
    let mut bench = one();
    bench.reach_safe_op();
    assert_eq!(bench.request(0, 8), (4, 0));
    bench.cycle(0, 0);
    assert_eq!(bench.read(0, 0x0130, 2).data, [8, 0]);
}

#[test]
fn process_data_is_closed_below_safe_op() {
    let mut bench = one();
    bench.reach_pre_op();
    bench.configure(0);
    assert_eq!(bench.cycle(0, 0).unwrap().1, 0);
    bench.request(0, 4);
    assert_eq!(bench.cycle(0, 0).unwrap().1, 3);
    bench.request(0, 2);
    assert_eq!(bench.cycle(0, 0).unwrap().1, 0);
}

#[test]
fn the_mailbox_takes_one_request_and_gives_its_answer_once() {
    let mut bench = one();
    assert_eq!(bench.read(0, 0x1400, 512).counter, 0);
    bench.reach_pre_op();
    let reply = bench.sdo(0, &[0x40, 0x18, 0x10, 2, 0, 0, 0, 0]);
    assert_eq!(reply[..8], [0x43, 0x18, 0x10, 2, 0x44, 0x4B, 0x41, 0x00]);
    assert_eq!(bench.read(0, 0x1400, 512).counter, 0, "it was taken");
    assert_eq!(bench.read(0, 0x080D, 1).data, [0], "and the sync manager says so");
}

#[test]
fn maps_are_written_in_pre_op_only() {
    let mut bench = one();
    bench.reach_pre_op();
    assert_eq!(bench.download(0, 0x1C12, 0, &[0]), 0);
    bench.configure(0);
    bench.request(0, 4);
    assert_eq!(bench.download(0, 0x1600, 0, &[0]), abort::DEVICE_STATE);
    assert_eq!(bench.download(0, 0x1C13, 0, &[0]), abort::DEVICE_STATE);
    assert_eq!(bench.download(0, 0x6060, 0, &[4]), 0, "other objects are free");
}

#[test]
fn objects_of_the_device_refuse_with_the_right_code() {
    let mut bench = one();
    bench.reach_pre_op();
    assert_eq!(bench.download(0, 0x1018, 1, &[1, 0, 0, 0]), abort::READ_ONLY);
    assert_eq!(bench.download(0, 0x1018, 9, &[1, 0, 0, 0]), abort::NO_SUBINDEX);
    assert_eq!(bench.download(0, 0x1650, 0, &[0]), abort::NO_OBJECT);
    assert_eq!(bench.download(0, 0x1701, 0, &[0]), abort::READ_ONLY);
    assert_eq!(bench.download(0, 0x5000, 0, &[0]), abort::NO_OBJECT);
    let statusword = 0x6041_0010u32.to_le_bytes();
    assert_eq!(bench.download(0, 0x1600, 1, &statusword), abort::NOT_MAPPABLE, "not an output");
    let mut fixed = Bench::new("drives.count = 1\n[[drive]]\nposition = 0\nmaps_fixed = true");
    fixed.reach_pre_op();
    assert_eq!(fixed.download(0, 0x1C12, 0, &[0]), abort::READ_ONLY);
}

#[test]
fn the_eeprom_is_read_through_its_registers() {
    let mut bench = one();
    bench.send(&[(2, 0, 0x0010, vec![1, 0])]);
    bench.write(0, 0x0502, &[0, 1, 0x0A, 0, 0, 0]);
    // product 0x00414B44, then revision 2
    assert_eq!(bench.read(0, 0x0508, 8).data, [0x44, 0x4B, 0x41, 0, 2, 0, 0, 0]);
}

#[test]
fn clocks_give_receive_times_and_follow_the_reference() {
    let mut bench = Bench::new("drives.count = 3\ndrives.drift_ppm = 0.0");
    bench.reach_pre_op();
    bench.send(&[(8, 0, 0x0900, vec![0; 4])]);
    let times: Vec<Vec<u32>> = (0..3)
        .map(|k| {
            let data = bench.read(k, 0x0900, 8).data;
            let long = |d: &[u8]| u32::from_le_bytes([d[0], d[1], d[2], d[3]]);
            vec![long(&data), long(&data[4..])]
        })
        .collect();
    // loops behind the first and the second: four and two hops of 680 ns; the last has none
    assert_eq!(times[0][1].wrapping_sub(times[0][0]), 4 * 680);
    assert_eq!(times[1][1].wrapping_sub(times[1][0]), 2 * 680);
    assert_eq!(times[2][1], 0);
    // offsets of 10 s apart are brought together by the offset register and then by FRMW
    let local = |bench: &mut Bench, k| {
        let data = bench.read(k, 0x0918, 8).data;
        i64::from_le_bytes(data.try_into().unwrap())
    };
    let reference = local(&mut bench, 0);
    for k in 1..3 {
        let offset = reference - local(&mut bench, k) + 680 * k as i64;
        bench.write(k, 0x0920, &offset.to_le_bytes());
        bench.write(k, 0x0928, &(680 * k as u32).to_le_bytes());
    }
    for _ in 0..10 {
        bench.send(&[(14, 1, 0x0910, vec![0; 8])]);
    }
    for k in 1..3 {
        let data = bench.read(k, 0x092C, 4).data;
        let difference = u32::from_le_bytes(data.try_into().unwrap()) & 0x7FFF_FFFF;
        assert!(difference <= 1, "SubDevice {k}: {difference} ns");
    }
}
