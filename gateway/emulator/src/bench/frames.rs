//! Frames of the test MainDevice: building and reading them.

/// Bytes out and in of an AKD as the test bench maps it.
pub const OUT: usize = 8;
pub const IN: usize = 16;

/// A datagram that came back: address as changed on the way, data, working counter.
#[derive(Debug, Clone, PartialEq)]
pub struct Reply {
    pub position: u16,
    pub data: Vec<u8>,
    pub counter: u16,
}

/// One datagram: command, position or station, offset, data.
pub type Request = (u8, u16, u16, Vec<u8>);

pub fn frame(requests: &[Request]) -> Vec<u8> {
    let mut bytes = vec![0xFF; 6];
    bytes.extend([0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x88, 0xA4]);
    let size: usize = requests.iter().map(|request| 12 + request.3.len()).sum();
    bytes.extend((size as u16 | 0x1000).to_le_bytes());
    for (k, (command, position, offset, data)) in requests.iter().enumerate() {
        let more = if k + 1 < requests.len() { 0x8000 } else { 0 };
        bytes.extend([*command, k as u8]);
        bytes.extend(position.to_le_bytes());
        bytes.extend(offset.to_le_bytes());
        bytes.extend((data.len() as u16 | more).to_le_bytes());
        bytes.extend([0, 0]);
        bytes.extend(data);
        bytes.extend([0, 0]);
    }
    bytes
}

pub fn parse(bytes: &[u8]) -> Vec<Reply> {
    let ranges = crate::segment::datagrams(bytes).expect("a reply is a sound frame");
    let part = |range: std::ops::Range<usize>| {
        let (part, end) = (&bytes[range.clone()], range.len() - 2);
        Reply {
            position: u16::from_le_bytes([part[2], part[3]]),
            data: part[10..end].to_vec(),
            counter: u16::from_le_bytes([part[end], part[end + 1]]),
        }
    };
    ranges.into_iter().map(part).collect()
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    pub status: u16,
    pub mode: i8,
    pub position: i32,
    pub current: i32,
}

pub fn inputs(reply: &[u8]) -> (Vec<Inputs>, u16) {
    let reply = parse(reply).remove(0);
    let long = |data: &[u8]| i32::from_le_bytes([data[0], data[1], data[2], data[3]]);
    let one = |data: &[u8]| Inputs {
        status: u16::from_le_bytes([data[OUT], data[OUT + 1]]),
        mode: data[OUT + 2] as i8,
        position: long(&data[OUT + 4..]),
        current: long(&data[OUT + 8..]),
    };
    (reply.data.chunks(OUT + IN).map(one).collect(), reply.counter)
}
