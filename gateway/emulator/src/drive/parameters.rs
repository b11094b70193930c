//! Objects that a drive stores and shows; only the SYNC0 period is compared with one of them.
use super::bytes::signed;
use super::setting::Setting;
use crate::coe::abort;
use serde::Deserialize;

/// `save` in object 0x1010 stores all parameters [CiA 301].
const STORE: u16 = 0x1010;
const SAVE: i64 = 0x6576_6173;
const PERIOD: u16 = 0x60C2;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Access {
    #[default]
    Writable,
    ReadOnly,
    /// Takes a write without an error and keeps its value.
    Stuck,
    /// The drive does not have it.
    Absent,
}

/// One object with its value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    pub object: u16,
    #[serde(default)]
    pub sub: u8,
    /// 0 in the options: as the drive has it.
    #[serde(default)]
    pub bits: u8,
    #[serde(default)]
    pub value: i64,
    #[serde(default)]
    pub access: Access,
}

#[derive(Debug, Clone)]
pub struct Parameters {
    all: Vec<Parameter>,
    /// `save` was written since this was last asked.
    stored: bool,
}

impl Parameters {
    pub fn new(setting: &Setting) -> Parameters {
        // 2^32 counts do not fit into 0x608F and show as 0
        let counts = i64::from(setting.counts_per_rev as u64 as u32);
        let table = [
            (STORE, 0, 8, 1, Access::ReadOnly),
            (STORE, 1, 32, 1, Access::Writable),
            (0x1C32, 0, 8, 1, Access::ReadOnly),
            (0x1C32, 1, 16, 1, Access::Writable),
            (0x605A, 0, 16, 2, Access::Writable),
            (0x605B, 0, 16, 0, Access::Writable),
            (0x605C, 0, 16, 1, Access::Writable),
            (0x605D, 0, 16, 1, Access::Writable),
            (0x605E, 0, 16, 2, Access::Writable),
            (0x607E, 0, 8, 0, Access::Writable),
            (0x608F, 0, 8, 2, Access::ReadOnly),
            (0x608F, 1, 32, counts, Access::Writable),
            (0x608F, 2, 32, 1, Access::Writable),
            (0x6091, 0, 8, 2, Access::ReadOnly),
            (0x6091, 1, 32, 1, Access::Writable),
            (0x6091, 2, 32, 1, Access::Writable),
            // 2 ms
            (PERIOD, 0, 8, 2, Access::ReadOnly),
            (PERIOD, 1, 8, 2, Access::Writable),
            (PERIOD, 2, 8, -3, Access::Writable),
        ];
        let parameter =
            |(object, sub, bits, value, access)| Parameter { object, sub, bits, value, access };
        Parameters { all: table.into_iter().map(parameter).collect(), stored: false }
    }

    /// Adds objects of the options, or replaces those that are there.
    pub fn replace(&mut self, others: &[Parameter]) {
        for other in others {
            let same = |p: &&mut Parameter| (p.object, p.sub) == (other.object, other.sub);
            match self.all.iter_mut().find(same) {
                Some(place) => {
                    let bits = if other.bits == 0 { place.bits } else { other.bits };
                    *place = Parameter { bits, ..*other };
                }
                None => self.all.push(*other),
            }
        }
    }

    fn find(&self, object: u16, sub: u8) -> Option<&Parameter> {
        self.all.iter().find(|p| (p.object, p.sub) == (object, sub))
    }

    /// Whether an object with this index stands here, whatever its subindexes.
    pub fn has(&self, object: u16) -> bool {
        self.all.iter().any(|p| p.object == object)
    }

    pub fn upload(&self, object: u16, sub: u8) -> Result<Vec<u8>, u32> {
        let parameter = self.find(object, sub).ok_or(abort::NO_SUBINDEX)?;
        if parameter.access == Access::Absent {
            return Err(abort::NO_OBJECT);
        }
        Ok(parameter.value.to_le_bytes()[..usize::from(parameter.bits / 8)].to_vec())
    }

    pub fn download(&mut self, object: u16, sub: u8, data: &[u8]) -> Result<(), u32> {
        let same = |p: &&mut Parameter| (p.object, p.sub) == (object, sub);
        let parameter = self.all.iter_mut().find(same).ok_or(abort::NO_SUBINDEX)?;
        match parameter.access {
            Access::Absent => return Err(abort::NO_OBJECT),
            Access::ReadOnly => return Err(abort::READ_ONLY),
            _ if data.len() != usize::from(parameter.bits / 8) => return Err(abort::LENGTH),
            Access::Stuck => {}
            Access::Writable if object == STORE => self.stored = signed(data) == SAVE,
            Access::Writable => parameter.value = signed(data),
        }
        Ok(())
    }

    pub fn take_stored(&mut self) -> bool {
        std::mem::take(&mut self.stored)
    }

    /// Period of the set points in object 0x60C2 [ns].
    pub fn period_ns(&self) -> Option<u64> {
        let value = |sub| self.find(PERIOD, sub).map(|p| p.value);
        let exponent = u32::try_from(value(2)? + 9).ok()?;
        Some(value(1)? as u64 * 10u64.checked_pow(exponent)?)
    }
}
