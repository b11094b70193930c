//! Checks of the connections between variables.

use std::collections::HashMap;

use crate::component::Component;
use crate::error::{unknown, Error};
use crate::structure::Wire;
use crate::variables::{Causality, Kind, Variable};

/// Refuses the first mistake: unknown ends, wrong causality, a String, unequal types or units, an
/// input fed twice or by nothing.
pub(crate) fn check(wires: &[Wire], components: &[Component]) -> Result<(), Error> {
    let mut fed: HashMap<(&str, &str), &Wire> = HashMap::new();
    for wire in wires {
        check_ends(wire, components).map_err(|e| e.at(format!("connection {wire}")))?;
        let end = (wire.target.as_str(), wire.input.as_str());
        if let Some(other) = fed.insert(end, wire) {
            return Err(Error::new(format!(
                "{}.{} is fed by {}.{} and by {}.{}: keep one connection",
                wire.target, wire.input, other.source, other.output, wire.source, wire.output
            )));
        }
    }
    for component in components {
        let missing: Vec<&str> = component
            .of(Causality::Input)
            .map(|v| v.name.as_str())
            .filter(|input| !fed.contains_key(&(component.name(), *input)))
            .collect();
        if let Some(first) = missing.first() {
            let more = match missing.len() {
                1 => String::new(),
                count => format!(" and {} more", count - 1),
            };
            return Err(Error::new(format!(
                "{}.{first}{more}: not connected; connect an output to it",
                component.name()
            )));
        }
    }
    Ok(())
}

fn check_ends(wire: &Wire, components: &[Component]) -> Result<(), Error> {
    let start =
        port(components, &wire.source, &wire.output, (Causality::Output, "starts at an output"))?;
    let end = port(components, &wire.target, &wire.input, (Causality::Input, "ends at an input"))?;
    if start.kind != end.kind || start.declared_type.is_empty() != end.declared_type.is_empty() {
        let text = "of another type than the variable that it feeds: connect another one";
        return Err(Error::new(format!("{}.{} is {text}", wire.source, wire.output)));
    }
    if start.unit != end.unit {
        return Err(Error::new(format!(
            "'{}' into '{}', units must be equal: connect another variable or correct a unit",
            start.unit, end.unit
        )));
    }
    Ok(())
}

fn port<'a>(
    components: &'a [Component],
    component: &str,
    name: &str,
    (causality, rule): (Causality, &str),
) -> Result<&'a Variable, Error> {
    let owner = find(components, component)?;
    let variable = owner.fmu().variable(name).map_err(|e| e.at(format!("in {component}")))?;
    if variable.causality != causality {
        return Err(Error::new(format!(
            "{component}.{name} is of causality {}; a connection {rule}",
            variable.causality
        )));
    }
    if variable.kind == Kind::String {
        return Err(Error::new(format!("{component}.{name} is a String")));
    }
    Ok(variable)
}

/// The component of that name, or an error that names the nearest one.
pub(crate) fn find<'a>(components: &'a [Component], name: &str) -> Result<&'a Component, Error> {
    let known = components.iter().map(Component::name);
    components
        .iter()
        .find(|c| c.name() == name)
        .ok_or_else(|| Error::new(unknown("component", name, known)))
}
