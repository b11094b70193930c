//! Writes what a command found as TOML; an older file is kept.

use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::exit::{Ends, Exit};
use crate::file_error::FileError;

#[derive(Debug)]
pub enum SaveError {
    NotToml(toml::ser::Error),
    NotWritten(FileError),
}

impl Display for SaveError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            SaveError::NotToml(why) => write!(f, "nothing is saved: {why}: report this as a bug"),
            SaveError::NotWritten(why) => why.fmt(f),
        }
    }
}

impl Ends for SaveError {
    fn exit(&self) -> Exit {
        Exit::Failed
    }
}

/// Writes the file whole or not at all; an older one is kept beside it as `-old-1`, `-old-2`, ...
pub fn save(path: &Path, head: &str, content: &impl Serialize) -> Result<(), SaveError> {
    let text = toml::to_string(content).map_err(SaveError::NotToml)?;
    let text = format!("# {head}\n{text}");
    let new = beside(path, "new");
    let done = written(&new, &text).and_then(|()| {
        if path.exists() {
            std::fs::rename(path, free(path))?;
        }
        std::fs::rename(&new, path)
    });
    done.map_err(|why| {
        // nothing may stay of a write that failed
        let _ = std::fs::remove_file(&new);
        SaveError::NotWritten(FileError::of(path)(why))
    })
}

fn written(path: &Path, text: &str) -> std::io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}

fn beside(path: &Path, what: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    path.with_file_name(format!("{stem}-{what}.toml"))
}

/// The first name of an old file that does not exist.
fn free(path: &Path) -> PathBuf {
    let old = |n: u32| beside(path, &format!("old-{n}"));
    (1..).map(old).find(|name| !name.exists()).unwrap_or_else(|| old(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn an_older_file_is_kept_and_a_failed_write_changes_nothing() {
        let folder = std::env::temp_dir().join(format!("flexhex-saved-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("h.toml");
        let value = |n: i64| BTreeMap::from([("n", n)]);
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
        for n in 1..4 {
            save(&file, "Head.", &value(n)).unwrap();
        }
        assert_eq!(read("h.toml"), "# Head.\nn = 3\n");
        assert_eq!(
            (read("h-old-1.toml"), read("h-old-2.toml")),
            ("# Head.\nn = 1\n".to_owned(), "# Head.\nn = 2\n".to_owned())
        );
        // the new file cannot be written: its name is that of a folder
        std::fs::create_dir(folder.join("h-new.toml")).unwrap();
        let why = save(&file, "Head.", &value(4)).unwrap_err();
        assert!(why.to_string().contains("h.toml: ") && why.exit() == Exit::Failed, "{why}");
        assert_eq!(read("h.toml"), "# Head.\nn = 3\n");
        assert!(!folder.join("h-old-3.toml").exists());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
