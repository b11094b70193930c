//! Emergency messages of drives [ETG.1000.6, 5.6.4] in the place of an answer. ethercrab panics at one, so the mailbox is
//! read again until the answer is there, and it never sees the message.

/// Frame: command, address in the device, length, data.
const COMMAND: usize = 16;
const REGISTER: usize = 20;
const LENGTH: usize = 22;
const DATA: usize = 26;
const FPRD: u8 = 4;
/// Memory of a device above its registers: of one device alone only mailboxes are read there.
const MEMORY: u16 = 0x1000;
/// Kind of a message, byte 5 of its header, and service, byte 7.
const COE: u8 = 3;
const EMERGENCY: u8 = 1;

/// How often a mailbox is read again: some 0.1 s, less than ethercrab waits for a reply.
pub const MOST: u16 = 1000;

/// A reply, or a request that becomes one, for which `again` counts the readings so far.
pub fn asks_again(frame: &[u8], again: u16) -> bool {
    let word = |at: usize| u16::from_le_bytes([frame[at], frame[at + 1]]);
    if frame.len() < DATA + 10 || frame[COMMAND] != FPRD || word(REGISTER) < MEMORY {
        return false;
    }
    let end = DATA + usize::from(word(LENGTH) & 0x7FF);
    if end + 2 > frame.len() || again >= MOST {
        return false;
    }
    let emergency = frame[DATA + 5] & 0x0F == COE && frame[DATA + 7] >> 4 == EMERGENCY;
    // empty: the answer is not there yet
    emergency || again > 0 && word(end) == 0
}

/// The same request again.
pub fn request(reply: &mut [u8]) {
    // bit of the first device in the source address
    reply[6] &= !0x02;
    reply[DATA..].fill(0);
}
