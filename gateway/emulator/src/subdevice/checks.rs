//! Checks of the configuration before a change of state.
use super::SubDevice;
use crate::esc::registers as reg;
use crate::esc::state::{code, State};
use crate::esc::sync_manager::Access;
use crate::sii;

/// Shortest cycle in torque mode [ns].
const SHORTEST_CYCLE_NS: u32 = 250_000;

impl SubDevice {
    /// Err: the AL status code.
    pub(super) fn check(&self, before: State, state: State) -> Result<(), u16> {
        if before == State::Init && state == State::PreOp {
            self.check_mailbox()?;
        }
        if before == State::PreOp && state == State::SafeOp {
            let outputs = self.application.outputs.bytes();
            self.check_buffer(2, outputs, Access::Write, code::INVALID_OUTPUTS)?;
            let inputs = self.application.input_bytes();
            self.check_buffer(3, inputs, Access::Read, code::INVALID_INPUTS)?;
            self.check_sync()?;
        }
        Ok(())
    }

    fn check_mailbox(&self) -> Result<(), u16> {
        let wanted = [(0, sii::MAILBOX_OUT, Access::Write), (1, sii::MAILBOX_IN, Access::Read)];
        let right = wanted.iter().all(|(index, start, direction)| {
            let sm = self.esc.sm(*index);
            sm.enabled()
                && sm.is_mailbox()
                && sm.start == *start
                && sm.length == self.application.settings.mailbox_bytes
                && sm.direction() == *direction
        });
        if right {
            Ok(())
        } else {
            Err(code::INVALID_MAILBOX)
        }
    }

    fn check_buffer(
        &self,
        index: usize,
        bytes: usize,
        access: Access,
        code: u16,
    ) -> Result<(), u16> {
        let sm = self.esc.sm(index);
        let inside = reg::RAM.contains(&sm.start)
            && usize::from(sm.start) + usize::from(sm.length) <= usize::from(reg::RAM.end);
        let right = sm.enabled()
            && !sm.is_mailbox()
            && sm.direction() == access
            && usize::from(sm.length) == bytes
            && inside;
        if right || bytes == 0 && !sm.enabled() {
            Ok(())
        } else {
            Err(code)
        }
    }

    fn check_sync(&self) -> Result<(), u16> {
        let active = self.esc.get16(reg::SYNC_ACTIVATION) & 3 == 3;
        let cycle = self.esc.get32(reg::SYNC0_CYCLE);
        if active && (cycle < SHORTEST_CYCLE_NS || !cycle.is_multiple_of(62_500)) {
            return Err(code::INVALID_SYNC_CYCLE);
        }
        let period = self.drive().parameters.period_ns();
        let checked = self.application.settings.period_checked;
        if checked && active && period != Some(cycle.into()) {
            return Err(code::INVALID_SYNC_CYCLE);
        }
        Ok(())
    }
}
