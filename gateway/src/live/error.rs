//! Why a run cannot be shown, or seen.

use std::fmt::{self, Display, Formatter};
use std::io;

use crate::exit::{Ends, Exit};

#[derive(Debug)]
pub struct LiveError {
    pub interface: String,
    pub why: LiveFault,
}

#[derive(Debug)]
pub enum LiveFault {
    /// No socket can have this name.
    BadName(io::Error),
    NotServed(io::Error),
    /// `--page` with this port.
    NoPage(u16, io::Error),
    NoThread(io::Error),
    /// Nobody serves it.
    NotRunning,
    NoAnswer(io::Error),
    NoJson(serde_json::Error),
}

impl LiveFault {
    pub fn of(self, interface: &str) -> LiveError {
        LiveError { interface: interface.to_owned(), why: self }
    }
}

impl Display for LiveError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let interface = &self.interface;
        match &self.why {
            LiveFault::BadName(why) => {
                write!(f, "bus.interface = {interface:?}: {why}: `ip link` lists interfaces")
            }
            LiveFault::NotServed(why) => write!(
                f,
                "status of {interface}: {why}: another flexhex-gateway shows its run there: stop it first"
            ),
            LiveFault::NoPage(port, why) => {
                write!(f, "--page {port}: {why}: give another port, or `ip link set lo up`")
            }
            LiveFault::NoThread(why) => {
                write!(f, "status of {interface}: no thread ({why}): raise `ulimit -u`")
            }
            LiveFault::NotRunning => write!(
                f,
                "no flexhex-gateway runs on {interface:?}: start it with `run`, or name its interface with \
                 --interface"
            ),
            LiveFault::NoAnswer(why) => write!(
                f,
                "the gateway on {interface} does not answer ({why}): ask again; Ctrl-C in its shell lands it"
            ),
            LiveFault::NoJson(why) => write!(
                f,
                "the gateway on {interface} answers no JSON ({why}): is it of another version?"
            ),
        }
    }
}

impl Ends for LiveError {
    fn exit(&self) -> Exit {
        Exit::Failed
    }
}
