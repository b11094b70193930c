//! Where the FMUs of a system are unpacked: a temporary folder.
//!
//! It is locked while its process lives, and the kernel unlocks it when the process ends, however that
//! may be. So the next one can remove what a killed process left. Removing the files right after they
//! are loaded would be simpler, but FMI lets an FMU read its resources at any time.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::Path;

use tempfile::TempDir;

use crate::error::Error;

/// How the name of every folder begins.
const PREFIX: &str = "flexhex-fmus-";

/// A folder that is removed with this value, or by the next process that makes one.
pub(crate) struct Folder {
    // removed before it is unlocked
    dir: TempDir,
    _lock: File,
}

impl Folder {
    pub fn new() -> Result<Folder, Error> {
        let place = std::env::temp_dir();
        remove_left(&place);
        Folder::below(&place)
            .map_err(|e| Error::new(format!("a temporary folder cannot be created ({e})")))
    }

    fn below(place: &Path) -> io::Result<Folder> {
        loop {
            let dir = TempDir::with_prefix_in(PREFIX, place)?;
            let lock = match File::open(dir.path()) {
                Ok(lock) => lock,
                Err(e) if e.kind() == ErrorKind::NotFound => continue,
                Err(e) => return Err(e),
            };
            // where folders cannot be locked, none is ever removed by another process
            let _ = lock.lock();
            // another process may have taken it for one that was left, before it was locked
            if dir.path().is_dir() {
                return Ok(Folder { dir, _lock: lock });
            }
        }
    }

    pub fn path(&self) -> &Path {
        self.dir.path()
    }
}

/// Removes the folders of processes that live no more, as far as the rights go.
fn remove_left(place: &Path) {
    for entry in fs::read_dir(place).into_iter().flatten().flatten() {
        let ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        // of a link this is not the kind of what it leads to
        if !ours || !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            continue;
        }
        let Ok(lock) = File::open(entry.path()) else { continue };
        if lock.try_lock().is_ok() {
            // what cannot be removed stays
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_no_process_holds_is_removed() {
        let place = TempDir::new().unwrap();
        let held = Folder::below(place.path()).unwrap();
        let [left, other] = [format!("{PREFIX}left"), "flexhex-other".to_owned()]
            .map(|name| place.path().join(name));
        for folder in [&left, &other] {
            fs::create_dir_all(folder.join("0/resources")).unwrap();
        }
        remove_left(place.path());
        assert!(held.path().is_dir() && other.is_dir() && !left.exists());
        let path = held.path().to_owned();
        drop(held);
        assert!(!path.exists());
    }
}
