//! The state machine of a CiA 402 drive: what a statusword means, which controlword comes next.

pub const DISABLE_VOLTAGE: u16 = 0x0000;
pub const QUICK_STOP: u16 = 0x0002;
pub const SHUTDOWN: u16 = 0x0006;
pub const SWITCH_ON: u16 = 0x0007;
pub const ENABLE_OPERATION: u16 = 0x000f;
pub const FAULT_RESET: u16 = 0x0080;

/// Bits of a statusword.
pub const FAULT_BIT: u16 = 0x0008;
/// What a drive says without a fault: bit, its value, and its meaning.
pub const REMARKS: [(u16, u16, &str); 3] = [
    (0x0010, 0x0000, "no voltage at the power stage (bit 4 of the statusword)"),
    (0x0080, 0x0080, "warning (bit 7 of the statusword)"),
    (0x0800, 0x0800, "internal limit active (bit 11 of the statusword)"),
];
/// The bits that encode the state, and their value in operation enabled.
pub const STATE_BITS: u16 = 0x006f;
pub const OPERATION_ENABLED: u16 = 0x0027;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    NotReady,
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    QuickStopActive,
    FaultReaction,
    Fault,
}

impl State {
    /// The power stage may carry current.
    pub fn is_energised(self) -> bool {
        use State::{FaultReaction, OperationEnabled, QuickStopActive, SwitchedOn};
        matches!(self, SwitchedOn | OperationEnabled | QuickStopActive | FaultReaction)
    }

    pub fn name(self) -> &'static str {
        match self {
            State::NotReady => "not ready to switch on",
            State::SwitchOnDisabled => "switch on disabled",
            State::ReadyToSwitchOn => "ready to switch on",
            State::SwitchedOn => "switched on",
            State::OperationEnabled => "operation enabled",
            State::QuickStopActive => "quick stop active",
            State::FaultReaction => "fault reaction active",
            State::Fault => "fault",
        }
    }
}

/// State in a statusword (CiA 402-2, table of state coding).
pub fn state(statusword: u16) -> State {
    match statusword & 0x4f {
        0x40 => return State::SwitchOnDisabled,
        0x0f => return State::FaultReaction,
        0x08 => return State::Fault,
        _ => {}
    }
    match statusword & STATE_BITS {
        0x21 => State::ReadyToSwitchOn,
        0x23 => State::SwitchedOn,
        OPERATION_ENABLED => State::OperationEnabled,
        0x07 => State::QuickStopActive,
        _ => State::NotReady,
    }
}

/// Switched on, or enabled already.
pub fn is_switched_on(now: State) -> bool {
    matches!(now, State::SwitchedOn | State::OperationEnabled)
}

/// Controlword of the next step towards operation enabled; a fault is not reset.
pub fn towards_enabled(now: State) -> u16 {
    match now {
        State::SwitchOnDisabled => SHUTDOWN,
        State::ReadyToSwitchOn => SWITCH_ON,
        State::SwitchedOn | State::OperationEnabled => ENABLE_OPERATION,
        _ => DISABLE_VOLTAGE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statuswords_are_read_whatever_their_other_bits_say() {
        for (word, wanted) in [
            (0x0000, State::NotReady),
            (0x0250, State::SwitchOnDisabled),
            (0x0231, State::ReadyToSwitchOn),
            (0x0233, State::SwitchedOn),
            (0x1637, State::OperationEnabled),
            (0x0017, State::QuickStopActive),
            (0x021f, State::FaultReaction),
            (0x0218, State::Fault),
            (0x0238, State::Fault),
        ] {
            assert_eq!(state(word), wanted, "{word:#06x}");
        }
    }

    #[test]
    fn enabling_walks_through_every_state_and_never_resets_a_fault() {
        let words: Vec<_> =
            [0x40, 0x21, 0x23, 0x27, 0x08, 0x07].map(|w| towards_enabled(state(w))).into();
        assert_eq!(words, [0x06, 0x07, 0x0f, 0x0f, 0x00, 0x00]);
    }

    #[test]
    fn only_states_with_current_count_as_energised() {
        let energised = [0x40, 0x21, 0x23, 0x27, 0x07, 0x0f, 0x08].map(|w| state(w).is_energised());
        assert_eq!(energised, [false, false, true, true, true, true, false]);
    }
}
