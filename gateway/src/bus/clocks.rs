//! How far the clock of each drive is off from that of the first device that has one: register 0x092C.
//! The first one follows nobody, so its register says nothing.

use ethercrab::{Command, MainDevice};

use crate::config::AXES;

pub const DIFFERENCE: u16 = 0x092c;
/// Bit of the sign: the own clock is behind.
const BEHIND: u32 = 1 << 31;

/// System time differences by axis [ns], below 0 where the clock is behind; None: not read, no clock,
/// or the first.
pub type Differences = [Option<i32>; AXES];

/// Differences before power and after the drives were disabled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clocks {
    pub bound_ns: u32,
    pub start: Differences,
    pub end: Differences,
}

/// Axis and size of the largest difference.
pub fn largest(differences: &Differences) -> Option<(usize, u32)> {
    let known = differences.iter().enumerate();
    let sizes = known.filter_map(|(axis, ns)| Some((axis, ns.as_ref()?.unsigned_abs())));
    sizes.max_by_key(|(_, size)| *size)
}

/// Sign and magnitude, as the register holds them.
fn signed(register: u32) -> i32 {
    let size = (register & !BEHIND) as i32;
    if register & BEHIND == 0 {
        size
    } else {
        -size
    }
}

/// Difference of the drive with this station address; None where it does not reply.
pub async fn ask(main: &'static MainDevice<'static>, address: u16) -> Option<i32> {
    let read = Command::fprd(address, DIFFERENCE).receive::<u32>(main);
    read.await.ok().map(signed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_register_holds_sign_and_magnitude() {
        assert_eq!(
            [0, 700, BEHIND, BEHIND | 700, u32::MAX].map(signed),
            [0, 700, 0, -700, -i32::MAX]
        );
    }

    #[test]
    fn the_largest_difference_is_that_of_either_sign() {
        assert_eq!(largest(&[Some(0), Some(-40), None, Some(30), None, None]), Some((1, 40)));
        assert_eq!(largest(&Differences::default()), None);
    }
}
