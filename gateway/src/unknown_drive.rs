//! `esi`: the profile of a drive that nobody has configured yet, from the file of its maker.

use clap::Args;
use std::path::PathBuf;

use crate::esi::{devices, template, Device, Roles};
use crate::exit::Exit;

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
    #[arg(long, value_name = "OBJECT", value_parser = number, default_value = "0x6071")]
    target_torque: u32,
    /// Object of the measured torque.
    #[arg(long, value_name = "OBJECT", value_parser = number, default_value = "0x6077")]
    actual_torque: u32,
    /// Object of the angle.
    #[arg(long, value_name = "OBJECT", value_parser = number, default_value = "0x6064")]
    position: u32,
}

fn number(text: &str) -> Result<u32, String> {
    let hex = text.strip_prefix("0x");
    let number = hex.map_or_else(|| text.parse(), |digits| u32::from_str_radix(digits, 16));
    number.map_err(|_| "write a number such as 0x6071".to_owned())
}

/// Print the profile; the exit code of the command.
pub fn esi(args: &Esi) -> Exit {
    match profile(args) {
        Ok(text) => {
            print!("{text}");
            Exit::Good
        }
        Err(why) => {
            eprintln!("✗ {}: {why}", args.file.display());
            Exit::BadInput
        }
    }
}

fn profile(args: &Esi) -> Result<String, String> {
    let text = std::fs::read_to_string(&args.file).map_err(|why| why.to_string())?;
    let all = devices(&text)?;
    let fits = |d: &&Device| args.product.is_none_or(|product| product == d.product_code);
    let mut fitting: Vec<&Device> = all.iter().filter(fits).collect();
    // revisions of one product: the newest
    fitting.sort_by_key(|d| (d.product_code, std::cmp::Reverse(d.revision)));
    fitting.dedup_by_key(|d| d.product_code);
    let [device] = fitting[..] else {
        let names: Vec<_> =
            all.iter().map(|d| format!("  {:#010x} {}", d.product_code, d.name)).collect();
        return Err(format!("choose one device by --product:\n{}", names.join("\n")));
    };
    let object =
        |value: u32| u16::try_from(value).map_err(|_| format!("object {value:#x}: above 0xffff"));
    let roles = Roles {
        target_torque: object(args.target_torque)?,
        actual_torque: object(args.actual_torque)?,
        position: object(args.position)?,
    };
    template(device, &roles)
}
