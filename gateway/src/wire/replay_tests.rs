use super::*;

/// A capture of these frames, as tcpdump writes it.
pub fn pcap(frames: &[Vec<u8>]) -> Vec<u8> {
    let mut out = Vec::new();
    for word in [MAGIC, 0x0004_0002, 0, 0, 65535, ETHERNET] {
        out.extend(word.to_le_bytes());
    }
    for frame in frames {
        let length = frame.len() as u32;
        for word in [0, 0, length, length] {
            out.extend(word.to_le_bytes());
        }
        out.extend(frame);
    }
    out
}

/// A frame with one datagram; `number` in its source address.
fn frame(command: u8, number: u8, data: &[u8]) -> Vec<u8> {
    let mut out = vec![0xFF; 6];
    out.extend([0x10, 0x10, number, 0, 0, 0, 0x88, 0xA4]);
    let length = data.len() as u8;
    out.extend([length + 12, 0x10, command, number, 1, 0, 2, 0, length, 0, 0, 0]);
    out.extend(data);
    out.extend([0, 0]);
    out
}

fn reply(request: &[u8], counter: u8) -> Vec<u8> {
    let mut out = request.to_vec();
    out[6] |= ANSWERED;
    let last = out.len() - 2;
    out[last] = counter;
    out
}

fn answered(replay: &mut Replay, request: &[u8]) -> Option<Vec<u8>> {
    let mut buffer = [0; 256];
    assert!(replay.send(request));
    replay.receive(&mut buffer).map(|length| buffer[..length].to_vec())
}

#[test]
fn requests_are_answered_as_they_were_whatever_their_numbers_are() {
    let (one, two, lost) = (frame(4, 1, &[7]), frame(5, 2, &[9]), frame(5, 3, &[8]));
    let cyclic = frame(PROCESS_DATA, 4, &[1, 2]);
    let frames = [
        one.clone(),
        reply(&one, 1),
        two.clone(),
        reply(&two, 2),
        lost,
        cyclic.clone(),
        reply(&cyclic, 3),
    ];
    let mut replay = Replay::of(&pcap(&frames)).unwrap();
    // another number, and the second request is left out
    let request = frame(4, 9, &[7]);
    assert_eq!(answered(&mut replay, &request), Some(reply(&request, 1)));
    let notice = answered(&mut replay, &frame(5, 10, &[8])).unwrap();
    assert_eq!(notice[super::super::TYPE] >> 4, super::super::NO_REPLY, "it was lost then");
    let request = frame(PROCESS_DATA, 11, &[5, 6]);
    let answer = answered(&mut replay, &request).unwrap();
    assert_eq!((answer[NUMBER.start], answer[26], answer[28]), (11, 1, 3), "with its own data");
    assert!(replay.is_over());
    assert_eq!(answered(&mut replay, &request), None);
}

#[test]
fn what_is_no_capture_is_told_and_a_cut_one_ends_early() {
    let one = frame(4, 1, &[7]);
    let whole = pcap(&[one.clone(), reply(&one, 1)]);
    let why = |bytes: &[u8]| Replay::of(bytes).err().unwrap().to_string();
    assert!(why(b"pcapng").contains("shorter than its head"));
    assert!(why(&[7; 100]).contains("tshark -F pcap"));
    assert!(why(&pcap(&[])).contains("no EtherCAT frame"));
    let mut other = whole.clone();
    other[20] = 113;
    assert!(why(&other).contains("link type 113"));
    for length in FILE_HEAD..whole.len() {
        // never a panic; complete once both frames are there
        assert_eq!(
            Replay::of(&whole[..length]).is_ok(),
            length >= FILE_HEAD + FRAME_HEAD + one.len()
        );
    }
    let mut swapped = whole.clone();
    for word in swapped[..FILE_HEAD].chunks_mut(4) {
        word.reverse();
    }
    swapped.truncate(FILE_HEAD);
    assert!(why(&swapped).contains("no EtherCAT frame"), "the other byte order is read, too");
}
