//! Why the bus is not ready: what was found, at which drive, and how to mend it.

use ethercrab::error::Error;
use std::fmt::{self, Display, Formatter};

use super::cia402::{State, State::Fault};
use super::sdo::{words, SdoError};
use super::{al, Difference};
use crate::exit::{Ends, Exit};

/// Something at a drive: its axis, from 0, and its position on the bus.
pub type At<T> = (usize, u16, T);

#[derive(Clone, Debug)]
pub enum BusError {
    /// This process has opened the bus already.
    InUse,
    NoDevice(Error),
    AlreadyInOp,
    NotInitialised(Error),
    /// No reply for as long as a bring-up may take.
    Silent,
    /// By a signal, before any drive was enabled.
    Stopped,
    Identity(Vec<Stranger>),
    Energised(Vec<Energised>),
    Differences(Vec<At<Difference>>),
    Drive(At<DriveError>),
    /// The profile has no entry for the angle.
    NoPosition,
    NotMapped(Error),
    /// A drive maps other numbers of bytes out and in than the profile.
    OtherSize {
        name: String,
        address: u16,
        mapped: (usize, usize),
        wanted: (usize, usize),
    },
    Clocks(Error),
    /// A request of SAFE-OP or OP failed; AL status codes of the drives.
    Refused(Error, Vec<At<u16>>),
    /// Drives that did not reach OP in this time [ms]: AL status, and its code.
    Late(u32, Vec<At<(u8, Option<u16>)>>),
}

/// A drive that is not the one of the configuration.
#[derive(Clone, Debug)]
pub enum Stranger {
    /// So many devices are fewer than the drives.
    Few(usize, usize),
    Missing(usize, u16),
    Other(At<Difference>),
}

/// A drive that has power, or a fault, before anybody asked for it.
#[derive(Clone, Debug)]
pub struct Energised {
    pub position: usize,
    /// None: no drive of the configuration.
    pub axis: Option<usize>,
    pub state: State,
    pub error_code: u16,
}

/// What went wrong with one drive.
#[derive(Clone, Debug)]
pub enum DriveError {
    Sdo(SdoError),
    NoObject(u16),
    Register(u16, Error),
    /// No sync manager is for outputs.
    NoOutputs,
    Gone(Error),
}

impl From<SdoError> for DriveError {
    fn from(why: SdoError) -> Self {
        DriveError::Sdo(why)
    }
}

impl BusError {
    /// Err with all of these, if there is any.
    pub fn of(differences: Vec<At<Difference>>) -> Result<(), BusError> {
        match differences.is_empty() {
            true => Ok(()),
            false => Err(BusError::Differences(differences)),
        }
    }
}

/// One a line.
fn lines<T: Display>(f: &mut Formatter, all: impl IntoIterator<Item = T>) -> fmt::Result {
    for (k, one) in all.into_iter().enumerate() {
        let end = if k == 0 { "" } else { "\n" };
        write!(f, "{end}{one}")?;
    }
    Ok(())
}

fn at<T: Display>((axis, position, what): &At<T>) -> String {
    format!("axis {}, position {position}: {what}", axis + 1)
}

