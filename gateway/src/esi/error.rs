//! Why an ESI file gives no profile.

use std::fmt::{self, Display, Formatter};

use crate::exit::{Ends, Exit};
use crate::file_error::FileError;

#[derive(Debug)]
pub enum EsiError {
    Unreadable(FileError),
    NotXml(roxmltree::Error),
    /// Another kind of XML, with this root.
    NotEsi(String),
    /// An element without a child or an attribute.
    Missing {
        element: String,
        part: String,
    },
    /// Text of an element or attribute that is no number, or no bytes.
    NoNumber {
        part: String,
        text: String,
    },
    NoBytes(String),
    Above {
        part: &'static str,
        value: u32,
        most: u32,
    },
    /// One of these within a device, a PDO or an entry.
    At(String, Box<EsiError>),
    /// By direction: objects that no PDO has beside the others, and PDOs that may be changed.
    NoPdo(Vec<Lacking>),
    /// The devices of the file: none or several fit; product code and name.
    Choose(Vec<(u32, String)>),
}

/// Objects that no PDO of one direction has.
#[derive(Debug)]
pub struct Lacking {
    pub objects: Vec<u16>,
    /// PDOs whose entries may be changed.
    pub free: Vec<u16>,
}

impl EsiError {
    pub fn at(place: impl Display) -> impl FnOnce(EsiError) -> EsiError {
        move |why| EsiError::At(place.to_string(), Box::new(why))
    }
}

fn list(objects: &[u16]) -> String {
    let named: Vec<_> = objects.iter().map(|object| format!("{object:#06x}")).collect();
    named.join(", ")
}

impl Display for EsiError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            EsiError::Unreadable(why) => why.fmt(f),
            EsiError::NotXml(why) => write!(f, "no XML: {why}: name the ESI file of the drive"),
            EsiError::NotEsi(root) => {
                write!(f, "no ESI file: its root is <{root}>, expected <EtherCATInfo>")
            }
            EsiError::Missing { element, part } => write!(f, "<{element}> without {part}"),
            EsiError::NoNumber { part, text } => write!(f, "{part} {text:?} is no number"),
            EsiError::NoBytes(text) => {
                write!(f, "<Data> {text:?} is no bytes, expected pairs of hexadecimal digits")
            }
            EsiError::Above { part, value, most } => {
                write!(f, "{part} {value:#x} is above {most:#x}")
            }
            EsiError::At(place, why) => write!(f, "{place}: {why}"),
            EsiError::NoPdo(all) => all.iter().enumerate().try_for_each(|(k, lacking)| {
                let end = if k == 0 { "" } else { "\n" };
                write!(f, "{end}{lacking}")
            }),
            EsiError::Choose(all) => {
                f.write_str("choose one device by --product:")?;
                all.iter().try_for_each(|(code, name)| write!(f, "\n  {code:#010x} {name}"))
            }
        }
    }
}

impl Display for Lacking {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let free = if self.free.is_empty() { "there is none".to_owned() } else { list(&self.free) };
        write!(
            f,
            "no PDO of the file has {} beside the others: name the drive's own objects \
             (--target-torque, --actual-torque, --position), or write the entries of a PDO that may be \
             changed ({free}) by hand",
            list(&self.objects)
        )
    }
}

impl Ends for EsiError {
    fn exit(&self) -> Exit {
        Exit::BadInput
    }
}
