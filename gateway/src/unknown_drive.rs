//! `esi`: the profile of a drive that nobody has configured yet, from the file of its maker.

use clap::Args;
use std::io::Write;
use std::path::PathBuf;

use crate::esi::{devices, template, Device, EsiError, Roles};
use crate::exit::{Ends, Exit};
use crate::file_error::FileError;

pub const EXAMPLES: &str = "\
Examples:
  flexhex-gateway esi Drive.xml                              # lists the devices if there are several
  flexhex-gateway esi Drive.xml --product 0x04020010 > profile.toml
  flexhex-gateway esi AKD.xml --target-torque 0x2071 --actual-torque 0x2077 --position 0x6063

Put the [profile] in the place of the one in a copy of gateway/machines/cia402.toml, find out what is marked TODO,
then `check CONFIG --bus`.";

#[derive(Args)]
pub struct Esi {
    /// ESI file of the drive (XML).
    file: PathBuf,
    /// Product code of the device, where the file has several.
    #[arg(long, value_name = "CODE", value_parser = number)]
    product: Option<u32>,
    /// Object of the target torque.
    #[arg(long, value_name = "OBJECT", value_parser = object, default_value = "0x6071")]
    target_torque: u16,
    /// Object of the measured torque.
    #[arg(long, value_name = "OBJECT", value_parser = object, default_value = "0x6077")]
    actual_torque: u16,
    /// Object of the angle.
    #[arg(long, value_name = "OBJECT", value_parser = object, default_value = "0x6064")]
    position: u16,
}

const NO_NUMBER: &str = "write a number such as 0x6071";

fn number(text: &str) -> Result<u32, &'static str> {
    let hex = text.strip_prefix("0x");
    let number = hex.map_or_else(|| text.parse(), |digits| u32::from_str_radix(digits, 16));
    number.map_err(|_| NO_NUMBER)
}

/// Index of an object.
fn object(text: &str) -> Result<u16, &'static str> {
    u16::try_from(number(text)?).map_err(|_| "an object is at most 0xffff")
}

/// Print the profile; the exit code of the command.
pub fn esi(args: &Esi) -> Exit {
    match profile(args) {
        Ok(text) => {
            // the reader may be gone
            let _ = std::io::stdout().write_all(text.as_bytes());
            Exit::Good
        }
        Err(why) => {
            eprintln!("✗ {why}");
            why.exit()
        }
    }
}

fn profile(args: &Esi) -> Result<String, EsiError> {
    let text = std::fs::read_to_string(&args.file).map_err(FileError::of(&args.file));
    let text = text.map_err(EsiError::Unreadable)?;
    of_file(&text, args).map_err(EsiError::at(args.file.display()))
}

fn of_file(text: &str, args: &Esi) -> Result<String, EsiError> {
    let all = devices(text)?;
    let fits = |d: &&Device| args.product.is_none_or(|product| product == d.product_code);
    let mut fitting: Vec<&Device> = all.iter().filter(fits).collect();
    // revisions of one product: the newest
    fitting.sort_by_key(|d| (d.product_code, std::cmp::Reverse(d.revision)));
    fitting.dedup_by_key(|d| d.product_code);
    let [device] = fitting[..] else {
        let names = all.iter().map(|d| (d.product_code, d.name.clone())).collect();
        return Err(EsiError::Choose(names));
    };
    let (target_torque, actual_torque, position) =
        (args.target_torque, args.actual_torque, args.position);
    template(device, &Roles { target_torque, actual_torque, position })
}
