//! Reads `SystemStructure.ssd` of a flat SSP 1.x, with the rules of `ssp/read.py`.

use roxmltree::{Document, Node};

use crate::archive::Archive;
use crate::error::Error;
use crate::structure::{Element, Setting, Structure, Wire};
use crate::value::Value;
use crate::variables::value_of;

const SSD: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";
const SSC: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
const SSV: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
const OMS: &str =
    "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
/// Elements that may hold the base step [s]; the first present wins.
const BASE_STEPS: [(&str, &str, &str); 4] = [
    ("urn:flexhex:schedule", "Schedule", "baseStep"),
    ("http://opensimulationplatform.com/SSP/OSPAnnotations", "FixedStepAlgorithm", "baseStepSize"),
    (OMS, "FixedStepMaster", "stepSize"),
    (OMS, "SimulationInformation", "fixedStepSize"),
];

/// Reads `SystemStructure.ssd` and the parameter sets it refers to.
pub(crate) fn read(archive: &mut Archive) -> Result<Structure, Error> {
    let file = archive.name().to_owned();
    let text = archive.text("SystemStructure.ssd")?;
    let document = parse(&text, "SystemStructure.ssd").map_err(|e| e.at(&file))?;
    structure(&document, archive).map_err(|e| e.at(&file))
}

fn structure(document: &Document, archive: &mut Archive) -> Result<Structure, Error> {
    let root = document.root_element();
    if !root.has_tag_name((SSD, "SystemStructureDescription")) {
        return Err(Error::new("SystemStructure.ssd is no SSP 1.x system description"));
    }
    let top = child(root, (SSD, "System"))
        .ok_or_else(|| Error::new("SystemStructure.ssd holds no System"))?;
    refuse(top)?;
    let mut elements = Vec::new();
    for node in grandchildren(top, "Elements", "Component") {
        elements.push(element(node, archive)?);
    }
    if elements.is_empty() {
        return Err(Error::new("no components: nothing to run"));
    }
    Ok(Structure {
        elements,
        wires: grandchildren(top, "Connections", "Connection")
            .map(wire)
            .collect::<Result<_, _>>()?,
        settings: parameter_sets(top, archive)?,
        base_step: base_step(root)?,
    })
}

fn parse<'a>(text: &'a str, file: &str) -> Result<Document<'a>, Error> {
    Document::parse(text).map_err(|e| Error::new(format!("{file}: not valid XML: {e}")))
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: (&str, &str)) -> Option<Node<'a, 'i>> {
    node.children().find(|c| c.has_tag_name(tag))
}

fn grandchildren<'a>(
    node: Node<'a, 'a>,
    outer: &'static str,
    inner: &'static str,
) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children()
        .filter(move |c| c.has_tag_name((SSD, outer)))
        .flat_map(|c| c.children())
        .filter(move |c| c.has_tag_name((SSD, inner)))
}

fn refuse(top: Node) -> Result<(), Error> {
    let holds = |outer: &str, inner: (&str, &str)| {
        let outer = top.children().filter(|c| c.has_tag_name((SSD, outer)));
        outer.flat_map(|c| c.descendants()).any(|c| c.has_tag_name(inner))
    };
    let what = if holds("Elements", (SSD, "System")) {
        "nested systems"
    } else if holds("Elements", (SSD, "SignalDictionaryReference")) {
        "signal dictionaries"
    } else if holds("Connections", (SSC, "LinearTransformation")) {
        "transformations"
    } else {
        return Ok(());
    };
    Err(Error::new(format!(
        "holds {what}: the executor runs flat systems; write the system without them"
    )))
}

fn element(node: Node, archive: &mut Archive) -> Result<Element, Error> {
    let name = node.attribute("name").unwrap_or_default();
    match node.attribute("type") {
        None | Some("" | "application/x-fmu-sharedlibrary") => {}
        Some(kind) => {
            let text = format!("{name}: component type '{kind}' is no FMU");
            return Err(Error::new(text));
        }
    }
    Ok(Element {
        name: name.to_owned(),
        source: node.attribute("source").unwrap_or_default().to_owned(),
        settings: parameter_sets(node, archive)?,
    })
}

fn wire(node: Node) -> Result<Wire, Error> {
    let end = |key| {
        node.attribute(key).map(str::to_owned).ok_or_else(|| {
            Error::new("connects to a connector of the system: the executor has none")
        })
    };
    Ok(Wire {
        source: end("startElement")?,
        output: end("startConnector")?,
        target: end("endElement")?,
        input: end("endConnector")?,
    })
}

/// Name and value of every parameter in the parameter sets of a component or of the system.
fn parameter_sets(node: Node, archive: &mut Archive) -> Result<Vec<Setting>, Error> {
    let mut settings = Vec::new();
    let bindings: Vec<Node> = node
        .children()
        .filter(|c| c.has_tag_name((SSD, "ParameterBindings")))
        .flat_map(|c| c.children())
        .filter(|c| c.has_tag_name((SSD, "ParameterBinding")))
        .collect();
    for binding in bindings {
        if child(binding, (SSD, "ParameterMapping")).is_some() {
            return Err(Error::new("holds a parameter mapping: name the parameters directly"));
        }
        let prefix = binding.attribute("prefix").unwrap_or_default();
        match binding.attribute("source").filter(|s| !s.is_empty()) {
            Some(source) => {
                let text = archive.text(source)?;
                let document = parse(&text, source)?;
                collect(document.root_element(), prefix, &mut settings)?;
            }
            None => {
                let set = child(binding, (SSD, "ParameterValues"))
                    .and_then(|v| child(v, (SSV, "ParameterSet")));
                if let Some(set) = set {
                    collect(set, prefix, &mut settings)?;
                }
            }
        }
    }
    Ok(settings)
}

fn collect(set: Node, prefix: &str, settings: &mut Vec<Setting>) -> Result<(), Error> {
    let groups = set.children().filter(|c| c.has_tag_name((SSV, "Parameters")));
    for entry in groups.flat_map(|g| g.children()) {
        if !entry.has_tag_name((SSV, "Parameter")) {
            continue;
        }
        let name = entry.attribute("name").unwrap_or_default();
        let typed = entry.children().find(Node::is_element);
        let text = typed.and_then(|typed| typed.attribute("value")).unwrap_or_default().trim();
        let unit = typed.and_then(|typed| typed.attribute("unit")).unwrap_or_default().to_owned();
        let name = format!("{prefix}{name}");
        let is_item = typed.is_some_and(|typed| typed.has_tag_name((SSV, "Enumeration")));
        if is_item && !text.is_empty() {
            settings.push(Setting { name, value: Value::Item(text.to_owned()), unit });
            continue;
        }
        let value = value_of(text).filter(|value| value.is_finite()).ok_or_else(|| {
            Error::new(format!("parameter '{name}' has no finite value: '{text}'"))
        })?;
        settings.push(Setting { name, value: Value::Number(value), unit });
    }
    Ok(())
}

fn base_step(root: Node) -> Result<Option<f64>, Error> {
    for (namespace, tag, key) in BASE_STEPS {
        let mut named = root.descendants().filter(|n| n.has_tag_name((namespace, tag)));
        if let Some(text) = named.find_map(|n| n.attribute(key)) {
            let step = text.trim().parse::<f64>().ok();
            return match step.filter(|s| *s > 0.0 && s.is_finite()) {
                Some(step) => Ok(Some(step)),
                None => Err(Error::new(format!(
                    "{tag} is '{text}', must be a positive number of seconds"
                ))),
            };
        }
    }
    Ok(None)
}
