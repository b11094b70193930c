//! A system opened from a `.ssp`: components with FMUs, parameters and sample times; connections.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use crate::archive::{limited, Archive};
use crate::component::Component;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::folder::Folder;
use crate::ssd;
use crate::structure::{Element, Setting, Structure, Wire};
use crate::value::Value;
use crate::variables::Causality;
use crate::wiring::{check, find};

/// A `.ssp` that was read, checked and unpacked to a temporary folder, removed with the last
/// of the things that were opened from it.
pub struct System {
    base: f64,
    components: Vec<Component>,
    wires: Vec<Wire>,
    folder: Arc<Folder>,
}

impl System {
    pub fn open(path: &Path) -> Result<System, Error> {
        let mut archive = Archive::open(path)?;
        let structure = ssd::read(&mut archive)?;
        let folder = Folder::new()?;
        let fmus = open_fmus(&mut archive, &structure.elements, folder.path())?;
        let at = |e: Error| e.at(path.display());
        let base = base_step(&structure, &fmus).map_err(at)?;
        let mut components: Vec<Component> = Vec::new();
        for element in &structure.elements {
            if components.iter().any(|c| c.name() == element.name) {
                let text = format!("component '{}' exists twice: rename one", element.name);
                return Err(at(Error::new(text)));
            }
            let settings = settings_of(element, &structure.settings);
            let fmu = Arc::clone(&fmus[&element.source]);
            components.push(Component::new(&element.name, fmu, &settings, base).map_err(at)?);
        }
        check(&structure.wires, &components).map_err(at)?;
        Ok(System { base, components, wires: structure.wires, folder: Arc::new(folder) })
    }

    /// One FMU alone, at its own step size and start values. Each input is fed by a signal that has its name.
    pub(crate) fn alone(path: &Path, name: &str) -> Result<System, Error> {
        let folder = Folder::new()?;
        let fmu = Arc::new(Fmu::open(Archive::open(path)?, folder.path().join("0"))?);
        let step = fmu.step_size.filter(|step| *step > 0.0);
        let step = step.ok_or_else(|| Error::new("has no step size").at(path.display()))?;
        let component = Component::new(name, fmu, &[], step).map_err(|e| e.at(path.display()))?;
        let wires = component.of(Causality::Input).map(|variable| Wire {
            source: name.to_owned(),
            output: variable.name.clone(),
            target: name.to_owned(),
            input: variable.name.clone(),
        });
        let wires = wires.collect();
        Ok(System { base: step, components: vec![component], wires, folder: Arc::new(folder) })
    }

    /// `[s]`
    pub fn base_step(&self) -> f64 {
        self.base
    }

    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components.iter().find(|c| c.name() == name)
    }

    pub fn components(&self) -> &[Component] {
        &self.components
    }

    pub(crate) fn wires(&self) -> &[Wire] {
        &self.wires
    }

    pub(crate) fn folder(&self) -> Arc<Folder> {
        Arc::clone(&self.folder)
    }

    /// The same with other values of parameters: ("plant.tau_step", 0.003).
    pub fn with(&self, parameters: &[(String, Value)]) -> Result<System, Error> {
        let mut components = self.components.clone();
        for (text, value) in parameters {
            let at = |e: Error| e.at(format!("parameter '{text}'"));
            let (name, parameter) = text
                .split_once('.')
                .ok_or_else(|| at(Error::new("write it as component.parameter")))?;
            find(&components, name).map_err(at)?;
            let component = components.iter_mut().find(|c| c.name() == name);
            let Some(component) = component else { continue };
            let variable = component.fmu().variable(parameter).map_err(at)?;
            if variable.causality != Causality::Parameter {
                let text = format!("is of causality {}, not a parameter", variable.causality);
                return Err(at(Error::new(text)));
            }
            component.set(parameter, value)?;
            component.schedule(self.base).map_err(at)?;
        }
        Ok(System { base: self.base, components, wires: self.wires.clone(), folder: self.folder() })
    }

    /// The same with another FMU of equal interface for one component. It brings its own values:
    /// those of the `.ssp` describe the one that it replaces.
    pub(crate) fn with_fmu(&self, name: &str, path: &Path) -> Result<System, Error> {
        let mut components = self.components.clone();
        find(&components, name)?;
        let folder = tempfile::Builder::new()
            .prefix("fmu-")
            .tempdir_in(self.folder.path())
            .map_err(|e| Error::new(format!("a temporary folder cannot be created ({e})")))?
            .keep();
        let fmu = Arc::new(Fmu::open(Archive::open(path)?, folder)?);
        for component in components.iter_mut().filter(|c| c.name() == name) {
            *component = Component::new(name, Arc::clone(&fmu), &[], self.base)?;
        }
        check(&self.wires, &components).map_err(|e| e.at(path.display()))?;
        Ok(System { base: self.base, components, wires: self.wires.clone(), folder: self.folder() })
    }
}

/// Settings of one component: its own sets, then those of the system, which win.
fn settings_of(element: &Element, system: &[Setting]) -> Vec<Setting> {
    let mut settings = element.settings.clone();
    for setting in system {
        if let Some((_, parameter)) =
            setting.name.split_once('.').filter(|(component, _)| *component == element.name)
        {
            settings.push(Setting { name: parameter.to_owned(), ..setting.clone() });
        }
    }
    settings
}

fn open_fmus(
    archive: &mut Archive,
    elements: &[Element],
    folder: &Path,
) -> Result<HashMap<String, Arc<Fmu>>, Error> {
    let (mut fmus, mut size) = (HashMap::new(), 0);
    for element in elements {
        if fmus.contains_key(&element.source) {
            continue;
        }
        let name = format!("{}: {}", archive.name(), element.source);
        let inner = Archive::new(archive.read(&element.source)?, name)?;
        size += inner.size;
        limited(size).map_err(|e| {
            let place = format!("{}: {}: with its FMU the system", archive.name(), element.name);
            Error::new(format!("{place} {e}"))
        })?;
        let root = folder.join(fmus.len().to_string());
        fmus.insert(element.source.clone(), Arc::new(Fmu::open(inner, root)?));
    }
    Ok(fmus)
}

/// \[s\]: the description's, else the smallest step size of the FMUs.
fn base_step(structure: &Structure, fmus: &HashMap<String, Arc<Fmu>>) -> Result<f64, Error> {
    let sizes = fmus.values().filter_map(|f| f.step_size).filter(|s| *s > 0.0);
    structure
        .base_step
        .or_else(|| sizes.min_by(f64::total_cmp))
        .ok_or_else(|| Error::new("no base step: add osp:FixedStepAlgorithm with baseStepSize"))
}
