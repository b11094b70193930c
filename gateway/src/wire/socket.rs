//! A raw socket for EtherCAT frames on one network interface.

use std::ffi::CString;
use std::io::{Error, ErrorKind};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener};

use super::port_error::{PortError, PortFault};

const ETHERTYPE: u16 = 0x88A4;

/// A link that carries frames.
pub trait Link {
    /// Send a frame; true if it was sent.
    fn send(&mut self, frame: &[u8]) -> bool;
    /// Length of the next frame that has arrived, if there is one.
    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize>;
    /// Return when a frame has arrived, at the latest after `timeout_ns`.
    fn wait(&mut self, timeout_ns: u64);
}

/// AF_PACKET, not blocking.
pub struct Socket {
    handle: libc::c_int,
    /// Kept so that no second gateway opens this interface.
    _claim: UnixListener,
}

impl Socket {
    /// The interface belongs to a hardware device; a veth pair does not.
    pub fn is_hardware(interface: &str) -> bool {
        std::path::Path::new("/sys/class/net").join(interface).join("device").exists()
    }

    pub fn open(interface: &str) -> Result<Socket, PortError> {
        let wrong = |why: PortFault| Err(why.of(interface));
        let Ok(name) = CString::new(interface) else { return wrong(PortFault::BadName) };
        // SAFETY: the name is a C string that outlives the call.
        let index = unsafe { libc::if_nametoindex(name.as_ptr()) };
        if index == 0 {
            return wrong(PortFault::NotThere);
        }
        if !is_up(interface) {
            return wrong(PortFault::Down);
        }
        let claim = claim(interface)?;
        let kind = libc::SOCK_RAW | libc::SOCK_NONBLOCK | libc::SOCK_CLOEXEC;
        // SAFETY: creates a descriptor, accesses no memory of this process.
        let handle =
            unsafe { libc::socket(libc::AF_PACKET, kind, libc::c_int::from(ETHERTYPE.to_be())) };
        if handle < 0 {
            return wrong(PortFault::NoSocket(Error::last_os_error()));
        }
        let socket = Socket { handle, _claim: claim };
        // SAFETY: an all-zero sockaddr_ll is valid; the fields that matter are set below.
        let mut address: libc::sockaddr_ll = unsafe { std::mem::zeroed() };
        address.sll_family = libc::AF_PACKET as u16;
        address.sll_protocol = ETHERTYPE.to_be();
        address.sll_ifindex = index as i32;
        let size = std::mem::size_of_val(&address) as libc::socklen_t;
        // SAFETY: address and size belong together and outlive the call.
        let bound = unsafe { libc::bind(handle, std::ptr::from_ref(&address).cast(), size) };
        if bound != 0 {
            return wrong(PortFault::NotBound(Error::last_os_error()));
        }
        Ok(socket)
    }
}

/// The interface is up; also true where its state cannot be read.
fn is_up(interface: &str) -> bool {
    let file = std::path::Path::new("/sys/class/net").join(interface).join("flags");
    let flags = std::fs::read_to_string(file).unwrap_or_default();
    let flags = u32::from_str_radix(flags.trim().trim_start_matches("0x"), 16);
    flags.map_or(true, |flags| flags & libc::IFF_UP as u32 != 0)
}

/// Claims the interface for this process with an abstract socket name, which leaves no file.
fn claim(interface: &str) -> Result<UnixListener, PortError> {
    let name = SocketAddr::from_abstract_name(format!("flexhex-gateway {interface}"));
    let claim = name.and_then(|name| UnixListener::bind_addr(&name));
    let fault = |why: Error| match why.kind() {
        ErrorKind::AddrInUse => PortFault::Taken,
        _ => PortFault::NotClaimed(why),
    };
    claim.map_err(|why| fault(why).of(interface))
}

impl Drop for Socket {
    fn drop(&mut self) {
        // SAFETY: the descriptor is ours and is not used again.
        unsafe { libc::close(self.handle) };
    }
}

impl Link for Socket {
    fn send(&mut self, frame: &[u8]) -> bool {
        // SAFETY: pointer and length are those of one slice.
        let sent = unsafe { libc::send(self.handle, frame.as_ptr().cast(), frame.len(), 0) };
        sent == frame.len() as isize
    }

    fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        // SAFETY: pointer and length are those of one slice.
        let n = unsafe { libc::recv(self.handle, buffer.as_mut_ptr().cast(), buffer.len(), 0) };
        (n >= 0).then_some(n as usize)
    }

    fn wait(&mut self, timeout_ns: u64) {
        let mut poll = libc::pollfd { fd: self.handle, events: libc::POLLIN, revents: 0 };
        let timeout = libc::timespec {
            tv_sec: (timeout_ns / 1_000_000_000) as libc::time_t,
            tv_nsec: (timeout_ns % 1_000_000_000) as libc::c_long,
        };
        // SAFETY: one pollfd, and a timespec that outlives the call; no signal mask.
        unsafe { libc::ppoll(&mut poll, 1, &timeout, std::ptr::null()) };
    }
}
