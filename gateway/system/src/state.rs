//! The state of a component that one run saves and another resumes.

use crate::component::Component;
use crate::error::Error;
use crate::variables::Causality;

/// What a component with a thread of its own has learned: all of its FMU's state, and what people
/// and checks read of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    pub component: String,
    /// Of its FMU; another build of other content has another.
    pub guid: String,
    /// Base steps that the FMU has done, in this run and those before it.
    pub steps: i64,
    /// Every parameter of the FMU.
    pub parameters: Vec<(String, f64)>,
    pub outputs: Vec<(String, f64)>,
    /// Of `fmi2SerializeFMUstate`.
    pub bytes: Vec<u8>,
}

impl State {
    /// Refuses a state of another FMU or of other parameters.
    pub(crate) fn check(&self, component: &Component) -> Result<(), Error> {
        let refuse = |text: String| {
            Err(Error::new(format!("{text}: start without the saved state")).at(component.name()))
        };
        let guid = &component.fmu().guid;
        if *guid != self.guid {
            let saved = &self.guid;
            return refuse(format!("the state is of the FMU {saved}, the system has {guid}"));
        }
        let now = parameters(component);
        if now.len() != self.parameters.len() {
            let (ours, saved) = (now.len(), self.parameters.len());
            return refuse(format!("the state has {saved} parameters, the system has {ours}"));
        }
        for ((name, value), (saved_name, saved)) in now.iter().zip(&self.parameters) {
            if name != saved_name || value.to_bits() != saved.to_bits() {
                let text = format!("{name} = {value}, but {saved_name} = {saved} in the state");
                return refuse(text);
            }
        }
        Ok(())
    }

    /// Refuses outputs that the restored FMU does not show.
    pub(crate) fn check_outputs(&self, shown: &[(String, f64)]) -> Result<(), Error> {
        let same =
            |(a, b): (&(String, f64), &(String, f64))| a.0 == b.0 && a.1.to_bits() == b.1.to_bits();
        if self.outputs.len() == shown.len() && self.outputs.iter().zip(shown).all(same) {
            return Ok(());
        }
        let text = "the saved outputs are not those of the saved state: the file was changed";
        Err(Error::new(text).at(&self.component))
    }
}

/// Every parameter with its value.
pub(crate) fn parameters(component: &Component) -> Vec<(String, f64)> {
    let names = component.of(Causality::Parameter).map(|v| v.name.clone());
    names.filter_map(|name| component.parameter(&name).map(|value| (name, value))).collect()
}
