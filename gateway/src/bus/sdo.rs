//! Objects of a drive by SDO, with errors in words.

use ethercrab::error::{CoeAbortCode, Error, MailboxError};
use ethercrab::{EtherCrabWireReadSized, EtherCrabWireWrite, SubDevice, SubDeviceRef};
use std::fmt;

use crate::config::Kind;

pub type Device<'a> = SubDeviceRef<'static, &'a SubDevice>;

/// Why an object was not read or written.
#[derive(Clone, Debug)]
pub enum SdoError {
    /// The drive does not have this object.
    Absent {
        object: u16,
        sub: u8,
    },
    Failed {
        object: u16,
        sub: u8,
        writing: bool,
        why: Error,
    },
}

impl SdoError {
    fn new(object: u16, sub: u8, writing: bool, why: Error) -> Self {
        use CoeAbortCode::{NotFound, SubIndexNotFound};
        match why {
            Error::Mailbox(MailboxError::Aborted { code: NotFound | SubIndexNotFound, .. }) => {
                SdoError::Absent { object, sub }
            }
            _ => SdoError::Failed { object, sub, writing, why },
        }
    }
}

impl fmt::Display for SdoError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            SdoError::Absent { object, sub } => {
                write!(f, "object {object:#06x}:{sub} does not exist in this drive")
            }
            SdoError::Failed { object, sub, writing, why } => {
                let what = if *writing { "written" } else { "read" };
                write!(f, "object {object:#06x}:{sub} cannot be {what}: {}", words(why))
            }
        }
    }
}

/// An error of ethercrab without its debug form.
pub fn words(why: &Error) -> String {
    match why {
        Error::Mailbox(MailboxError::Aborted { code, .. }) => format!("SDO abort {code}"),
        other => other.to_string(),
    }
}

pub async fn read<T>(device: &Device<'_>, object: u16, sub: u8) -> Result<T, SdoError>
where
    T: EtherCrabWireReadSized,
{
    let done = device.sdo_read(object, sub).await;
    done.map_err(|why| SdoError::new(object, sub, false, why))
}

pub async fn write<T>(device: &Device<'_>, object: u16, sub: u8, value: T) -> Result<(), SdoError>
where
    T: EtherCrabWireWrite,
{
    let done = device.sdo_write(object, sub, value).await;
    done.map_err(|why| SdoError::new(object, sub, true, why))
}

/// The value, or None if the drive does not have the object.
pub async fn read_if_there<T>(
    device: &Device<'_>,
    object: u16,
    sub: u8,
) -> Result<Option<T>, SdoError>
where
    T: EtherCrabWireReadSized,
{
    match read(device, object, sub).await {
        Ok(value) => Ok(Some(value)),
        Err(SdoError::Absent { .. }) => Ok(None),
        Err(why) => Err(why),
    }
}

/// An integer of a type that the configuration names; None if the drive does not have it.
pub async fn read_integer(
    device: &Device<'_>,
    (object, sub): (u16, u8),
    kind: Kind,
) -> Result<Option<i64>, SdoError> {
    Ok(match kind {
        Kind::U8 => read_if_there::<u8>(device, object, sub).await?.map(i64::from),
        Kind::I8 => read_if_there::<i8>(device, object, sub).await?.map(i64::from),
        Kind::U16 => read_if_there::<u16>(device, object, sub).await?.map(i64::from),
        Kind::I16 => read_if_there::<i16>(device, object, sub).await?.map(i64::from),
        Kind::U32 => read_if_there::<u32>(device, object, sub).await?.map(i64::from),
        Kind::I32 => read_if_there::<i32>(device, object, sub).await?.map(i64::from),
    })
}

/// Write an integer whose range the configuration has checked.
pub async fn write_integer(
    device: &Device<'_>,
    (object, sub): (u16, u8),
    kind: Kind,
    value: i64,
) -> Result<(), SdoError> {
    match kind {
        Kind::U8 | Kind::I8 => write(device, object, sub, value as u8).await,
        Kind::U16 | Kind::I16 => write(device, object, sub, value as u16).await,
        Kind::U32 | Kind::I32 => write(device, object, sub, value as u32).await,
    }
}
