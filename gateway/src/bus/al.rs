//! Application-layer (AL) states of EtherCAT devices and their status codes [ETG.1000.6, ETG.1020].

pub const INIT: u8 = 1;
pub const PRE_OP: u8 = 2;
pub const SAFE_OP: u8 = 4;
pub const OP: u8 = 8;
/// The bits of AL status that hold the state; bit 4 reports an error.
pub const STATE: u8 = 0x0f;
/// The bit of AL control that acknowledges an error.
pub const ACKNOWLEDGE: u8 = 0x10;

pub const CONTROL: u16 = 0x0120;
pub const STATUS: u16 = 0x0130;
pub const STATUS_CODE: u16 = 0x0134;

/// Name of the state in an AL status.
pub fn name(status: u8) -> &'static str {
    match status & STATE {
        INIT => "INIT",
        PRE_OP => "PRE-OP",
        3 => "BOOTSTRAP",
        SAFE_OP => "SAFE-OP",
        OP => "OP",
        _ => "no reply",
    }
}

/// Code, meaning, remedy.
#[rustfmt::skip]
const CODES: [(u16, &str, &str); 27] = [
    (0x0000, "no error", "another program may have asked the drive to change its state: end it; if the drive is only \
     slow, raise bus.state_timeout_ms"),
    (0x0001, "unspecified error", "read the fault that the drive displays"),
    (0x0011, "invalid requested state change", "switch the drive off and on"),
    (0x0014, "no valid firmware", "load the firmware of the drive again"),
    (0x0016, "invalid mailbox configuration", "its EEPROM does not fit its firmware"),
    (0x0017, "invalid sync manager configuration", "compare profile.rx and profile.tx with its PDOs"),
    (0x0018, "no valid inputs", "the drive has no valid encoder: check its cable"),
    (0x0019, "no valid outputs", "no frame arrived in time: check cable and real-time settings"),
    (0x001a, "synchronisation error", "clocks or cycle jitter too much: check real-time settings"),
    (0x001b, "process data watchdog",
     "no frame within bus.watchdog_ms: check cable and real-time settings, or raise it"),
    (0x001d, "invalid output configuration", "compare profile.rx with its objects 0x1C12 and 0x16xx"),
    (0x001e, "invalid input configuration", "compare profile.tx with its objects 0x1C13 and 0x1Axx"),
    (0x001f, "invalid watchdog configuration",
     "the drive does not take bus.watchdog_ms: raise it, at most to its default (100 ms)"),
    (0x0020, "needs a cold start", "switch the drive off and on"),
    (0x0021, "needs INIT", "run `flexhex-gateway off`, then try again"),
    (0x0024, "invalid input mapping", "compare the objects of profile.tx with its manual"),
    (0x0025, "invalid output mapping", "compare the objects of profile.rx with its manual"),
    (0x0026, "inconsistent settings", "compare the start-up list with its manual"),
    (0x0027, "free run not supported", "set bus.distributed_clocks = true"),
    (0x0028, "synchronisation mode not supported",
     "compare object 0x1C32 and bus.distributed_clocks with its manual"),
    (0x0029, "free run needs three buffers", "set bus.distributed_clocks = true"),
    (0x002b, "no valid inputs and outputs", "check encoder, cable and real-time settings"),
    (0x002c, "fatal synchronisation error", "SYNC0 is missing: check bus.distributed_clocks"),
    (0x002d, "no SYNC0", "check bus.distributed_clocks and its DC support"),
    (0x0030, "invalid configuration of distributed clocks",
     "compare bus.distributed_clocks and the cycle time with its manual"),
    (0x0032, "phase-locked loop not locked", "check cycle jitter and bus.sync0_shift_us"),
    (0x0035, "invalid cycle time of SYNC0",
     "the drive does not take the cycle time of the system: compare object 0x60C2 with its manual"),
];

/// A status code with its meaning and remedy.
pub fn describe(code: u16) -> String {
    match CODES.iter().find(|(known, ..)| *known == code) {
        Some((_, meaning, remedy)) => {
            format!("AL status code {code:#06x} ({meaning}): {remedy}")
        }
        None => format!("AL status code {code:#06x}: look it up in the manual of the drive"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_told_in_words_with_a_remedy() {
        assert!(describe(0x1b).contains("0x001b (process data watchdog): no frame within"));
        assert!(describe(0x35).contains("0x0035 (invalid cycle time of SYNC0): the drive"));
        assert!(describe(0x8001).contains("0x8001: look it up"));
        assert!(CODES.is_sorted_by_key(|(code, ..)| code));
    }
}
