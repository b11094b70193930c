//! Contents of the EEPROM: identity, mailbox, strings, sync managers, FMMUs, PDOs [ETG.2010].
use crate::coe::pdo::{Direction, Entry, Pdo};

/// Identity of a SubDevice.
#[derive(Debug, Clone, PartialEq)]
pub struct Identity {
    pub vendor: u32,
    pub product: u32,
    pub revision: u32,
    pub serial: u32,
    pub alias: u16,
}

pub const MAILBOX_OUT: u16 = 0x1000;
pub const MAILBOX_IN: u16 = 0x1400;
pub const OUTPUTS: u16 = 0x1800;
pub const INPUTS: u16 = 0x1C00;
const BYTES: usize = 2048;
const COE: u8 = 0x04;
/// SDO, PDO assignment and configuration; no SDO information, no complete access.
const COE_DETAILS: u8 = 0x01 | 0x04 | 0x08;

pub fn image(
    identity: &Identity,
    name: &str,
    mailbox_bytes: u16,
    output_control: u8,
    (outputs, inputs): (&Direction, &Direction),
) -> Vec<u8> {
    let mut bytes = header(identity, mailbox_bytes);
    // strings: 1 name, 2 group
    let mut strings = vec![2];
    for text in [name, "Drives"] {
        strings.push(text.len() as u8);
        strings.extend(text.as_bytes());
    }
    category(&mut bytes, 10, strings);
    let mut general = vec![2, 0, 1, 1, 0, COE_DETAILS, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x11, 0];
    general.resize(32, 0);
    category(&mut bytes, 30, general);
    // FMMUs: outputs, inputs, mailbox state
    category(&mut bytes, 40, vec![1, 2, 3, 0]);
    let mut managers = Vec::new();
    let (out, inp) = (outputs.bytes() as u16, inputs.bytes() as u16);
    for (start, length, control, kind) in [
        (MAILBOX_OUT, mailbox_bytes, 0x26, 1),
        (MAILBOX_IN, mailbox_bytes, 0x22, 2),
        (OUTPUTS, out, output_control, 3),
        (INPUTS, inp, 0x20, 4),
    ] {
        managers.extend(u16::to_le_bytes(start));
        managers.extend(u16::to_le_bytes(length));
        managers.extend([control, 0, 1, kind]);
    }
    category(&mut bytes, 41, managers);
    category(&mut bytes, 50, pdos(inputs, 3));
    category(&mut bytes, 51, pdos(outputs, 2));
    bytes.extend([0xFF, 0xFF]);
    bytes.resize(BYTES, 0xFF);
    bytes
}

fn header(identity: &Identity, mailbox_bytes: u16) -> Vec<u8> {
    let mut words = [0u16; 64];
    words[0] = 0x0C08;
    words[1] = 0x6600;
    words[4] = identity.alias;
    let halves = |value: u32| [value as u16, (value >> 16) as u16];
    let of_identity = [identity.vendor, identity.product, identity.revision, identity.serial];
    for (place, value) in (8..).step_by(2).zip(of_identity) {
        words[place..place + 2].copy_from_slice(&halves(value));
    }
    words[0x18..0x1D].copy_from_slice(&[
        MAILBOX_OUT,
        mailbox_bytes,
        MAILBOX_IN,
        mailbox_bytes,
        u16::from(COE),
    ]);
    words[0x3E] = (BYTES / 128 - 1) as u16;
    words[0x3F] = 1;
    let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes[14] = checksum(&bytes[..14]);
    bytes
}

/// CRC-8 with x^8 + x^2 + x + 1, from 0xFF.
fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0xFF, |crc: u8, byte| {
        (0..8).fold(crc ^ byte, |crc, _| crc << 1 ^ if crc & 0x80 != 0 { 0x07 } else { 0 })
    })
}

fn category(bytes: &mut Vec<u8>, kind: u16, mut body: Vec<u8>) {
    if body.is_empty() {
        return;
    }
    body.resize(body.len().next_multiple_of(2), 0);
    bytes.extend(kind.to_le_bytes());
    bytes.extend((body.len() as u16 / 2).to_le_bytes());
    bytes.extend(body);
}

fn pdos(direction: &Direction, sync_manager: u8) -> Vec<u8> {
    let assigned = |pdo: &&Pdo| direction.assigned.contains(&pdo.index);
    let mut bytes = Vec::new();
    for pdo in direction.pdos.iter().filter(assigned) {
        bytes.extend(pdo.index.to_le_bytes());
        bytes.extend([pdo.entries.len() as u8, sync_manager, 0, 0, 0, 0]);
        for entry in &pdo.entries {
            bytes.extend(entry.index.to_le_bytes());
            bytes.extend([entry.sub, 0, data_type(entry), entry.bits, 0, 0]);
        }
    }
    bytes
}

/// Base data types of CoE: integers by size; 0 for a gap.
fn data_type(entry: &Entry) -> u8 {
    match entry.bits {
        _ if entry.is_pad() => 0,
        8 => 2,
        16 => 6,
        _ => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::kind::Kind;

    fn bytes() -> Vec<u8> {
        let identity =
            Identity { vendor: 0x6A, product: 0x0041_4B44, revision: 2, serial: 77, alias: 1234 };
        let kind = Kind::Akd;
        image(&identity, "AKD", 512, 0x64, (&kind.outputs(), &kind.inputs()))
    }

    fn word(bytes: &[u8], address: usize) -> u16 {
        u16::from_le_bytes([bytes[2 * address], bytes[2 * address + 1]])
    }

    #[test]
    fn the_header_says_who_it_is_and_where_the_mailboxes_are() {
        let bytes = bytes();
        assert_eq!(bytes.len(), 2048);
        assert_eq!(word(&bytes, 4), 1234);
        let identity: Vec<u16> = (8..16).map(|address| word(&bytes, address)).collect();
        assert_eq!(identity, [0x6A, 0, 0x4B44, 0x0041, 2, 0, 77, 0]);
        let mailbox: Vec<u16> = (0x18..0x1D).map(|address| word(&bytes, address)).collect();
        assert_eq!(mailbox, [0x1000, 512, 0x1400, 512, 4]);
        // 2 kB are 16 kbit; the register holds one less
        assert_eq!(word(&bytes, 0x3E), 15);
    }

    #[test]
    fn the_checksum_is_the_one_of_the_standard() {
        // example: PDI 0x0C08 0x6600 and zeros, worked out by long division
        assert_eq!(checksum(b"123456789"), 0xFB, "CRC-8 with initial value 0xFF");
        assert_eq!(bytes()[14], checksum(&bytes()[..14]));
    }

    #[test]
    fn categories_are_chained_to_the_end_mark() {
        let bytes = bytes();
        let (mut address, mut kinds) = (0x40, Vec::new());
        while word(&bytes, address) != 0xFFFF {
            kinds.push(word(&bytes, address));
            address += 2 + usize::from(word(&bytes, address + 1));
        }
        assert_eq!(kinds, [10, 30, 40, 41, 50, 51]);
    }

    #[test]
    fn sync_managers_have_the_sizes_of_the_maps() {
        let bytes = bytes();
        let mut address = 0x40;
        while word(&bytes, address) != 41 {
            address += 2 + usize::from(word(&bytes, address + 1));
        }
        let lengths: Vec<u16> = (0..4).map(|k| word(&bytes, address + 2 + 4 * k + 1)).collect();
        // the map at power-up: torque and controlword, position and statusword
        assert_eq!(lengths, [512, 512, 4, 6]);
    }
}
