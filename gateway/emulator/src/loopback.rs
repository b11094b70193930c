//! The emulated line without a cable, for a program that holds both of its ends.
use crate::assembly::assemble;
use crate::error::Error;
use crate::machine::Machine;
use crate::options::Options;
use crate::plant::AXES;

/// Six drives in lockstep: each frame of process data is a cycle of the plant.
pub struct Loopback {
    machine: Machine,
}

impl Loopback {
    pub fn open(options: &Options) -> Result<Loopback, Error> {
        let options = Options { lockstep: true, ..options.clone() };
        Ok(Loopback { machine: assemble(&options)?.0 })
    }

    /// A cycle of the plant without a frame.
    pub fn wait(&mut self) -> Result<(), Error> {
        self.machine.advance(0)
    }

    /// Largest speed [rad/s], mean over 1 ms, and largest angle [rad] of any axis so far.
    pub fn extremes(&self) -> (f64, f64) {
        (self.machine.extremes.fastest, self.machine.extremes.farthest)
    }

    /// True angles of the axes [rad].
    pub fn angles(&self) -> [f64; AXES] {
        self.machine.angles()
    }

    /// Drives that gave torque in the last cycle, by axis.
    pub fn powered(&self) -> [bool; AXES] {
        self.machine.powered()
    }

    /// The replies to a frame; none where it is malformed or lost.
    pub fn answer(&mut self, frame: &[u8]) -> Result<Vec<Vec<u8>>, Error> {
        let mut replies = Vec::new();
        self.machine.receive(frame, 0, &mut replies)?;
        self.machine.events.clear();
        Ok(replies)
    }
}
