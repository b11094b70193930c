//! Error counters of the controllers: what the cables did to the frames [ET1100 data sheet, section II, 0x0300 to 0x0313].

use ethercrab::{Command, MainDevice};

const COUNTERS: u16 = 0x0300;
const BYTES: usize = 0x14;
/// Of a controller, also where a device has only the first two: IN and OUT.
const PORTS: usize = 4;
/// A counter stops here until the device is switched off and on.
const FULL: u8 = u8::MAX;

/// Kinds of errors, in the order of the counters below: name in sentences, and in JSON.
pub const KINDS: [(&str, &str); 4] = [
    ("invalid frames", "invalid_frames"),
    ("receive errors", "receive_errors"),
    ("forwarded errors", "forwarded_errors"),
    ("lost links", "lost_links"),
];
/// The places of each kind's counters: the first port's, and their distance.
const PLACES: [(usize, usize); KINDS.len()] = [(0x00, 2), (0x01, 2), (0x08, 1), (0x10, 1)];
const INVALID: usize = 0;
const RECEIVED: usize = 1;
const FORWARDED: usize = 2;
const LOST: usize = 3;

/// Counters of a device by port and kind.
type Counters = [[u8; KINDS.len()]; PORTS];
/// Counters by position on the bus; None: not read.
pub type Readings = Vec<Option<Counters>>;

/// What one counter counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    pub number: u8,
    /// It has stopped, so there may have been more.
    pub full: bool,
}

impl Count {
    fn between(before: u8, after: u8) -> Count {
        // below what it was: the device was switched off and on, or somebody set it to 0
        let number = after.checked_sub(before).unwrap_or(after);
        Count { number, full: after == FULL }
    }

    pub fn is_none(self) -> bool {
        self == Count::default()
    }
}

/// A port at which something was counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortErrors {
    pub position: usize,
    /// None: no drive of the configuration.
    pub axis: Option<usize>,
    pub port: usize,
    /// It is the last device of the line.
    pub last: bool,
    pub counts: [Count; KINDS.len()],
}

impl PortErrors {
    /// All that it counted were frames that another device had found damaged.
    pub fn only_forwards(&self) -> bool {
        let others = self.counts.iter().enumerate().filter(|(kind, _)| *kind != FORWARDED);
        others.into_iter().all(|(_, count)| count.is_none())
    }

    pub fn lost_the_link(&self) -> bool {
        !self.counts[LOST].is_none()
    }

    /// Frames arrived damaged here, or noise.
    pub fn is_disturbed(&self) -> bool {
        !(self.counts[INVALID].is_none() && self.counts[RECEIVED].is_none())
    }
}

/// What all devices counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Links {
    pub ports: Vec<PortErrors>,
    /// Positions whose counters were not read; all of them where no counter was.
    pub unread: Vec<usize>,
    /// Any counter was read.
    pub known: bool,
}

impl Links {
    /// Counted since power-up. `axes`: by position.
    pub fn since_power_up(after: &Readings, axes: &[Option<usize>]) -> Links {
        Links::between(&vec![Some(Counters::default()); axes.len()], after, axes)
    }

    /// Counted between two readings.
    pub fn between(before: &Readings, after: &Readings, axes: &[Option<usize>]) -> Links {
        let mut links = Links::default();
        for (position, axis) in axes.iter().enumerate() {
            let one = |all: &Readings| all.get(position).copied().flatten();
            let (Some(before), Some(after)) = (one(before), one(after)) else {
                links.unread.push(position);
                continue;
            };
            links.known = true;
            for port in 0..PORTS {
                let count = |kind| Count::between(before[port][kind], after[port][kind]);
                let counts: [Count; KINDS.len()] = std::array::from_fn(count);
                if counts.iter().any(|count| !count.is_none()) {
                    let last = position + 1 == axes.len();
                    links.ports.push(PortErrors { position, axis: *axis, port, last, counts });
                }
            }
        }
        links
    }
}

/// Counters of the device with this station address; None where it does not reply.
pub async fn ask(main: &'static MainDevice<'static>, address: u16) -> Option<Counters> {
    let read = Command::fprd(address, COUNTERS).receive::<[u8; BYTES]>(main);
    let bytes = read.await.ok()?;
    let count = |port, kind: usize| bytes[PLACES[kind].0 + PLACES[kind].1 * port];
    Some(std::array::from_fn(|port| std::array::from_fn(|kind| count(port, kind))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [Option<usize>; 3] = [Some(0), None, Some(1)];

    fn counters(port: usize, kind: usize, number: u8) -> Counters {
        let mut all = Counters::default();
        all[port][kind] = number;
        all
    }

    #[test]
    fn what_a_run_counted_is_the_difference_by_device_and_port() {
        let before =
            vec![Some(counters(0, 1, 3)), Some(counters(1, 3, 7)), Some(Counters::default())];
        let after = vec![Some(counters(0, 1, 3)), Some(counters(1, 3, 9)), Some(counters(0, 2, 1))];
        let links = Links::between(&before, &after, &AXES);
        let shown = |p: &PortErrors| (p.position, p.axis, p.port, p.counts.map(|c| c.number));
        let shown: Vec<_> = links.ports.iter().map(shown).collect();
        assert_eq!(shown, [(1, None, 1, [0, 0, 0, 2]), (2, Some(1), 0, [0, 0, 1, 0])]);
        assert!(links.ports[0].lost_the_link() && !links.ports[0].last);
        assert!(links.ports[1].only_forwards() && links.ports[1].last);
        assert!(links.known && links.unread.is_empty());
    }

    #[test]
    fn a_full_counter_says_that_there_may_have_been_more() {
        let count = |before, after| Count::between(before, after);
        assert_eq!(count(250, 255), Count { number: 5, full: true });
        assert_eq!(count(255, 255), Count { number: 0, full: true });
        assert!(!count(255, 255).is_none() && count(254, 254).is_none());
        // switched off and on in the run
        assert_eq!(count(255, 2), Count { number: 2, full: false });
    }

    #[test]
    fn what_was_not_read_is_told_and_counts_nothing() {
        let read = vec![Some(counters(0, 0, 4)), None, None];
        let links = Links::since_power_up(&read, &AXES);
        assert_eq!((links.ports.len(), links.unread, links.known), (1, vec![1, 2], true));
        let nothing = Links::between(&vec![None; 3], &read, &AXES);
        assert_eq!((nothing.ports.len(), nothing.known), (0, false));
    }
}
