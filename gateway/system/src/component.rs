//! A component: an FMU with its parameters and its period.

use std::sync::Arc;

use crate::error::Error;
use crate::fmu::Fmu;
use crate::structure::Setting;
use crate::value::Value;
use crate::variables::{Causality, Variable};

/// Names and values in file order.
pub(crate) type Values = Vec<(String, f64)>;

/// One component of the system.
#[derive(Clone)]
pub struct Component {
    name: String,
    fmu: Arc<Fmu>,
    values: Values,
    period: i64,
}

impl Component {
    pub(crate) fn new(
        name: &str,
        fmu: Arc<Fmu>,
        settings: &[Setting],
        base: f64,
    ) -> Result<Component, Error> {
        let mut component =
            Component { name: name.to_owned(), fmu, values: Values::new(), period: 1 };
        for Setting { name, value, unit } in settings {
            let Some(variable) = component.fmu.find(name) else {
                // SSP has unknown names ignored: an old one would be lost without a word
                component.fmu.not_renamed(name).map_err(|e| e.at(&component.name))?;
                continue;
            };
            if !unit.is_empty() && !variable.unit.is_empty() && *unit != variable.unit {
                let wanted = &variable.unit;
                let text = format!("{name} = {value} {unit}: write the value in {wanted}");
                return Err(Error::new(text).at(&component.name));
            }
            component.set(name, value)?;
        }
        component.schedule(base)?;
        Ok(component)
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    /// Base steps between two of its steps.
    pub fn period(&self) -> i64 {
        self.period
    }

    /// Value of a parameter: the `.ssp`'s, else the FMU's start value; None: no such parameter.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        let start = self.variable(name).filter(|v| v.causality == Causality::Parameter)?.start;
        let set = self.values.iter().find(|(known, _)| known == name);
        set.map(|(_, value)| *value).or(start)
    }

    /// An input, output or parameter of the FMU.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.fmu.find(name)
    }

    /// Its output `fault` at a value, `F.fault = 2 (end_stop)`: named as the FMU's enumeration does.
    pub fn fault_text(&self, fault: f64) -> String {
        let items = self.variable("fault").map_or(&[][..], |v| self.fmu.items(v));
        let item = items.iter().find(|(_, value)| *value == fault).map(|(name, _)| name.as_str());
        format!("{}.fault = {fault} ({})", self.name, item.unwrap_or("not declared"))
    }

    /// Variables of one causality in the order of the FMU.
    pub fn of(&self, causality: Causality) -> impl Iterator<Item = &Variable> {
        let all = self.fmu.variables.iter();
        all.filter(move |v| v.causality == causality)
    }

    pub(crate) fn shared_fmu(&self) -> Arc<Fmu> {
        Arc::clone(&self.fmu)
    }

    pub(crate) fn fmu(&self) -> &Fmu {
        &self.fmu
    }

    /// Values that are set before initialisation.
    pub(crate) fn values(&self) -> &Values {
        &self.values
    }

    pub(crate) fn set(&mut self, name: &str, value: &Value) -> Result<(), Error> {
        let variable = self.fmu.variable(name)?;
        let value = value.number_for(variable, &self.fmu).map_err(|e| e.at(&self.name))?;
        match self.values.iter_mut().find(|(known, _)| known == name) {
            Some(known) => known.1 = value,
            None => self.values.push((name.to_owned(), value)),
        }
        Ok(())
    }

    /// Period from the parameter `Ts`, 1 where there is none.
    pub(crate) fn schedule(&mut self, base: f64) -> Result<(), Error> {
        if let Some(sample_time) = self.parameter("Ts") {
            self.period = whole_steps(sample_time, base).map_err(|e| e.at(&self.name))?;
        }
        Ok(())
    }
}

/// Number of base steps [s] in a sample time [s]. The tolerance, 1e-6 of a base step, is far
/// above the rounding of a decimal fraction and far below half a step.
fn whole_steps(sample_time: f64, base: f64) -> Result<i64, Error> {
    let steps = sample_time / base;
    let whole = steps.round();
    if steps > 0.5 && steps < f64::from(i32::MAX) && (steps - whole).abs() <= 1e-6 {
        return Ok(whole as i64);
    }
    Err(Error::new(format!(
        "Ts = {sample_time} s is {steps} base steps of {base} s, must be a whole number: \
         change Ts or the base step"
    )))
}