impl Display for BusError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            BusError::InUse => f.write_str("the bus is already open in this process"),
            BusError::NoDevice(why) => write!(
                f,
                "no device replies ({why}): check the cable and that the drives are on"
            ),
            BusError::AlreadyInOp => f.write_str(
                "a device is already in OP: another master uses this bus, or one ended a moment ago: stop \
                 it and wait for the watchdog of the drives, or take them out of operation with \
                 `flexhex-gateway off`",
            ),
            BusError::NotInitialised(why) => {
                write!(f, "initialisation of the devices failed: {why}")
            }
            BusError::Silent => {
                f.write_str("no reply from the bus within 60 s: check cable and drives")
            }
            BusError::Stopped => f.write_str("stopped on request; no drive was enabled"),
            BusError::Identity(all) => lines(f, all),
            BusError::Energised(all) => lines(f, all),
            BusError::Differences(all) => lines(f, all.iter().map(at)),
            BusError::Drive(one) => f.write_str(&at(one)),
            BusError::NoPosition => f.write_str("profile.tx: no entry has the role position"),
            BusError::NotMapped(why) => {
                write!(f, "mapping of the process data failed: {}", words(why))
            }
            BusError::OtherSize { name, address, mapped, wanted } => write!(
                f,
                "{name} at address {address:#06x} maps {} bytes out and {} in, expected {} and {}: \
                 compare profile.rx and profile.tx with its objects 0x1C12 and 0x1C13",
                mapped.0, mapped.1, wanted.0, wanted.1
            ),
            BusError::Clocks(why) => write!(f, "distributed clocks: {why}"),
            BusError::Refused(why, codes) => {
                write!(f, "the drives did not reach SAFE-OP or OP ({})", words(why))?;
                codes.iter().try_for_each(|(axis, position, code)| {
                    write!(f, "\n{}", at(&(*axis, *position, al::describe(*code))))
                })
            }
            BusError::Late(within_ms, drives) => {
                write!(f, "not every drive reached OP within {within_ms} ms")?;
                drives.iter().try_for_each(|(axis, position, (status, code))| {
                    write!(f, "\n{}", at(&(*axis, *position, al::name(*status))))?;
                    match code {
                        Some(code) => write!(f, ", {}", al::describe(*code)),
                        None if *status == 0 => Ok(()),
                        None => f.write_str(", AL status code not read"),
                    }
                })
            }
        }
    }
}

impl Display for Stranger {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Stranger::Few(differences, wanted) => write!(
                f,
                "{differences} devices on the bus, expected {wanted} drives: check that all are on and all \
                 cables plugged in"
            ),
            Stranger::Missing(axis, position) => {
                write!(f, "axis {}: no device at position {position}", axis + 1)
            }
            Stranger::Other(one) => f.write_str(&at(one)),
        }
    }
}

impl Display for Energised {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self.axis {
            Some(axis) => write!(f, "axis {}, position {}: ", axis + 1, self.position)?,
            None => write!(f, "position {}, no drive of the configuration: ", self.position)?,
        }
        match self.state {
            Fault => write!(
                f,
                "fault {:#06x}: remove its cause, then run with --reset-faults",
                self.error_code
            ),
            state => write!(
                f,
                "already energised ({}): find out what enabled it and disable it first",
                state.name()
            ),
        }
    }
}

impl Display for DriveError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            DriveError::Sdo(why) => why.fmt(f),
            DriveError::NoObject(object) => write!(f, "object {object:#06x} cannot be read by SDO"),
            DriveError::Register(register, why) => {
                write!(f, "register {register:#06x} of its watchdog: {}", words(why))
            }
            DriveError::NoOutputs => {
                f.write_str("no active sync manager for outputs (registers 0x0810 to 0x083f)")
            }
            DriveError::Gone(why) => why.fmt(f),
        }
    }
}

impl Ends for BusError {
    fn exit(&self) -> Exit {
        match self {
            BusError::Stopped => Exit::Good,
            _ => Exit::Failed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_drive_has_its_line_with_place_value_and_remedy() {
        let differs = |k: usize| (k, 7, Difference::new("product", "0x63", "0x2", "another type"));
        let text = BusError::Differences(vec![differs(0), differs(3)]).to_string();
        let line = "position 7: product is 0x63, expected 0x2: another type";
        assert_eq!(text, format!("axis 1, {line}\naxis 4, {line}"));
        let late = [(1, 1, (4, Some(0x1b))), (3, 3, (4, None)), (2, 2, (0, None))];
        let late = BusError::Late(900, late.to_vec());
        let text = late.to_string();
        assert!(text.starts_with(
            "not every drive reached OP within 900 ms\naxis 2, position 1: SAFE-OP, AL status"
        ));
        assert!(text.contains("\naxis 4, position 3: SAFE-OP, AL status code not read"), "{text}");
        assert!(text.ends_with("\naxis 3, position 2: no reply"), "{text}");
        let on = |axis, state| Energised { position: 4, axis, state, error_code: 0x7305 };
        let text = BusError::Energised(vec![on(None, State::OperationEnabled), on(Some(2), Fault)]);
        let text = text.to_string();
        assert!(text.starts_with("position 4, no drive of the configuration: already energised"));
        assert!(text.contains("\naxis 3, position 4: fault 0x7305: remove its cause"), "{text}");
    }
}
