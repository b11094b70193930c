//! Where the machine has arrived, on its way out of the control loop.

use std::sync::mpsc::{sync_channel, Receiver, SyncSender};

use super::step::{Axes, Seen};

/// A pose that was wanted, and the angles that were measured there [rad].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrived {
    pub pose: Axes,
    pub theta: Axes,
}

/// The loop's side. It neither waits nor allocates: what does not fit is left out.
pub struct Arrivals {
    sender: SyncSender<Arrived>,
    /// The newest pose has not been told yet.
    due: bool,
}

impl Arrivals {
    /// So many may wait to be read.
    pub fn new(capacity: usize) -> (Arrivals, Receiver<Arrived>) {
        let (sender, receiver) = sync_channel(capacity);
        (Arrivals { sender, due: true }, receiver)
    }

    /// The machine leaves for another pose.
    pub fn leave(&mut self) {
        self.due = true;
    }

    /// Tells once that a pose was reached, with the first complete reply there.
    pub fn tell(&mut self, pose: &Axes, seen: &Seen) {
        if self.due && seen.complete {
            self.due = false;
            // who would read it is gone, or late
            let _ = self.sender.try_send(Arrived { pose: *pose, theta: *seen.theta });
        }
    }
}
