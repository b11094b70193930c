//! Numbers of objects.

/// Little-endian two's complement of any width up to 8 bytes.
pub(super) fn signed(data: &[u8]) -> i64 {
    let negative = data.last().is_some_and(|byte| byte & 0x80 != 0);
    let mut bytes = [if negative { 0xFF } else { 0 }; 8];
    for (byte, value) in bytes.iter_mut().zip(data) {
        *byte = *value;
    }
    i64::from_le_bytes(bytes)
}
