//! Addressing, working counters, and frames that are none.
use crate::bench::{frame, Bench, Request};
use crate::faults::mix;

fn bench() -> Bench {
    let mut bench = Bench::new("drives.count = 3");
    for k in 0..3u16 {
        let place = 0u16.wrapping_sub(k);
        let data = vec![k as u8 + 1, 0];
        assert_eq!(bench.send(&[(2, place, 0x0010, data)])[0].counter, 1);
    }
    bench
}

/// Writes go to the process-data memory, where nothing else happens.
const FREE: u16 = 0x2000;

#[test]
fn auto_increment_counts_the_position_up_and_takes_the_one_at_zero() {
    let mut bench = bench();
    let reply = bench.send(&[(1, 0xFFFF, 0x0010, vec![0; 2])]).remove(0);
    assert_eq!((reply.data, reply.position, reply.counter), (vec![2, 0], 2, 1));
    let none = bench.send(&[(1, 3, 0x0010, vec![9; 2])]).remove(0);
    assert_eq!((none.data, none.position, none.counter), (vec![9; 2], 6, 0));
}

#[test]
fn every_command_counts_as_the_standard_says() {
    // command, position or station, working counter with three SubDevices
    let table = [
        (0, 0, 0),
        (1, 0, 1),
        (2, 0, 1),
        (3, 0, 3),
        (4, 2, 1),
        (5, 2, 1),
        (6, 2, 3),
        (4, 9, 0),
        (7, 0, 3),
        (8, 0, 3),
        (9, 0, 9),
        (13, 0, 3),
        (14, 2, 3),
        (15, 0, 0),
        (255, 0, 0),
    ];
    for (command, address, counter) in table {
        let reply = bench().send(&[(command, address, FREE, vec![1, 2])]).remove(0);
        assert_eq!(reply.counter, counter, "command {command} to {address}");
    }
}

#[test]
fn read_and_write_gives_the_old_and_leaves_the_new() {
    let mut bench = bench();
    bench.write(1, FREE, &[5, 6]);
    let old = bench.send(&[(6, 2, FREE, vec![7, 8])]).remove(0);
    assert_eq!((old.data, old.counter), (vec![5, 6], 3));
    assert_eq!(bench.read(1, FREE, 2).data, [7, 8]);
}

#[test]
fn a_broadcast_read_is_the_or_of_all() {
    let mut bench = bench();
    bench.write(0, FREE, &[1]);
    bench.write(2, FREE, &[4]);
    let reply = bench.send(&[(7, 0, FREE, vec![0x10])]).remove(0);
    assert_eq!((reply.data, reply.position, reply.counter), (vec![0x15], 3, 3));
}

#[test]
fn read_multiple_write_copies_one_to_those_behind_it() {
    let mut bench = bench();
    bench.write(1, FREE, &[42]);
    let reply = bench.send(&[(14, 2, FREE, vec![0])]).remove(0);
    assert_eq!((reply.data, reply.counter), (vec![42], 3));
    // the first had taken what was in the datagram before station 2 read into it
    let values: Vec<u8> = (0..3).map(|k| bench.read(k, FREE, 1).data[0]).collect();
    assert_eq!(values, [0, 42, 42]);
}

#[test]
fn an_alias_counts_only_when_it_is_switched_on() {
    let mut bench = Bench::new("drives.count = 2\n[[drive]]\nposition = 1\nalias = 4660");
    let ask: Request = (4, 4660, 0x0012, vec![0; 2]);
    assert_eq!(bench.send(std::slice::from_ref(&ask))[0].counter, 0);
    bench.send(&[(8, 0, 0x0103, vec![1])]);
    let reply = bench.send(&[ask]).remove(0);
    assert_eq!((reply.data, reply.counter), (vec![0x34, 0x12], 1));
}

#[test]
fn read_only_registers_and_missing_memory_count_nothing() {
    let mut bench = bench();
    assert_eq!(bench.write(0, 0x0130, &[8, 0]), 0);
    assert_eq!(bench.read(0, 0x0130, 2).data, [1, 0]);
    for (offset, length) in [(0x3000, 1), (0x2FFF, 2), (0xFFFF, 4)] {
        assert_eq!(bench.read(0, offset, length).counter, 0, "{offset:#06x}");
        assert_eq!(bench.write(0, offset, &vec![1; length]), 0, "{offset:#06x}");
    }
}

#[test]
fn a_reply_differs_in_its_source_address() {
    let reply = bench().replies(&frame(&[(7, 0, 0, vec![0; 1])])).remove(0);
    assert_eq!(reply[6..12], [0x12, 0x10, 0x10, 0x10, 0x10, 0x10]);
}

#[test]
fn ports_show_where_the_line_ends() {
    let mut bench = bench();
    // link of ports 0 and 1, communication on them, the others closed
    assert_eq!(bench.read(0, 0x0110, 2).data, 0x5A31u16.to_le_bytes());
    assert_eq!(bench.read(2, 0x0110, 2).data, 0x5611u16.to_le_bytes());
}

#[test]
fn frames_that_are_not_sound_are_dropped() {
    let good = frame(&[(7, 0, 0x0130, vec![0; 2])]);
    let mut bench = bench();
    for length in 0..good.len() {
        assert!(bench.replies(&good[..length]).is_empty(), "{length} of {}", good.len());
    }
    for (place, value) in [(12, 0x08), (15, 0x40), (16 + 6, 0x20), (16 + 7, 0x80)] {
        let mut bad = good.clone();
        bad[place] = value;
        assert!(bench.replies(&bad).is_empty(), "byte {place}");
    }
    assert_eq!(bench.machine.dropped, good.len() as u64 + 4);
    assert_eq!(bench.replies(&good).len(), 1);
}

/// Random bytes, and sound frames with random addresses, lengths and data, in every state.
#[test]
fn no_frame_makes_it_panic_or_answer_outside_its_datagrams() {
    let mut bench = Bench::new("drives.count = 3");
    bench.reach_op();
    let mut seed = 20_260_101;
    let mut random = |below: u64| {
        seed = mix(seed);
        seed % below
    };
    let registers =
        [0x0120, 0x0500, 0x0502, 0x0600, 0x0800, 0x0900, 0x0910, 0x1000, 0x1800, 0x2FFF];
    for round in 0..60_000 {
        let mut bytes = if random(4) == 0 {
            (0..random(120)).map(|_| random(256) as u8).collect::<Vec<u8>>()
        } else {
            let length = if random(50) == 0 { random(1400) } else { random(40) };
            let data: Vec<u8> = (0..length).map(|_| random(256) as u8).collect();
            let offset = match random(3) {
                0 => random(0x1_0000) as u16,
                _ => registers[random(10) as usize] + random(20) as u16,
            };
            frame(&[(random(16) as u8, random(4) as u16, offset, data)])
        };
        if random(10) == 0 && !bytes.is_empty() {
            let place = random(bytes.len() as u64) as usize;
            bytes[place] = random(256) as u8;
        }
        let padding = random(30) as usize;
        bytes.extend(std::iter::repeat_n(0xA5, padding));
        for reply in bench.replies(&bytes) {
            assert_eq!(reply.len(), bytes.len(), "round {round}");
            let end = crate::segment::datagrams(&bytes).unwrap().last().unwrap().end;
            assert_eq!(reply[end..], bytes[end..], "round {round}: padding is left alone");
            assert_eq!(reply[12..16], bytes[12..16], "round {round}");
        }
    }
    assert!(bench.machine.dropped > 10_000);
}
