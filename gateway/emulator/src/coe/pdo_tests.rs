//! Maps are changed as on the drive: count 0, entries, count.
use super::*;

fn direction() -> Direction {
    let free = |index| Pdo { index, entries: Vec::new(), fixed: false };
    let fixed = Pdo { index: 0x1701, entries: vec![Entry::new(0x6040, 16)], fixed: true };
    let limits = Limits { pdo_bytes: 8, total_bytes: 12 };
    Direction::new(vec![free(0x1600), free(0x1601), fixed], vec![0x1701], limits)
}

fn write(maps: &mut Direction, index: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
    maps.download(index, sub, data, &|entry| matches!(entry.index, 0x6040 | 0x2071))
}

fn map(maps: &mut Direction, index: u16, entries: &[Entry]) -> Result<(), u32> {
    write(maps, index, 0, &[0])?;
    for (entry, sub) in entries.iter().zip(1..) {
        write(maps, index, sub, &entry.word().to_le_bytes())?;
    }
    write(maps, index, 0, &[entries.len() as u8])
}

#[test]
fn a_map_is_written_assigned_and_read_back() {
    let mut maps = direction();
    let entries = [Entry::new(0x6040, 16), Entry::new(0, 16), Entry::new(0x2071, 32)];
    map(&mut maps, 0x1600, &entries).unwrap();
    write(&mut maps, 0x1C12, 0, &[0]).unwrap();
    write(&mut maps, 0x1C12, 1, &[0x00, 0x16]).unwrap();
    write(&mut maps, 0x1C12, 0, &[1]).unwrap();
    assert_eq!(maps.bytes(), 8);
    assert_eq!(maps.upload(0x1600, 3), Ok(vec![32, 0, 0x71, 0x20]));
    assert_eq!(maps.upload(0x1C12, 1), Ok(vec![0, 0x16]));
    assert_eq!(maps.upload(0x1C12, 2), Err(abort::NO_SUBINDEX));
}

#[test]
fn maps_refuse_with_the_right_code() {
    let mut maps = direction();
    assert_eq!(write(&mut maps, 0x1701, 0, &[0]), Err(abort::READ_ONLY));
    assert_eq!(map(&mut maps, 0x1600, &[Entry::new(0x6077, 16)]), Err(abort::NOT_MAPPABLE));
    assert_eq!(write(&mut maps, 0x1600, 0, &[0, 0]), Err(abort::LENGTH));
    assert_eq!(write(&mut maps, 0x1600, 9, &[0; 4]), Err(abort::NO_SUBINDEX));
    assert_eq!(write(&mut maps, 0x1600, 0, &[9]), Err(abort::VALUE_RANGE));
    assert_eq!(write(&mut maps, 0x1601, 0, &[2]), Err(abort::VALUE_RANGE), "no such entries");
    let three = [Entry::new(0x2071, 32); 3];
    assert_eq!(map(&mut maps, 0x1600, &three), Err(abort::PDO_TOO_LONG), "12 of 8 bytes");
    map(&mut maps, 0x1600, &three[..1]).unwrap();
    let late = write(&mut maps, 0x1600, 1, &three[0].word().to_le_bytes());
    assert_eq!(late, Err(abort::UNSUPPORTED_ACCESS), "the count is not 0");
}

#[test]
fn the_sum_of_all_maps_is_limited_too() {
    let mut maps = direction();
    map(&mut maps, 0x1600, &[Entry::new(0x2071, 32); 2]).unwrap();
    map(&mut maps, 0x1601, &[Entry::new(0x2071, 32); 2]).unwrap();
    write(&mut maps, 0x1C12, 0, &[0]).unwrap();
    write(&mut maps, 0x1C12, 1, &[0x00, 0x16]).unwrap();
    write(&mut maps, 0x1C12, 2, &[0x01, 0x16]).unwrap();
    assert_eq!(write(&mut maps, 0x1C12, 0, &[2]), Err(abort::PDO_TOO_LONG), "16 of 12 bytes");
    write(&mut maps, 0x1C12, 0, &[1]).unwrap();
}
