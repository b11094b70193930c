//! Why a network interface cannot be used.

use std::fmt::{self, Display, Formatter};
use std::io::Error;

use crate::exit::{Ends, Exit};

#[derive(Debug)]
pub struct PortError {
    pub interface: String,
    pub why: PortFault,
}

#[derive(Debug)]
pub enum PortFault {
    /// Not even a name.
    BadName,
    NotThere,
    Down,
    /// Another gateway uses it.
    Taken,
    /// No right to a raw socket.
    NoSocket(Error),
    NotBound(Error),
    NotClaimed(Error),
}

impl PortFault {
    pub fn of(self, interface: &str) -> PortError {
        PortError { interface: interface.to_owned(), why: self }
    }
}

impl Display for PortError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let interface = &self.interface;
        write!(f, "bus.interface = {interface:?}: ")?;
        match &self.why {
            PortFault::BadName => f.write_str("not a valid name"),
            PortFault::NotThere => f.write_str("no such network interface: `ip link` lists them"),
            PortFault::Down => {
                write!(f, "the interface is down: `ip link set {interface} up`")
            }
            PortFault::Taken => {
                f.write_str("another flexhex-gateway uses this interface: stop it first")
            }
            PortFault::NoSocket(why) => write!(
                f,
                "no raw socket ({why}): run as root or grant CAP_NET_RAW (`setcap \
                 cap_net_raw,cap_sys_nice,cap_ipc_lock+ep`)"
            ),
            PortFault::NotBound(why) => write!(f, "{why}: check that the interface is up"),
            PortFault::NotClaimed(why) => why.fmt(f),
        }
    }
}

impl Ends for PortError {
    fn exit(&self) -> Exit {
        Exit::Failed
    }
}
