//! The start-up list: objects that are written to a drive by SDO before power, and read back.

use serde::Deserialize;

use super::mistakes::Mistakes;

/// Integer type of an object.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
}

impl Kind {
    fn range(self) -> (i64, i64) {
        match self {
            Kind::U8 => (0, u8::MAX.into()),
            Kind::I8 => (i8::MIN.into(), i8::MAX.into()),
            Kind::U16 => (0, u16::MAX.into()),
            Kind::I16 => (i16::MIN.into(), i16::MAX.into()),
            Kind::U32 => (0, u32::MAX.into()),
            Kind::I32 => (i32::MIN.into(), i32::MAX.into()),
        }
    }
}

/// One object of a start-up list.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct Sdo {
    pub object: u16,
    #[serde(default)]
    pub sub: u8,
    #[serde(rename = "type")]
    pub kind: Kind,
    pub value: i64,
    #[serde(default)]
    pub name: String,
    /// A drive without this object is accepted.
    #[serde(default)]
    pub optional: bool,
    /// Compared and never written.
    #[serde(default)]
    pub read_only: bool,
}

impl Sdo {
    pub fn same_object(&self, other: &Sdo) -> bool {
        (self.object, self.sub) == (other.object, other.sub)
    }

    /// `0x60c2:1 (units of the cycle time)`
    pub fn label(&self) -> String {
        let at = format!("{:#06x}:{}", self.object, self.sub);
        if self.name.is_empty() {
            at
        } else {
            format!("{at} ({})", self.name)
        }
    }
}

/// Adds the mistakes of a list at this key. `sent`: objects that the drive gets in every cycle.
pub(super) fn check(at: &str, list: &[Sdo], sent: &[u16], mistakes: &mut Mistakes) {
    for (k, sdo) in list.iter().enumerate() {
        let (low, high) = sdo.kind.range();
        if !(low..=high).contains(&sdo.value) {
            let (kind, value) = (sdo.kind, sdo.value);
            mistakes.add(format!(
                "{at}[{k}].value = {value}, allowed {low} to {high} for type {kind:?}: correct one \
                 of both"
            ));
        }
        if sdo.object < 0x1000 {
            let object = sdo.object;
            mistakes.add(format!("{at}[{k}].object = {object:#06x}, allowed 0x1000 to 0xffff"));
        }
        if sent.contains(&sdo.object) && !sdo.read_only {
            mistakes.add(format!(
                "{at}[{k}]: {} is in profile.rx, so each frame writes it, and before power nothing else may: remove it",
                sdo.label()
            ));
        }
        if list[..k].iter().any(|before| before.same_object(sdo)) {
            mistakes.add(format!("{at}[{k}]: {} stands twice: remove one", sdo.label()));
        }
    }
}
