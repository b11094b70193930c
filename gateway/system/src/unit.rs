//! An FMU instance as the executor takes it.

use std::sync::Arc;

use crate::ffi::Variables;
use crate::fmu::Fmu;
use crate::variables::{Kind, Variable};

/// One FMU instance in the form of the executor.
pub(crate) struct Unit {
    pub name: String,
    pub fmu: Arc<Fmu>,
    pub period: i64,
    pub parameters: Sorted,
    /// Of the parameters.
    pub values: Vec<f64>,
    pub inputs: Sorted,
    /// Bus slots of the inputs.
    pub sources: Vec<usize>,
    /// From the bus slot `slot` on.
    pub outputs: Sorted,
    pub slot: usize,
}

/// Value references of variables in the order of their types, and how many there are of each.
pub(crate) struct Sorted {
    references: Vec<u32>,
    counts: [usize; 3],
}

impl Sorted {
    /// variables: in the order of their types.
    pub fn of(variables: &[&Variable]) -> Sorted {
        let count = |kind| variables.iter().filter(|v| v.kind == kind).count();
        Sorted {
            references: variables.iter().map(|v| v.reference).collect(),
            counts: [count(Kind::Real), count(Kind::Integer), count(Kind::Boolean)],
        }
    }

    pub fn len(&self) -> usize {
        self.references.len()
    }

    /// Points into this value's heap memory.
    pub fn raw(&self) -> Variables {
        let [n_reals, n_integers, n_booleans] = self.counts;
        Variables { n_reals, n_integers, n_booleans, references: self.references.as_ptr() }
    }
}
