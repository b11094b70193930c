//! For tests: a MainDevice that passes its frames to the machine without a network.
mod frames;

use crate::coe::pdo::Entry;
use crate::event::{Event, EventKind};
use crate::machine::Machine;
use crate::options::Options;
use crate::plant::Flywheels;
use crate::segment;
use crate::trajectory::Trajectory;
pub use frames::{frame, inputs, parse, Inputs, Reply, Request, IN, OUT};

pub const DT: f64 = 0.00025;
const LOGICAL: u32 = 0x0100_0000;

pub struct Bench {
    pub machine: Machine,
    pub count: usize,
}

impl Bench {
    /// options: TOML, without an interface.
    pub fn new(options: &str) -> Bench {
        let options: Options = toml::from_str(options).expect("sound options");
        let count = options.drives.count;
        let devices = (0..count).map(|position| options.device(position)).collect();
        let plant = Box::new(Flywheels::new(DT));
        let trajectory = Trajectory::new(DT, None).unwrap();
        let faults = options.fault.clone();
        let machine = Machine::new(devices, options.order(), plant, faults, (DT, true), trajectory);
        Bench { machine, count }
    }

    pub fn replies(&mut self, bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut out = Vec::new();
        self.machine.receive(bytes, 0, &mut out).expect("the plant runs");
        // in lockstep this says that no reply comes
        let notice = segment::no_reply(bytes);
        out.retain(|reply| *reply != notice);
        out
    }

    pub fn send(&mut self, requests: &[Request]) -> Vec<Reply> {
        self.replies(&frame(requests)).first().map(|bytes| parse(bytes)).unwrap_or_default()
    }

    /// One datagram to station `position + 1`; data and working counter.
    pub fn read(&mut self, position: usize, offset: u16, length: usize) -> Reply {
        self.send(&[(4, position as u16 + 1, offset, vec![0; length])]).remove(0)
    }

    pub fn write(&mut self, position: usize, offset: u16, data: &[u8]) -> u16 {
        self.send(&[(5, position as u16 + 1, offset, data.to_vec())])[0].counter
    }

    /// State and status code after a request.
    pub fn request(&mut self, position: usize, control: u16) -> (u16, u16) {
        self.write(position, 0x0120, &control.to_le_bytes());
        let data = self.read(position, 0x0130, 6).data;
        (u16::from_le_bytes([data[0], data[1]]), u16::from_le_bytes([data[4], data[5]]))
    }

    pub fn set_sm(&mut self, position: usize, index: u16, start: u16, length: u16, control: u8) {
        let [s0, s1] = start.to_le_bytes();
        let [l0, l1] = length.to_le_bytes();
        let bytes = [s0, s1, l0, l1, control, 0, 1, 0];
        assert_eq!(self.write(position, 0x0800 + 8 * index, &bytes), 1);
    }

    pub fn set_fmmu(&mut self, position: usize, index: u16, logical: u32, length: u16, to: u16) {
        let mut bytes = logical.to_le_bytes().to_vec();
        bytes.extend(length.to_le_bytes());
        bytes.extend([0, 7]);
        bytes.extend(to.to_le_bytes());
        bytes.extend([0, if index == 0 { 2 } else { 1 }, 1, 0, 0, 0]);
        self.write(position, 0x0600 + 16 * index, &bytes);
    }

    /// An SDO service and its reply from the command byte on.
    pub fn sdo(&mut self, position: usize, service: &[u8]) -> Vec<u8> {
        let mut mail = (service.len() as u16 + 2).to_le_bytes().to_vec();
        mail.extend([0, 0, 0, 3, 0, 0x20]);
        mail.extend(service);
        mail.resize(512, 0);
        assert_eq!(self.write(position, 0x1000, &mail), 1, "the mailbox takes it");
        let reply = self.read(position, 0x1400, 512);
        assert_eq!(reply.counter, 1, "a reply waits");
        reply.data[8..].to_vec()
    }

    /// Abort code of a download, 0: none.
    pub fn download(&mut self, position: usize, index: u16, sub: u8, data: &[u8]) -> u32 {
        let [low, high] = index.to_le_bytes();
        let mut service = vec![0x23 | (4 - data.len() as u8) << 2, low, high, sub];
        service.extend(data);
        service.resize(8, 0);
        let reply = self.sdo(position, &service);
        if reply[0] == 0x60 {
            return 0;
        }
        u32::from_le_bytes([reply[4], reply[5], reply[6], reply[7]])
    }

