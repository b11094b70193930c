//! Variables of a model description: causality, type, start values, items of enumerations.

use std::collections::HashMap;
use std::fmt;

use roxmltree::Node;

use crate::error::Error;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    Parameter,
    Input,
    Output,
    Other,
}

impl fmt::Display for Causality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Causality::Parameter => "parameter",
            Causality::Input => "input",
            Causality::Output => "output",
            Causality::Other => "local",
        })
    }
}

/// As FMI's functions see a variable: an enumeration is an Integer. In the executor's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Real,
    Integer,
    Boolean,
    String,
}

/// One scalar variable; `start` is None where the FMU declares none, of a Boolean 0 or 1.
#[derive(Debug, Clone)]
pub struct Variable {
    pub name: String,
    pub reference: u32,
    pub causality: Causality,
    pub kind: Kind,
    /// Of an enumeration; empty for everything else.
    pub declared_type: String,
    pub unit: String,
    pub start: Option<f64>,
}

/// All of a description, in its order; the first that lacks what it needs is refused.
pub(crate) fn variables(top: Node) -> Result<Vec<Variable>, Error> {
    let all = top.children().filter(|c| c.has_tag_name("ModelVariables"));
    all.flat_map(|v| v.children()).filter(Node::is_element).map(variable).collect()
}

fn variable(element: Node) -> Result<Variable, Error> {
    let kinds = ["Real", "Integer", "Boolean", "String", "Enumeration"];
    let typed = element.children().find(|c| kinds.contains(&c.tag_name().name()));
    let reference = element.attribute("valueReference").and_then(|r| r.parse().ok());
    let (Some(typed), Some(name), Some(reference)) = (typed, element.attribute("name"), reference)
    else {
        return Err(Error::new("a variable lacks name, type or reference: build the FMU again"));
    };
    let kind = match typed.tag_name().name() {
        "Real" => Kind::Real,
        "Boolean" => Kind::Boolean,
        "String" => Kind::String,
        _ => Kind::Integer,
    };
    Ok(Variable {
        name: name.to_owned(),
        reference,
        causality: match element.attribute("causality") {
            Some("parameter") => Causality::Parameter,
            Some("input") => Causality::Input,
            Some("output") => Causality::Output,
            _ => Causality::Other,
        },
        kind,
        declared_type: typed.attribute("declaredType").unwrap_or_default().to_owned(),
        unit: typed.attribute("unit").unwrap_or_default().to_owned(),
        start: typed.attribute("start").filter(|_| kind != Kind::String).and_then(value_of),
    })
}

/// Names and values of the items of all enumerations, by type.
pub(crate) fn items(top: Node) -> HashMap<String, Vec<(String, f64)>> {
    let types = top.children().filter(|c| c.has_tag_name("TypeDefinitions"));
    let types = types.flat_map(|t| t.children()).filter(|t| t.has_tag_name("SimpleType"));
    let named = types.map(|simple| {
        let items = simple.descendants().filter(|i| i.has_tag_name("Item"));
        let items = items.filter_map(|item| {
            let value = item.attribute("value")?.trim().parse().ok()?;
            Some((item.attribute("name")?.to_owned(), value))
        });
        (simple.attribute("name").unwrap_or_default().to_owned(), items.collect())
    });
    named.collect()
}

/// A value of any type as FMI and SSP write it: `0.5`, `2`, `true`.
pub(crate) fn value_of(text: &str) -> Option<f64> {
    match text.trim() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        number => number.parse().ok(),
    }
}
