//! The files of a recording.

use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Error, Write};
use std::path::{Path, PathBuf};

use super::columns::Columns;
use super::error::RecordError;
use crate::file_error::FileError;

/// Content and paths of the files.
#[derive(Clone, Debug)]
pub struct Plan {
    pub columns: Columns,
    /// `key: value` lines at the head of each file.
    pub meta: Vec<(String, String)>,
    /// File of every cycle of the controller; None: only the trip file.
    pub recording: Option<PathBuf>,
    /// Trip file: the rows before a trip and those of the reaction.
    pub before_trip: PathBuf,
    /// Rows before the trip, and largest number of rows of the reaction.
    pub keep: usize,
    pub reaction: usize,
}

/// Folders that a recording makes: those in which nothing stays go with it.
pub(super) struct Made(Vec<PathBuf>);

impl Made {
    /// Those that the files of a plan want and that do not exist yet.
    pub fn by(plan: &Plan) -> Made {
        let files = plan.recording.iter().chain([&plan.before_trip]);
        let wanted = |file: &PathBuf| {
            let folders = file.ancestors().skip(1).take_while(|folder| !folder.exists());
            folders.map(Path::to_owned).collect::<Vec<_>>()
        };
        Made(files.flat_map(wanted).filter(|folder| folder.file_name().is_some()).collect())
    }
}

impl Drop for Made {
    fn drop(&mut self) {
        // one that holds a file stays
        self.0.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
    }
}

/// Err if a recording to this path would overwrite a file.
pub fn vacant(path: &Path) -> Result<(), RecordError> {
    if !path.is_file() {
        return Ok(());
    }
    Err(RecordError::NotBegun(FileError::of(path)(Error::from_raw_os_error(libc::EEXIST))))
}

/// The path, or with -2, -3, ... the first that does not exist.
pub(super) fn unused(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let numbered = (2..).map(|n: u32| path.with_file_name(format!("{stem}-{n}.csv")));
    let mut all = std::iter::once(path.to_path_buf()).chain(numbered);
    all.find(|path| !path.exists()).unwrap_or_else(|| path.to_path_buf())
}

pub(super) fn create(
    path: &Path,
    plan: &Plan,
    trip: Option<&str>,
) -> Result<BufWriter<File>, FileError> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(FileError::of(folder))?;
    }
    // a device such as /dev/null may be written again
    let there = path.exists() && !path.is_file();
    let file = OpenOptions::new().write(true).create_new(!there).open(path);
    let mut file = BufWriter::new(file.map_err(FileError::of(path))?);
    let mut head = String::new();
    for (key, value) in &plan.meta {
        head += &format!("# {key}: {}\n", value.replace('\n', " "));
    }
    if let Some(why) = trip {
        head += &format!("# trip: {}\n", why.replace('\n', " "));
    }
    head += &format!("{}\n{}\n", plan.columns.names.join(","), plan.columns.units.join(","));
    file.write_all(head.as_bytes()).map_err(FileError::of(path))?;
    Ok(file)
}

pub(super) fn end(mut file: BufWriter<File>, trip: Option<&str>) -> std::io::Result<()> {
    if let Some(why) = trip {
        writeln!(file, "# trip: {why}")?;
    }
    file.flush()
}

/// A row with the shortest digits that read back as the same numbers.
pub(super) fn line(file: &mut BufWriter<File>, row: &[f64]) -> std::io::Result<()> {
    for (k, value) in row.iter().enumerate() {
        let comma = if k == 0 { "" } else { "," };
        if value.abs() >= 1e-4 || *value == 0.0 {
            write!(file, "{comma}{value}")?;
        } else {
            write!(file, "{comma}{value:e}")?;
        }
    }
    writeln!(file)
}
