//! Application-layer states: permitted transitions and error codes [ETG.1000.6, table 11].

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    Init = 1,
    PreOp = 2,
    SafeOp = 4,
    Op = 8,
}

pub mod code {
    pub const INVALID_CHANGE: u16 = 0x0011;
    pub const UNKNOWN_STATE: u16 = 0x0012;
    pub const NO_BOOTSTRAP: u16 = 0x0013;
    pub const INVALID_MAILBOX: u16 = 0x0016;
    pub const SYNC_ERROR: u16 = 0x001A;
    pub const WATCHDOG: u16 = 0x001B;
    pub const INVALID_OUTPUTS: u16 = 0x001D;
    pub const INVALID_INPUTS: u16 = 0x001E;
    pub const INVALID_SYNC_CYCLE: u16 = 0x0035;
}

impl State {
    pub fn name(self) -> &'static str {
        match self {
            State::Init => "INIT",
            State::PreOp => "PRE-OP",
            State::SafeOp => "SAFE-OP",
            State::Op => "OP",
        }
    }
}

/// The application layer: state, error flag and status code (registers 0x0130, 0x0134).
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    pub state: State,
    pub error: bool,
    pub code: u16,
    /// OP was requested and waits for the first outputs.
    pub waits_for_outputs: bool,
}

/// What a request needs before it is granted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// Ignored, already there or refused.
    Nothing,
    /// Goes there if this part of the configuration is right.
    Wanted(State),
}

impl Layer {
    pub fn new() -> Layer {
        Layer { state: State::Init, error: false, code: 0, waits_for_outputs: false }
    }

    /// AL control was written. `Wanted` is answered by `grant` or `refuse`.
    pub fn request(&mut self, control: u16) -> Answer {
        let (wanted, acknowledge) = (control & 0x0F, control & 0x10 != 0);
        if acknowledge {
            self.error = false;
            self.code = 0;
        } else if self.error && wanted >= self.state as u16 {
            return Answer::Nothing;
        }
        self.waits_for_outputs = false;
        let wanted = match wanted {
            1 => State::Init,
            2 => State::PreOp,
            4 => State::SafeOp,
            8 => State::Op,
            3 => return self.refuse(code::NO_BOOTSTRAP),
            _ => return self.refuse(code::UNKNOWN_STATE),
        };
        let next = match self.state {
            State::Init => State::PreOp,
            State::PreOp => State::SafeOp,
            State::SafeOp | State::Op => State::Op,
        };
        if wanted > next {
            return self.refuse(code::INVALID_CHANGE);
        }
        Answer::Wanted(wanted)
    }

    pub fn grant(&mut self, state: State) {
        self.state = state;
        self.waits_for_outputs = false;
    }

    pub fn refuse(&mut self, code: u16) -> Answer {
        self.error = true;
        self.code = code;
        Answer::Nothing
    }

    /// Falls by itself.
    pub fn fall(&mut self, state: State, code: u16) {
        self.grant(state);
        // without a code the drive does not say why, and sets no error flag
        if code != 0 {
            self.refuse(code);
        }
    }

    pub fn status(&self) -> u16 {
        self.state as u16 | if self.error { 0x10 } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The whole table: state, request, answer, code. 0: granted.
    #[test]
    fn every_request_in_every_state_is_answered_as_the_table_says() {
        use code::{INVALID_CHANGE as X, NO_BOOTSTRAP as B, UNKNOWN_STATE as U};
        use State::{Init, Op, PreOp, SafeOp};
        let table: [(State, [u16; 6]); 4] = [
            (Init, [0, 0, B, X, X, U]),
            (PreOp, [0, 0, B, 0, X, U]),
            (SafeOp, [0, 0, B, 0, 0, U]),
            (Op, [0, 0, B, 0, 0, U]),
        ];
        for (state, codes) in table {
            for (request, wanted) in [1, 2, 3, 4, 8, 7].into_iter().zip(codes) {
                let mut layer = Layer { state, ..Layer::new() };
                let answer = layer.request(request);
                assert_eq!(layer.code, wanted, "{state:?} asked for {request}");
                assert_eq!(layer.error, wanted != 0);
                assert_eq!(matches!(answer, Answer::Wanted(_)), wanted == 0);
                assert_eq!(layer.state, state, "only grant() moves");
            }
        }
    }

    #[test]
    fn an_error_must_be_acknowledged_but_the_way_down_is_open() {
        let mut layer = Layer::new();
        layer.fall(State::SafeOp, code::WATCHDOG);
        assert_eq!((layer.status(), layer.code), (0x14, 0x1B));
        assert_eq!(layer.request(8), Answer::Nothing);
        assert_eq!(layer.status(), 0x14);
        assert_eq!(layer.request(1), Answer::Wanted(State::Init));
        assert_eq!(layer.request(0x14), Answer::Wanted(State::SafeOp));
        assert_eq!((layer.status(), layer.code), (4, 0));
        assert_eq!(layer.request(8), Answer::Wanted(State::Op));
    }
}
