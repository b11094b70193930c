//! The content of a system description as data, before any FMU is opened.

use std::fmt;

use crate::value::Value;

/// One parameter of a parameter set; without a unit it is in that of the FMU.
#[derive(Clone)]
pub(crate) struct Setting {
    pub name: String,
    pub value: Value,
    pub unit: String,
}

/// A component: the path of its FMU in the archive and its own parameter sets.
pub(crate) struct Element {
    pub name: String,
    pub source: String,
    pub settings: Vec<Setting>,
}

/// One scalar connection.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Wire {
    pub source: String,
    pub output: String,
    pub target: String,
    pub input: String,
}

impl fmt::Display for Wire {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Wire { source, output, target, input } = self;
        write!(f, "{source}.{output} -> {target}.{input}")
    }
}

pub(crate) struct Structure {
    pub elements: Vec<Element>,
    pub wires: Vec<Wire>,
    /// Parameter sets of the system: "component.parameter"; later ones win.
    pub settings: Vec<Setting>,
    /// `[s]`
    pub base_step: Option<f64>,
}
