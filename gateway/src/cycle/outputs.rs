//! What is sent: torque and controlword of every axis, by the phase of the run.

use super::{ControlLoop, Phase};
use crate::bus::cia402::{self, State};
use crate::config::AXES;
use crate::wire::Link;

impl<L: Link> ControlLoop<'_, L> {
    /// Torque and controlword of the next frame.
    pub(super) fn outputs(&mut self) -> ([f64; AXES], [u16; AXES]) {
        let mut tau = [0.0; AXES];
        tau.copy_from_slice(&self.controller.command()[..AXES]);
        match &mut self.phase {
            Phase::Running if self.options.dry_run => {
                ([0.0; AXES], [cia402::DISABLE_VOLTAGE; AXES])
            }
            Phase::Running => (tau, [cia402::ENABLE_OPERATION; AXES]),
            Phase::Arming(_) => {
                let now = self.bus.reply().statusword.map(cia402::state);
                let reset = self.options.reset_faults;
                let still = self.safety.history().knows_rates();
                // all wait for the last one, then all are enabled by one frame
                let together = now.iter().all(|s| cia402::is_switched_on(*s));
                let word = |s| match s {
                    _ if !still => cia402::DISABLE_VOLTAGE,
                    State::SwitchedOn if !together => cia402::SWITCH_ON,
                    State::Fault if reset => cia402::FAULT_RESET,
                    _ => cia402::towards_enabled(s),
                };
                ([0.0; AXES], now.map(word))
            }
            Phase::Lifting(mover) => (mover.tau, self.kept_enabled(&[false; AXES])),
            Phase::Landing(mover) => {
                let (tau, blind) = (mover.tau, mover.blind);
                (tau, self.kept_enabled(&blind))
            }
            Phase::Disabling(disabling) => ([0.0; AXES], [disabling.next(); AXES]),
        }
    }
}
