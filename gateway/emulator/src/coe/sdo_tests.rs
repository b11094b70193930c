//! The SDO server against a dictionary of three objects.
use super::*;

/// 0x1000:0 four bytes; 0x1008:0 a long string; 0x2000:0 takes anything up to 100 bytes.
#[derive(Default)]
pub struct Table {
    written: Vec<u8>,
}

const TEXT: &[u8] = b"a name that is longer than one small mailbox can hold at once";

impl Objects for Table {
    fn upload(&self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        match (index, sub) {
            (0x1000, 0) => Ok(vec![0x92, 1, 2, 0]),
            (0x1000, _) => Err(abort::NO_SUBINDEX),
            (0x1008, 0) => Ok(TEXT.to_vec()),
            _ => Err(abort::NO_OBJECT),
        }
    }

    fn download(&mut self, index: u16, _sub: u8, data: &[u8]) -> Result<(), u32> {
        match index {
            0x1000 => Err(abort::READ_ONLY),
            0x2000 => {
                self.written = data.to_vec();
                Ok(())
            }
            _ => Err(abort::NO_OBJECT),
        }
    }
}

fn ask(server: &mut Server, table: &mut Table, request: &[u8]) -> Vec<u8> {
    let mut request = request.to_vec();
    request.resize(request.len().max(8), 0);
    server.answer(&request, 24, table).unwrap()
}

fn aborts_with(reply: &[u8]) -> u32 {
    assert_eq!(reply[0], 0x80, "an abort: {reply:02x?}");
    u32::from_le_bytes([reply[4], reply[5], reply[6], reply[7]])
}

#[test]
fn four_bytes_are_uploaded_expedited() {
    let reply = ask(&mut Server::default(), &mut Table::default(), &[0x40, 0, 0x10, 0]);
    assert_eq!(reply, [0x43, 0, 0x10, 0, 0x92, 1, 2, 0]);
}

#[test]
fn a_long_string_comes_in_segments_with_a_toggle() {
    let (mut server, mut table) = (Server::default(), Table::default());
    let first = ask(&mut server, &mut table, &[0x40, 8, 0x10, 0]);
    assert_eq!(first[0], 0x41);
    assert_eq!(first[4..8], (TEXT.len() as u32).to_le_bytes());
    let mut text = first[8..].to_vec();
    let mut toggle = 0;
    loop {
        let part = ask(&mut server, &mut table, &[0x60 | toggle]);
        assert_eq!(part[0] & 0x10, toggle);
        let unused = usize::from(part[0] >> 1 & 7);
        text.extend(&part[1..part.len() - unused]);
        toggle ^= 0x10;
        if part[0] & 1 == 1 {
            break;
        }
    }
    assert_eq!(text, TEXT);
    assert_eq!(aborts_with(&ask(&mut server, &mut table, &[0x60])), abort::COMMAND);
}

#[test]
fn a_wrong_toggle_aborts_the_transfer() {
    let (mut server, mut table) = (Server::default(), Table::default());
    ask(&mut server, &mut table, &[0x40, 8, 0x10, 0]);
    assert_eq!(aborts_with(&ask(&mut server, &mut table, &[0x70])), abort::TOGGLE);
}

#[test]
fn downloads_arrive_expedited_normal_and_in_segments() {
    let (mut server, mut table) = (Server::default(), Table::default());
    assert_eq!(ask(&mut server, &mut table, &[0x2B, 0, 0x20, 0, 7, 8])[0], 0x60);
    assert_eq!(table.written, [7, 8]);
    ask(&mut server, &mut table, &[0x21, 0, 0x20, 0, 5, 0, 0, 0, 1, 2, 3, 4, 5]);
    assert_eq!(table.written, [1, 2, 3, 4, 5]);
    ask(&mut server, &mut table, &[0x21, 0, 0x20, 0, 12, 0, 0, 0]);
    assert_eq!(ask(&mut server, &mut table, &[0, 1, 2, 3, 4, 5, 6, 7])[0], 0x20);
    // five bytes, so two of the seven are unused
    assert_eq!(ask(&mut server, &mut table, &[0x15, 8, 9, 10, 11, 12, 0, 0])[0], 0x30);
    assert_eq!(table.written, (1..=12).collect::<Vec<u8>>());
}

#[test]
fn every_refusal_has_its_code() {
    let (mut server, mut table) = (Server::default(), Table::default());
    let mut code = |request: &[u8]| aborts_with(&ask(&mut server, &mut table, request));
    assert_eq!(code(&[0x40, 0, 0x10, 1]), abort::NO_SUBINDEX);
    assert_eq!(code(&[0x40, 0, 0x30, 0]), abort::NO_OBJECT);
    assert_eq!(code(&[0x23, 0, 0x10, 0, 1, 0, 0, 0]), abort::READ_ONLY);
    assert_eq!(code(&[0x50, 8, 0x10, 0]), abort::UNSUPPORTED_ACCESS, "complete access");
    assert_eq!(code(&[0x33, 0, 0x20, 0]), abort::UNSUPPORTED_ACCESS, "complete access");
    assert_eq!(code(&[0xE0, 0, 0x20, 0]), abort::COMMAND);
    assert_eq!(code(&[0x21, 0, 0x20, 0, 0xFF, 0xFF, 0xFF, 0xFF]), abort::TOO_LONG);
    assert_eq!(code(&[0x00, 1, 2, 3]), abort::COMMAND, "a segment of no transfer");
}

#[test]
fn a_segment_too_many_is_refused() {
    let (mut server, mut table) = (Server::default(), Table::default());
    ask(&mut server, &mut table, &[0x21, 0, 0x20, 0, 3, 0, 0, 0]);
    assert_eq!(
        aborts_with(&ask(&mut server, &mut table, &[1, 1, 2, 3, 4, 5, 6, 7])),
        abort::TOO_LONG
    );
}
