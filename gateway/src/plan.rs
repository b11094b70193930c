//! Where a run is recorded to, and what the head of its files says.

use flexhex_system::System;
use std::path::Path;

use crate::config::Config;
use crate::option_error::OptionError;
use crate::record::{provenance, Columns, Plan};
use crate::session;

/// `record`: file of the whole run; `more`: `KEY=VALUE` for its head.
pub fn plan(
    record: Option<&Path>,
    more: &[String],
    config: &Config,
    (system, columns): (&System, Columns),
) -> Result<Plan, OptionError> {
    let mut meta = vec![
        ("run".to_owned(), "gateway".to_owned()),
        ("system".to_owned(), config.system.ssp.display().to_string()),
        ("drives".to_owned(), config.profile.name.clone()),
        ("base_step_s".to_owned(), system.base_step().to_string()),
        ("signals".to_owned(), session::channel_map(config, system)),
    ];
    if let Some(file) = &config.estimate.resume {
        meta.push(("resumed".to_owned(), file.display().to_string()));
    }
    meta.extend(config.homed.iter().map(|homed| ("homed".to_owned(), homed.date.clone())));
    meta.extend(provenance(config.hash));
    for pair in more {
        let (key, value) = pair.split_once('=').ok_or_else(|| OptionError::Meta(pair.clone()))?;
        meta.retain(|(k, _)| k != key);
        meta.push((key.to_owned(), value.to_owned()));
    }
    let folder = record.and_then(|f| f.parent()).unwrap_or(&config.recorder.folder);
    let stem = record.and_then(|f| f.file_stem()).map_or_else(
        || format!("run-{}", std::process::id()),
        |stem| stem.to_string_lossy().into_owned(),
    );
    Ok(Plan {
        columns,
        meta,
        recording: record.map(Path::to_owned),
        before_trip: folder.join(format!("{stem}-trip.csv")),
        keep: (config.recorder.keep_s / system.base_step()).round() as usize,
        reaction: session::longest_landing(config, system) + 400,
    })
}
