//! Raw Ethernet frames of one type on one interface (AF_PACKET).
use crate::error::Error;
use std::ffi::CString;
use std::io;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::time::Duration;

/// EtherCAT, in network byte order.
const PROTOCOL: u16 = 0x88A4u16.to_be();
/// Longest frame without check sequence, a VLAN tag included.
pub const LONGEST: usize = 1518;
const SHORTEST: usize = 60;

pub struct Socket {
    descriptor: OwnedFd,
}

fn wrong(interface: &str, what: &str, error: &io::Error) -> Error {
    let mend = match error.raw_os_error() {
        Some(libc::EPERM | libc::EACCES) => {
            "raw frames need root or `setcap cap_net_raw+ep` on the program"
        }
        Some(libc::ENODEV | libc::ENXIO) => "`ip link` lists the interfaces of this namespace",
        Some(libc::ENETDOWN) => "bring it up: `ip link set NAME up`",
        _ => "see `ip link` and `dmesg`",
    };
    Error::new(format!("interface {interface}: {what}: {error}; {mend}"))
}

impl Socket {
    pub fn open(interface: &str) -> Result<Socket, Error> {
        let name = CString::new(interface)
            .map_err(|_| Error::new(format!("interface {interface:?}: no name has a NUL")))?;
        // SAFETY: `name` is a NUL-terminated string that lives through the call.
        let index = unsafe { libc::if_nametoindex(name.as_ptr()) };
        if index == 0 {
            return Err(wrong(interface, "not found", &io::Error::last_os_error()));
        }
        let kind = libc::SOCK_RAW | libc::SOCK_CLOEXEC | libc::SOCK_NONBLOCK;
        // SAFETY: no pointers; the result is checked before use.
        let raw = unsafe { libc::socket(libc::AF_PACKET, kind, i32::from(PROTOCOL)) };
        if raw < 0 {
            return Err(wrong(interface, "raw socket refused", &io::Error::last_os_error()));
        }
        // SAFETY: `raw` was just opened and is owned by nobody else.
        let descriptor = unsafe { OwnedFd::from_raw_fd(raw) };
        // SAFETY: all-zero bytes are a valid sockaddr_ll.
        let mut address: libc::sockaddr_ll = unsafe { std::mem::zeroed() };
        address.sll_family = libc::AF_PACKET as u16;
        address.sll_protocol = PROTOCOL;
        address.sll_ifindex = index as i32;
        let size = std::mem::size_of::<libc::sockaddr_ll>() as libc::socklen_t;
        let pointer = (&raw const address).cast();
        // SAFETY: `pointer` is to a sockaddr_ll of `size` bytes that lives through the call.
        if unsafe { libc::bind(descriptor.as_raw_fd(), pointer, size) } != 0 {
            return Err(wrong(interface, "cannot be bound", &io::Error::last_os_error()));
        }
        Ok(Socket { descriptor })
    }

    /// The next frame, as bytes of `buffer`; None: nothing is waiting.
    pub fn receive<'a>(&self, buffer: &'a mut [u8]) -> io::Result<Option<&'a [u8]>> {
        let (pointer, size) = (buffer.as_mut_ptr().cast(), buffer.len());
        // SAFETY: `pointer` is to `size` writable bytes that live through the call.
        let got = unsafe { libc::recv(self.descriptor.as_raw_fd(), pointer, size, 0) };
        match usize::try_from(got) {
            Ok(length) => Ok(buffer.get(..length)),
            Err(_) => match io::Error::last_os_error() {
                error if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
                error if error.kind() == io::ErrorKind::Interrupted => Ok(None),
                error => Err(error),
            },
        }
    }

    /// Sends one frame, padded to the shortest that Ethernet has; a full queue loses it.
    pub fn send(&self, frame: &[u8]) -> io::Result<()> {
        let mut padded = [0; SHORTEST];
        let bytes = if frame.len() < SHORTEST {
            padded[..frame.len()].copy_from_slice(frame);
            &padded[..]
        } else {
            frame
        };
        let (pointer, size) = (bytes.as_ptr().cast(), bytes.len());
        // SAFETY: `pointer` is to `size` readable bytes that live through the call.
        let sent = unsafe { libc::send(self.descriptor.as_raw_fd(), pointer, size, 0) };
        if sent >= 0 {
            return Ok(());
        }
        match io::Error::last_os_error() {
            error if error.kind() == io::ErrorKind::WouldBlock => Ok(()),
            error if error.raw_os_error() == Some(libc::ENOBUFS) => Ok(()),
            error => Err(error),
        }
    }

    /// Sleeps until a frame waits, `timeout` is over (None: never) or a signal arrives.
    pub fn wait(&self, timeout: Option<Duration>) {
        let mut poll =
            libc::pollfd { fd: self.descriptor.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        let time = timeout.map(|time| libc::timespec {
            tv_sec: time.as_secs() as libc::time_t,
            tv_nsec: libc::c_long::from(time.subsec_nanos()),
        });
        let pointer = time.as_ref().map_or(std::ptr::null(), |time| time as *const _);
        // SAFETY: one pollfd and a timespec (or null) that live through the call; no signal mask.
        unsafe { libc::ppoll(&mut poll, 1, pointer, std::ptr::null()) };
    }
}
