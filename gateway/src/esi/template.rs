//! The `[profile]` of a configuration from a device of an ESI file.

use std::fmt::Write;

use super::error::{EsiError, Lacking};
use super::xml::{Device, InitCmd, Object, PdoMap};

/// Objects of the process data that the gateway needs.
#[derive(Clone, Copy, Debug)]
pub struct Roles {
    pub target_torque: u16,
    pub actual_torque: u16,
    pub position: u16,
}

impl Roles {
    /// The role of an object in the direction to the drive (`rx`), or from it.
    fn of(&self, object: u16, rx: bool) -> &'static str {
        match (rx, object) {
            (_, 0) => "gap",
            (true, 0x6040) => "controlword",
            (true, 0x6060) => "mode",
            (true, o) if o == self.target_torque => "target_torque",
            (false, 0x6041) => "statusword",
            (false, 0x6061) => "mode_display",
            (false, 0x603F) => "error_code",
            (false, o) if o == self.position => "position",
            (false, o) if o == self.actual_torque => "actual_torque",
            _ => "unused",
        }
    }
}

/// Text for the configuration, with what a person must still find out. Err names objects that no PDO has.
pub fn template(device: &Device, roles: &Roles) -> Result<String, EsiError> {
    let rx = chosen(&device.rx, &[0x6040, roles.target_torque]);
    let tx = chosen(&device.tx, &[0x6041, roles.position, roles.actual_torque]);
    let (rx, tx) = match (rx, tx) {
        (Ok(rx), Ok(tx)) => (rx, tx),
        (rx, tx) => {
            return Err(EsiError::NoPdo([rx.err(), tx.err()].into_iter().flatten().collect()));
        }
    };
    let mut out = String::new();
    // writing to a String cannot fail
    let _ = write!(
        out,
        "[profile]\n\
         name = {:?}\n\
         vendor_id = {:#010x}\n\
         product_code = {:#010x}\n\
         # revision = {:#x} # of the file; set it once this firmware is tested\n\
         mode = 10 # cyclic synchronous torque; must be among those in 0x6502 of the drive\n\
         counts_per_revolution = 0.0 # TODO: of object {:#06x}; 0x608F, or the manual\n\
         scale = {{ rated_torque = {{ step_per_mille = 1.0, rated_torque_N_m = 0.0 }} }} # TODO: 0x6076\n",
        device.name, device.vendor_id, device.product_code, device.revision, roles.position,
    );
    startup(&mut out, &device.startup);
    for (direction, maps) in [("rx", rx), ("tx", tx)] {
        for map in maps {
            pdo(&mut out, direction, map, roles);
        }
    }
    Ok(out)
}

/// Objects that the gateway writes by itself: mode, cycle time, synchronisation, assignment and content of PDOs.
fn is_own(object: u16) -> bool {
    matches!(object, 0x6060 | 0x60C2 | 0x1C32 | 0x1C33 | 0x1C12 | 0x1C13 | 0x1600..=0x17FF | 0x1A00..=0x1BFF)
}

/// The start-up list; what it cannot hold is named in a comment.
fn startup(out: &mut String, all: &[InitCmd]) {
    let mut list = String::new();
    for InitCmd { object, sub, data, comment } in all.iter().filter(|c| !is_own(c.object)) {
        let kind = match data.len() {
            1 => "u8",
            2 => "u16",
            4 => "u32",
            bytes => {
                let _ = writeln!(
                    list,
                    "  # {object:#06x}:{sub} has {bytes} bytes, allowed 1, 2 or 4: {comment:?}"
                );
                continue;
            }
        };
        let value = data.iter().rev().fold(0_u64, |value, byte| value << 8 | u64::from(*byte));
        let _ = writeln!(
            list,
            "  {{ object = {object:#06x}, sub = {sub}, type = {kind:?}, value = {value}, name = {comment:?} }},"
        );
    }
    if !list.is_empty() {
        let _ = write!(out, "# from <InitCmd> of the file\nstartup = [\n{list}]\n");
    }
}

/// A PDO that has all these objects, assigned ones first; else several that have no object twice.
fn chosen<'a>(maps: &'a [PdoMap], needed: &[u16]) -> Result<Vec<&'a PdoMap>, Lacking> {
    let has = |map: &PdoMap, object: u16| map.entries.iter().any(|e| e.object == object);
    let mut sorted: Vec<&PdoMap> = maps.iter().collect();
    sorted.sort_by_key(|map| !map.assigned);
    if let Some(map) = sorted.iter().find(|map| needed.iter().all(|object| has(map, *object))) {
        return Ok(vec![*map]);
    }
    let mut cover: Vec<&PdoMap> = Vec::new();
    let mut missing = Vec::new();
    for object in needed {
        if cover.iter().any(|map| has(map, *object)) {
            continue;
        }
        let repeats = |map: &PdoMap| {
            let own = map.entries.iter().filter(|e| e.object != 0);
            own.into_iter().any(|e| cover.iter().any(|taken| has(taken, e.object)))
        };
        match sorted.iter().find(|map| has(map, *object) && !repeats(map)) {
            Some(map) => cover.push(map),
            None => missing.push(*object),
        }
    }
    if missing.is_empty() {
        cover.sort_by_key(|map| map.index);
        return Ok(cover);
    }
    let free = maps.iter().filter(|map| !map.fixed).map(|map| map.index).collect();
    Err(Lacking { objects: missing, free })
}

fn pdo(out: &mut String, direction: &str, map: &PdoMap, roles: &Roles) {
    let _ = write!(out, "\n[[profile.{direction}]]\nindex = {:#06x}\nentries = [\n", map.index);
    for entry in &map.entries {
        let _ = writeln!(out, "  {},", line(entry, roles.of(entry.object, direction == "rx")));
    }
    out.push_str("]\n");
}

fn line(entry: &Object, role: &str) -> String {
    let Object { object, sub, bits, .. } = entry;
    match (object, sub) {
        (0, _) => format!("{{ role = \"gap\", bits = {bits} }}"),
        (_, 0) => format!("{{ role = {role:?}, object = {object:#06x}, bits = {bits} }}"),
        _ => format!("{{ role = {role:?}, object = {object:#06x}, sub = {sub}, bits = {bits} }}"),
    }
}
