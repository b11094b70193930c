//! Moves as a person at the keyboard says, and holds in between.

use std::sync::mpsc::{Receiver, TryRecvError};

use super::arrivals::Arrivals;
use super::step::{Axes, Leg, Seen, Step};

/// Orders that may wait while the machine moves.
pub const ORDERS: usize = 16;

/// What the person wants next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    To(Axes),
    Land,
}

pub struct Jog {
    now: Axes,
    /// Of a bounded channel: nothing is allocated when it is read.
    orders: Receiver<Order>,
    arrivals: Arrivals,
}

impl Jog {
    /// From the first pose on.
    pub fn new(first: Axes, orders: Receiver<Order>, arrivals: Arrivals) -> Jog {
        Jog { now: first, orders, arrivals }
    }

    pub fn begin(&mut self, rest: &Axes) -> Leg {
        Leg::new(*rest, self.now)
    }

    pub fn step(&mut self, seen: &Seen) -> Step {
        if seen.left > 0 {
            return Step::Stay;
        }
        self.arrivals.tell(&self.now, seen);
        match self.orders.try_recv() {
            Ok(Order::To(pose)) => {
                self.arrivals.leave();
                let from = std::mem::replace(&mut self.now, pose);
                Step::Go(Leg::new(from, pose))
            }
            // nobody is there any more
            Ok(Order::Land) | Err(TryRecvError::Disconnected) => Step::Over,
            Err(TryRecvError::Empty) => Step::Stay,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::AXES;
    use std::sync::mpsc::sync_channel;

    #[test]
    fn orders_are_taken_one_after_the_other_and_silence_lands() {
        let (sender, orders) = sync_channel(ORDERS);
        let zero = [0.0; AXES];
        let (arrivals, told) = Arrivals::new(ORDERS);
        let mut jog = Jog::new(zero, orders, arrivals);
        let seen = |left| Seen { complete: true, theta: &zero, tau_meas: &zero, r: &zero, left };
        assert_eq!(jog.begin(&[-0.3; AXES]), Leg::new([-0.3; AXES], zero));
        sender.send(Order::To([0.1; AXES])).unwrap();
        sender.send(Order::To([0.2; AXES])).unwrap();
        assert_eq!(jog.step(&seen(1)), Step::Stay, "it still moves");
        assert_eq!(jog.step(&seen(0)), Step::Go(Leg::new(zero, [0.1; AXES])));
        assert_eq!(jog.step(&seen(0)), Step::Go(Leg::new([0.1; AXES], [0.2; AXES])));
        assert_eq!(jog.step(&seen(0)), Step::Stay);
        drop(sender);
        assert_eq!(jog.step(&seen(0)), Step::Over);
        let poses: Vec<_> = told.try_iter().map(|arrived| arrived.pose).collect();
        assert_eq!(poses, [zero, [0.1; AXES], [0.2; AXES]], "each is told once");
    }
}
