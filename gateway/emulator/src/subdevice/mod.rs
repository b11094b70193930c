//! One SubDevice: controller, mailbox, states and the drive behind them.
mod checks;

use crate::application::{Application, DeviceSettings};
use crate::coe::Mailbox;
use crate::drive::{cia402, Drive, ERROR_WATCHDOG};
use crate::esc::clock::Clock;
use crate::esc::registers as reg;
use crate::esc::state::{code, Answer, Layer, State};
use crate::esc::Esc;
use crate::sii;

/// Error code of emergency messages: a voltage is low.
const EMERGENCY: u16 = 0x3220;

pub struct SubDevice {
    pub esc: Esc,
    pub layer: Layer,
    mailbox: Mailbox,
    /// Requests so far, and an answer that waits until the mailbox is empty.
    requests: u32,
    waiting: Option<Vec<u8>>,
    application: Application,
}

impl SubDevice {
    pub fn new(drive: Drive, settings: DeviceSettings, clock: Clock) -> SubDevice {
        let kind = drive.setting.kind;
        let (mut outputs, mut inputs) = (kind.outputs(), kind.inputs());
        for pdo in outputs.pdos.iter_mut().chain(&mut inputs.pdos) {
            pdo.fixed |= settings.maps_fixed;
        }
        let (identity, mailbox) = (&settings.identity, settings.mailbox_bytes);
        let control = settings.output_control;
        let image = sii::image(identity, kind.name(), mailbox, control, (&outputs, &inputs));
        let (fixed, dead) = (settings.trigger_fixed, settings.watchdog_dead);
        let application = Application { drive, settings, outputs, inputs, state: State::Init };
        let mut device = SubDevice {
            esc: Esc::new(image, clock),
            layer: Layer::new(),
            mailbox: Mailbox::default(),
            requests: 0,
            waiting: None,
            application,
        };
        (device.esc.trigger_fixed, device.esc.watchdog_dead) = (fixed, dead);
        device.show_layer();
        device
    }

    pub fn drive(&self) -> &Drive {
        &self.application.drive
    }

    pub fn drive_mut(&mut self) -> &mut Drive {
        &mut self.application.drive
    }

    /// After a datagram: mailbox and state requests are answered at once.
    pub fn serve(&mut self) {
        if let Some(control) = self.esc.al_control.take() {
            if let Answer::Wanted(state) = self.layer.request(control) {
                self.enter(state);
            }
            self.show_layer();
        }
        if std::mem::take(&mut self.esc.mailbox_written) {
            self.serve_mailbox();
        }
        if self.waiting.is_some() && !self.esc.is_full(1) {
            self.post(self.waiting.clone());
            self.waiting = None;
        }
    }

    fn serve_mailbox(&mut self) {
        let (inbox, outbox) = (self.esc.sm(0), self.esc.sm(1));
        let request = self.esc.get(inbox.start, usize::from(inbox.length)).to_vec();
        self.esc.set_full(0, false);
        if self.layer.state == State::Init {
            return;
        }
        let room = usize::from(outbox.length);
        let reply = self.mailbox.answer(&request, room, &mut self.application);
        self.requests = self.requests.wrapping_add(1);
        let every = self.application.settings.emergencies;
        if every > 0 && self.requests.is_multiple_of(every) {
            self.waiting = reply;
            let message = self.mailbox.emergency(EMERGENCY);
            return self.post(Some(message));
        }
        // a new request ends the wait for an older answer
        self.waiting = None;
        self.post(reply);
    }

    /// Into the mailbox that the MainDevice reads.
    fn post(&mut self, message: Option<Vec<u8>>) {
        let outbox = self.esc.sm(1);
        if let Some(mut message) = message.filter(|_| outbox.enabled()) {
            message.resize(usize::from(outbox.length), 0);
            self.esc.put(outbox.start, &message);
            self.esc.set_full(1, true);
        }
    }

    fn enter(&mut self, state: State) {
        let before = self.layer.state;
        if let Err(code) = self.check(before, state) {
            self.layer.refuse(code);
            return;
        }
        if state == State::Op && before == State::SafeOp && !self.esc.watchdog.alive() {
            self.layer.waits_for_outputs = true;
            return;
        }
        self.layer.grant(state);
        self.settle(before);
    }

    /// Consequences of a change of state.
    fn settle(&mut self, before: State) {
        let state = self.layer.state;
        self.application.state = state;
        self.esc.process_data_open = state >= State::SafeOp;
        if state < State::SafeOp {
            self.esc.watchdog.stop();
            self.esc.outputs_written = false;
        }
        if state == State::Init {
            self.mailbox.reset();
            self.waiting = None;
            self.esc.set_full(0, false);
            self.esc.set_full(1, false);
        }
        if before < State::SafeOp && state == State::SafeOp {
            self.show_inputs();
        }
        let enabled = self.drive().machine.state == cia402::State::OperationEnabled;
        if before == State::Op && state < State::Op && enabled {
            // power without set points is a fault, whoever asked for it
            self.drive_mut().machine.raise(ERROR_WATCHDOG);
        }
    }

    /// The end of a frame: outputs that were written act, in OP. True if they did.
    pub fn act(&mut self) -> bool {
        let written = std::mem::take(&mut self.esc.outputs_written);
        if !written || self.layer.state < State::SafeOp {
            return false;
        }
        if self.layer.waits_for_outputs {
            self.layer.grant(State::Op);
            self.settle(State::SafeOp);
            self.show_layer();
        }
        if self.layer.state != State::Op {
            return false;
        }
        let outputs = self.esc.sm(2);
        let data = self.esc.get(outputs.start, usize::from(outputs.length)).to_vec();
        self.application.take(&data);
        true
    }

    /// True when the process-data watchdog expires in OP: SAFE-OP with 0x001B, and a fault.
    pub fn watch(&mut self, now: i64) -> bool {
        let expired = self.esc.watchdog.expires(now, self.esc.watchdog_period());
        if !expired {
            return false;
        }
        let count = self.esc.get(reg::WATCHDOG_COUNTER, 1)[0].saturating_add(1);
        self.esc.put(reg::WATCHDOG_COUNTER, &[count]);
        if self.layer.state != State::Op {
            return false;
        }
        self.fall(code::WATCHDOG);
        self.drive_mut().machine.raise(ERROR_WATCHDOG);
        self.show_inputs();
        true
    }

    /// Falls to SAFE-OP by itself.
    pub fn fall(&mut self, code: u16) {
        let before = self.layer.state;
        if before != State::Op {
            return;
        }
        self.layer.fall(State::SafeOp, code);
        self.settle(before);
        self.show_layer();
    }

    /// Torque on the axis [N m].
    pub fn torque(&self) -> f64 {
        if self.layer.state == State::Op {
            self.drive().torque()
        } else {
            self.drive().braking()
        }
    }

    /// In OP and enabled, as its inputs show it.
    pub fn is_enabled(&self) -> bool {
        let enabled = cia402::State::OperationEnabled;
        self.layer.state == State::Op && self.drive().machine.state == enabled
    }

    /// Inputs as they are now.
    pub fn show_inputs(&mut self) {
        let sm = self.esc.sm(3);
        if sm.enabled() && self.layer.state >= State::SafeOp {
            let mut data = self.application.give();
            data.resize(usize::from(sm.length), 0);
            self.esc.put(sm.start, &data);
        }
    }

    fn show_layer(&mut self) {
        self.esc.put16(reg::AL_STATUS, self.layer.status());
        self.esc.put16(reg::AL_STATUS_CODE, self.layer.code);
    }
}

#[cfg(test)]
mod tests;
