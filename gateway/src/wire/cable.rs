//! What frames go through: the network interface, or a capture.

use super::{Link, Replay, Socket};

pub enum Cable {
    Live(Socket),
    Replayed(Replay),
}

impl Link for Cable {
    fn send(&mut self, frame: &[u8]) -> bool {
        match self {
            Cable::Live(link) => link.send(frame),
            Cable::Replayed(link) => link.send(frame),
        }
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        match self {
            Cable::Live(link) => link.receive(buffer),
            Cable::Replayed(link) => link.receive(buffer),
        }
    }

    fn wait(&mut self, timeout_ns: u64) {
        match self {
            Cable::Live(link) => link.wait(timeout_ns),
            Cable::Replayed(link) => link.wait(timeout_ns),
        }
    }
}
