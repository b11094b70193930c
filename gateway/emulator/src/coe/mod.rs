//! Mailbox and CANopen over EtherCAT: one request in, at most one reply out [ETG.1000.6, 5.6].
pub mod abort;
pub mod pdo;
pub mod sdo;

use sdo::{Objects, Server};

const HEADER: usize = 6;
const TYPE_ERROR: u8 = 0;
const TYPE_COE: u8 = 3;
const COE_EMERGENCY: u16 = 1;
const COE_SDO_REQUEST: u16 = 2;
const COE_SDO_REPLY: u16 = 3;
const ERROR_UNSUPPORTED_PROTOCOL: u16 = 2;
const ERROR_SERVICE_NOT_SUPPORTED: u16 = 4;
const ERROR_INVALID_HEADER: u16 = 5;
const ERROR_TOO_SHORT: u16 = 6;

/// The mailbox of one SubDevice.
#[derive(Default)]
pub struct Mailbox {
    server: Server,
    counter: u8,
}

impl Mailbox {
    /// Drops a transfer in progress.
    pub fn reset(&mut self) {
        *self = Mailbox::default();
    }

    /// request: all bytes of the mailbox; room: bytes of the reply's mailbox. A reply begins with
    /// its header and is shorter than room.
    pub fn answer(
        &mut self,
        request: &[u8],
        room: usize,
        objects: &mut dyn Objects,
    ) -> Option<Vec<u8>> {
        if room < HEADER + 10 {
            return None;
        }
        let header = request.get(..HEADER)?;
        let length = usize::from(u16::from_le_bytes([header[0], header[1]]));
        let Some(body) = request.get(HEADER..HEADER + length) else {
            return Some(self.error(ERROR_INVALID_HEADER));
        };
        if header[5] & 0x0F != TYPE_COE {
            return Some(self.error(ERROR_UNSUPPORTED_PROTOCOL));
        }
        let Some((coe, sdo)) = body.split_first_chunk::<2>() else {
            return Some(self.error(ERROR_TOO_SHORT));
        };
        if u16::from_le_bytes(*coe) >> 12 != COE_SDO_REQUEST {
            return Some(self.error(ERROR_SERVICE_NOT_SUPPORTED));
        }
        if sdo.len() < 8 {
            return Some(self.error(ERROR_TOO_SHORT));
        }
        let reply = self.server.answer(sdo, room - HEADER - 2, objects)?;
        // an abort is a request by the standard, whoever sends it [ETG.1000.6, 5.6.2.7]
        let aborts = reply.first() == Some(&0x80);
        let service = if aborts { COE_SDO_REQUEST } else { COE_SDO_REPLY };
        let mut body = (service << 12).to_le_bytes().to_vec();
        body.extend(reply);
        Some(self.message(TYPE_COE, &body))
    }

    /// An emergency message with this error code, which nobody asked for [ETG.1000.6, 5.6.4].
    pub fn emergency(&mut self, code: u16) -> Vec<u8> {
        let mut body = (COE_EMERGENCY << 12).to_le_bytes().to_vec();
        body.extend(code.to_le_bytes());
        body.extend([0; 6]);
        self.message(TYPE_COE, &body)
    }

    fn error(&mut self, code: u16) -> Vec<u8> {
        let body = [1u16.to_le_bytes(), code.to_le_bytes()].concat();
        self.message(TYPE_ERROR, &body)
    }

    fn message(&mut self, kind: u8, body: &[u8]) -> Vec<u8> {
        self.counter = self.counter % 7 + 1;
        let mut message = (body.len() as u16).to_le_bytes().to_vec();
        message.extend([0, 0, 0, self.counter << 4 | kind]);
        message.extend(body);
        message
    }
}

#[cfg(test)]
mod tests {
    use super::sdo::tests::Table;
    use super::*;

    fn request(kind: u8, body: &[u8]) -> Vec<u8> {
        let mut bytes = (body.len() as u16).to_le_bytes().to_vec();
        bytes.extend([0, 0, 0, kind]);
        bytes.extend(body);
        bytes.resize(64, 0);
        bytes
    }

    #[test]
    fn what_is_not_spoken_is_answered_with_a_mailbox_error() {
        let mut mailbox = Mailbox::default();
        let mut code = |bytes: &[u8]| {
            let reply = mailbox.answer(bytes, 64, &mut Table::default()).unwrap();
            assert_eq!(reply[5] & 0x0F, TYPE_ERROR);
            u16::from_le_bytes([reply[8], reply[9]])
        };
        // FoE; SDO information (service 8); a length beyond the mailbox; nothing in it
        assert_eq!(code(&request(4, &[0; 10])), ERROR_UNSUPPORTED_PROTOCOL);
        assert_eq!(code(&request(3, &[0, 0x80, 1, 0, 0, 0, 0, 0])), ERROR_SERVICE_NOT_SUPPORTED);
        assert_eq!(code(&[0xFF, 0xFF, 0, 0, 0, 3, 0]), ERROR_INVALID_HEADER);
        assert_eq!(code(&request(3, &[0])), ERROR_TOO_SHORT);
        assert_eq!(code(&request(3, &[0, 0x20, 0x40])), ERROR_TOO_SHORT);
    }

    #[test]
    fn an_abort_goes_out_as_a_request_and_data_as_a_reply() {
        let mut mailbox = Mailbox::default();
        let mut service = |index: u8| {
            let read = request(3, &[0, 0x20, 0x40, 0x00, index, 0, 0, 0, 0, 0]);
            mailbox.answer(&read, 64, &mut Table::default()).unwrap()[7] >> 4
        };
        assert_eq!((service(0x10), service(0x50)), (3, 2));
    }

    #[test]
    fn replies_count_from_one_to_seven() {
        let mut mailbox = Mailbox::default();
        let read = request(3, &[0, 0x20, 0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
        let counters: Vec<u8> = (0..8)
            .map(|_| mailbox.answer(&read, 64, &mut Table::default()).unwrap()[5] >> 4)
            .collect();
        assert_eq!(counters, [1, 2, 3, 4, 5, 6, 7, 1]);
    }
}
