//! How the bus is brought up.

use std::time::Duration;

use crate::config::Config;

/// Options of the bring-up.
#[derive(Clone, Copy, Debug)]
pub struct BringUpOptions {
    pub cycle: Duration,
    pub lockstep: bool,
    /// The replies come from a capture.
    pub replayed: bool,
    pub reset_faults: bool,
    /// Process data is exchanged, not only read from the drives once.
    pub cyclic: bool,
}

impl BringUpOptions {
    /// SYNC0 of distributed clocks is used.
    pub(super) fn synced(self, config: &Config) -> bool {
        config.bus.distributed_clocks && (!self.lockstep || self.replayed)
    }
}
