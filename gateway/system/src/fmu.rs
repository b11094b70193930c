//! Model description of an FMU, and its binary for this platform in a temporary folder.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use crate::archive::{enclosed, Archive};
use crate::error::{renamed, unknown, Error};
use crate::variables::{items, variables, Variable};

/// As FMI 2.0 names this platform, and how its shared libraries end.
const PLATFORM: (&str, &str) = if cfg!(target_os = "macos") {
    ("darwin64", "dylib")
} else if cfg!(target_arch = "aarch64") {
    ("aarch64-linux", "so")
} else {
    ("linux64", "so")
};

/// One FMI 2.0 co-simulation FMU, unpacked.
#[derive(Debug)]
pub(crate) struct Fmu {
    pub file: String,
    pub guid: String,
    pub step_size: Option<f64>,
    pub categories: Vec<String>,
    pub variables: Vec<Variable>,
    by_name: HashMap<String, usize>,
    /// Names and values of the items of the enumerations, by type.
    items: HashMap<String, Vec<(String, f64)>>,
    model: String,
    platforms: Vec<String>,
    root: PathBuf,
}

impl Fmu {
    /// Reads an FMU and unpacks its resources and, if there is one, its binary below `root`.
    pub fn open(mut archive: Archive, root: PathBuf) -> Result<Fmu, Error> {
        let file = archive.name().to_owned();
        let text = archive.text("modelDescription.xml")?;
        let place = format!("{file}: modelDescription.xml");
        let document = Document::parse(&text)
            .map_err(|e| Error::new(format!("not valid XML: {e}")).at(&place))?;
        let top = document.root_element();
        let model = model_identifier(top).map_err(|e| e.at(&file))?;
        let variables = variables(top).map_err(|e| e.at(&place))?;
        let members = archive.members();
        fs::create_dir_all(root.join("resources"))
            .map_err(|e| Error::new(format!("cannot be created ({e})")).at(root.display()))?;
        for member in &members {
            let unpack = *member == binary(&model) || member.starts_with("resources/");
            if unpack && !member.ends_with('/') && enclosed(member) {
                archive.extract(member, &root)?;
            }
        }
        let experiment = child(top, "DefaultExperiment");
        Ok(Fmu {
            guid: top.attribute("guid").unwrap_or_default().to_owned(),
            step_size: experiment.and_then(|e| e.attribute("stepSize")?.trim().parse().ok()),
            categories: categories(top),
            by_name: variables.iter().enumerate().map(|(k, v)| (v.name.clone(), k)).collect(),
            variables,
            items: items(top),
            platforms: platforms(&members),
            file,
            model,
            root,
        })
    }

    pub fn find(&self, name: &str) -> Option<&Variable> {
        self.by_name.get(name).map(|&k| &self.variables[k])
    }

    /// The same, or an error that names the nearest variable.
    pub fn variable(&self, name: &str) -> Result<&Variable, Error> {
        let known = self.variables.iter().map(|v| v.name.as_str());
        self.find(name).ok_or_else(|| Error::new(unknown("variable", name, known)))
    }

    /// An error for the name that a variable had before its array's elements had names.
    pub fn not_renamed(&self, name: &str) -> Result<(), Error> {
        match renamed(name, self.variables.iter().map(|v| v.name.as_str())) {
            Some(_) => self.variable(name).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Names and values of the items of a variable's enumeration; empty where it is none.
    pub fn items(&self, variable: &Variable) -> &[(String, f64)] {
        self.items.get(&variable.declared_type).map_or(&[], Vec::as_slice)
    }

    /// Path of the shared library for this machine.
    pub fn library(&self) -> Result<PathBuf, Error> {
        let path = self.root.join(binary(&self.model));
        if path.is_file() {
            return Ok(path);
        }
        let content = match self.platforms.as_slice() {
            [] => "no binary at all".to_owned(),
            names => format!("binaries for {}", names.join(", ")),
        };
        Err(Error::new(format!(
            "holds {content}, none for this machine ({}): build it here, or for instance \
             with `flexhex build --platform {}`",
            PLATFORM.0, PLATFORM.0
        ))
        .at(&self.file))
    }

    /// `file://` address of the unpacked resources.
    pub fn resources(&self) -> String {
        address(&self.root.join("resources"))
    }
}

fn binary(model: &str) -> String {
    format!("binaries/{}/{model}.{}", PLATFORM.0, PLATFORM.1)
}

/// Platforms for which the archive holds anything below `binaries/`.
fn platforms(members: &[String]) -> Vec<String> {
    let mut names: Vec<String> = members
        .iter()
        .filter_map(|m| m.strip_prefix("binaries/")?.split_once('/'))
        .filter(|(_, file)| !file.is_empty())
        .map(|(platform, _)| platform.to_owned())
        .collect();
    names.sort();
    names.dedup();
    names
}

fn address(path: &Path) -> String {
    let mut text = String::from("file://");
    for byte in path.as_os_str().as_encoded_bytes() {
        if byte.is_ascii_alphanumeric() || b"/-._~".contains(byte) {
            text.push(char::from(*byte));
        } else {
            text.push_str(&format!("%{byte:02X}"));
        }
    }
    text
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|c| c.has_tag_name(tag))
}

fn model_identifier(top: Node) -> Result<String, Error> {
    let version = top.attribute("fmiVersion").unwrap_or("?");
    match child(top, "CoSimulation") {
        Some(slave) if version == "2.0" => {
            let model = slave.attribute("modelIdentifier").unwrap_or_default();
            let plain = !model.is_empty() && enclosed(model) && !model.contains('/');
            let text = format!("modelIdentifier '{model}' is no name of a file");
            if plain {
                Ok(model.to_owned())
            } else {
                Err(Error::new(text))
            }
        }
        other => {
            let kind = if other.is_some() { "co-simulation" } else { "no co-simulation" };
            let text = format!("FMI {version}, {kind}: export it for FMI 2.0 co-simulation");
            Err(Error::new(text))
        }
    }
}

fn categories(top: Node) -> Vec<String> {
    let all = child(top, "LogCategories");
    all.iter()
        .flat_map(|c| c.children())
        .filter_map(|c| c.attribute("name"))
        .filter(|name| ["logStatusError", "logStatusDiscard", "logStatusWarning"].contains(name))
        .map(str::to_owned)
        .collect()
}