    fn map(&mut self, position: usize, index: u16, entries: &[Entry]) {
        assert_eq!(self.download(position, index, 0, &[0]), 0);
        for (entry, sub) in entries.iter().zip(1..) {
            assert_eq!(self.download(position, index, sub, &entry.word().to_le_bytes()), 0);
        }
        assert_eq!(self.download(position, index, 0, &[entries.len() as u8]), 0);
    }

    fn assign(&mut self, position: usize, index: u16, pdos: &[u16]) {
        assert_eq!(self.download(position, index, 0, &[0]), 0);
        for (pdo, sub) in pdos.iter().zip(1..) {
            assert_eq!(self.download(position, index, sub, &pdo.to_le_bytes()), 0);
        }
        assert_eq!(self.download(position, index, 0, &[pdos.len() as u8]), 0);
    }

    pub fn reach_pre_op(&mut self) {
        for position in 0..self.count {
            let station = position as u16 + 1;
            let place = 0u16.wrapping_sub(position as u16);
            self.send(&[(2, place, 0x0010, station.to_le_bytes().to_vec())]);
            self.set_sm(position, 0, 0x1000, 512, 0x26);
            self.set_sm(position, 1, 0x1400, 512, 0x22);
            assert_eq!(self.request(position, 0x12), (2, 0));
        }
    }

    /// Maps of AKDs and what belongs to them.
    pub fn configure(&mut self, position: usize) {
        let (pad, control, mode) =
            (Entry::new(0, 8), Entry::new(0x6040, 16), Entry::new(0x6060, 8));
        self.map(position, 0x1600, &[control, mode, pad, Entry::new(0x2071, 32)]);
        let (status, shown) = (Entry::new(0x6041, 16), Entry::new(0x6061, 8));
        self.map(position, 0x1A00, &[status, shown, pad, Entry::new(0x6063, 32)]);
        self.map(position, 0x1A01, &[Entry::new(0x2077, 32), Entry::new(0x606C, 32)]);
        self.assign(position, 0x1C12, &[0x1600]);
        self.assign(position, 0x1C13, &[0x1A00, 0x1A01]);
        self.set_sm(position, 2, 0x1800, OUT as u16, 0x64);
        self.set_sm(position, 3, 0x1C00, IN as u16, 0x20);
        let logical = LOGICAL + ((OUT + IN) * position) as u32;
        self.set_fmmu(position, 0, logical, OUT as u16, 0x1800);
        self.set_fmmu(position, 1, logical + OUT as u32, IN as u16, 0x1C00);
    }

    pub fn reach_safe_op(&mut self) {
        self.reach_pre_op();
        for position in 0..self.count {
            self.configure(position);
            assert_eq!(self.request(position, 4), (4, 0));
        }
    }

    pub fn reach_op(&mut self) {
        self.reach_safe_op();
        for position in 0..self.count {
            self.request(position, 8);
        }
        self.cycle(0, 0);
        for position in 0..self.count {
            assert_eq!(self.read(position, 0x0130, 2).data, [8, 0]);
        }
    }

    pub fn process_data(&self, control: u16, current: i32) -> Vec<u8> {
        let mut data = Vec::new();
        for _ in 0..self.count {
            data.extend(control.to_le_bytes());
            data.extend([4, 0]);
            data.extend(current.to_le_bytes());
            data.extend([0; IN]);
        }
        frame(&[(12, LOGICAL as u16, (LOGICAL >> 16) as u16, data)])
    }

    /// One process-data frame with the same outputs for all; inputs of each drive, counter.
    pub fn cycle(&mut self, control: u16, current: i32) -> Option<(Vec<Inputs>, u16)> {
        let replies = self.replies(&self.process_data(control, current));
        replies.last().map(|bytes| inputs(bytes))
    }

    /// Enables all; the frame after this is the first of the plant, n = 0.
    pub fn enable(&mut self) {
        self.reach_op();
        for control in [6, 7, 15] {
            self.cycle(control, 0);
        }
        assert_eq!(self.machine.cycle(), None, "held until a reply says that all are enabled");
    }

    /// Cycle and happening of all events since the last look.
    pub fn events(&mut self) -> Vec<(Option<u64>, EventKind)> {
        let pair = |event: Event| (event.cycle, event.what);
        self.machine.events.drain(..).map(pair).collect()
    }
}
