//! The state machine of a CiA 402 drive [IEC 61800-7-201, 6.2].

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    SwitchOnDisabled,
    ReadyToSwitchOn,
    SwitchedOn,
    OperationEnabled,
    QuickStopActive,
    FaultReactionActive,
    Fault,
}

use State::{
    Fault, FaultReactionActive, OperationEnabled, QuickStopActive, ReadyToSwitchOn,
    SwitchOnDisabled, SwitchedOn,
};

impl State {
    pub fn name(self) -> &'static str {
        match self {
            SwitchOnDisabled => "switch on disabled",
            ReadyToSwitchOn => "ready to switch on",
            SwitchedOn => "switched on",
            OperationEnabled => "operation enabled",
            QuickStopActive => "quick stop active",
            FaultReactionActive => "fault reaction active",
            Fault => "fault",
        }
    }

    /// Statusword: the state, voltage enabled (bit 4) and remote (bit 9).
    pub fn statusword(self) -> u16 {
        let state = match self {
            SwitchOnDisabled => 0x40,
            ReadyToSwitchOn => 0x21,
            SwitchedOn => 0x23,
            OperationEnabled => 0x27,
            QuickStopActive => 0x07,
            FaultReactionActive => 0x0F,
            Fault => 0x08,
        };
        state | 0x0210
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Command {
    Shutdown,
    SwitchOn,
    EnableOperation,
    DisableVoltage,
    QuickStop,
}

/// Command in bits 0 to 3 of a controlword.
fn command(word: u16) -> Command {
    match word & 0x0F {
        bits if bits & 2 == 0 => Command::DisableVoltage,
        bits if bits & 4 == 0 => Command::QuickStop,
        bits if bits & 1 == 0 => Command::Shutdown,
        0x07 => Command::SwitchOn,
        _ => Command::EnableOperation,
    }
}

#[derive(Debug, Clone)]
pub struct Machine {
    pub state: State,
    /// Object 0x603F; 0: none.
    pub error: u16,
    /// It stays switched on.
    pub never_enabled: bool,
    last: u16,
}

impl Machine {
    pub fn new(state: State, error: u16) -> Machine {
        Machine { state, error, never_enabled: false, last: 0 }
    }

    /// A controlword arrives: at most one transition.
    pub fn control(&mut self, word: u16) {
        let reset = word & 0x80 != 0 && self.last & 0x80 == 0;
        self.last = word;
        let command = command(word);
        self.state = match (self.state, command) {
            (FaultReactionActive, _) => Fault,
            (Fault, _) if reset => {
                self.error = 0;
                SwitchOnDisabled
            }
            (Fault, _) => Fault,
            (_, Command::DisableVoltage) => SwitchOnDisabled,
            (OperationEnabled, Command::QuickStop) => QuickStopActive,
            // the stop is over at once: a drive in torque mode has no ramp here
            (QuickStopActive, _) => SwitchOnDisabled,
            (_, Command::QuickStop) => SwitchOnDisabled,
            (_, Command::Shutdown) => ReadyToSwitchOn,
            (ReadyToSwitchOn | OperationEnabled, Command::SwitchOn) => SwitchedOn,
            // enable operation from "ready to switch on" passes "switched on"
            (ReadyToSwitchOn, Command::EnableOperation) => SwitchedOn,
            (SwitchedOn, Command::EnableOperation) if !self.never_enabled => OperationEnabled,
            (state, Command::SwitchOn | Command::EnableOperation) => state,
        };
    }

    /// A cycle has passed: the reaction to a fault is over.
    pub fn settle(&mut self) {
        if self.state == FaultReactionActive {
            self.state = Fault;
        }
    }

    /// Safe torque off: without power, and without a fault.
    pub fn cut(&mut self) {
        if !matches!(self.state, Fault | FaultReactionActive) {
            self.state = SwitchOnDisabled;
        }
    }

    pub fn raise(&mut self, error: u16) {
        if !matches!(self.state, Fault | FaultReactionActive) {
            self.state = FaultReactionActive;
            self.error = error;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every state under every command, as the standard's table says.
    #[test]
    fn every_command_in_every_state_goes_where_the_table_says() {
        // controlwords: disable voltage, quick stop, shutdown, switch on, enable operation
        let words = [0x00, 0x02, 0x06, 0x07, 0x0F];
        let (d, r, s, o) = (SwitchOnDisabled, ReadyToSwitchOn, SwitchedOn, OperationEnabled);
        let (q, f) = (QuickStopActive, Fault);
        let table = [
            (d, [d, d, r, d, d]),
            (r, [d, d, r, s, s]),
            (s, [d, d, r, s, o]),
            (o, [d, q, r, s, o]),
            (q, [d, d, d, d, d]),
            (f, [f, f, f, f, f]),
            (FaultReactionActive, [f, f, f, f, f]),
        ];
        for (from, row) in table {
            for (word, to) in words.into_iter().zip(row) {
                let mut machine = Machine::new(from, 0);
                machine.control(word);
                assert_eq!(machine.state, to, "{from:?} under {word:#04x}");
            }
        }
    }

    #[test]
    fn statuswords_are_those_of_the_standard() {
        // masks and values of the profile: 0x4F for the two that ignore quick stop, else 0x6F
        assert_eq!(SwitchOnDisabled.statusword() & 0x4F, 0x40);
        assert_eq!(ReadyToSwitchOn.statusword() & 0x6F, 0x21);
        assert_eq!(SwitchedOn.statusword() & 0x6F, 0x23);
        assert_eq!(OperationEnabled.statusword() & 0x6F, 0x27);
        assert_eq!(QuickStopActive.statusword() & 0x6F, 0x07);
        assert_eq!(FaultReactionActive.statusword() & 0x4F, 0x0F);
        assert_eq!(Fault.statusword() & 0x4F, 0x08);
    }

    #[test]
    fn only_a_rising_edge_resets_a_fault() {
        let mut machine = Machine::new(OperationEnabled, 0);
        machine.control(0x8F);
        machine.raise(0x7305);
        assert_eq!((machine.state, machine.error), (FaultReactionActive, 0x7305));
        machine.control(0x8F);
        machine.control(0x8F);
        assert_eq!(machine.state, Fault, "the bit was set all the time");
        machine.control(0x00);
        machine.raise(0x1234);
        assert_eq!(machine.error, 0x7305, "the first fault stays");
        machine.control(0x80);
        assert_eq!((machine.state, machine.error), (SwitchOnDisabled, 0));
    }
}
