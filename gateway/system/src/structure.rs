//! The content of a system description as data, before any FMU is opened.

use std::fmt;

/// Names and values in file order; later entries win.
pub(crate) type Values = Vec<(String, f64)>;

/// A component: the path of its FMU in the archive and its own parameter sets.
pub(crate) struct Element {
    pub name: String,
    pub source: String,
    pub values: Values,
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
    /// Parameter sets of the system: "component.parameter".
    pub values: Values,
    /// `[s]`
    pub base_step: Option<f64>,
}
