//! Zip archives in memory (`.ssp`, `.fmu`), and which of their files go to a folder.

use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;

use zip::result::ZipError;
use zip::ZipArchive;

use crate::error::Error;

/// What an archive may unpack to, and all FMUs of a `.ssp` together, as in `fmus/common/archive.py`.
const MOST_BYTES: u64 = 1 << 30;

/// An archive, named in messages.
pub(crate) struct Archive {
    name: String,
    zip: ZipArchive<Cursor<Vec<u8>>>,
    /// What it unpacks to [bytes], as it declares.
    pub size: u64,
}

impl Archive {
    pub fn open(path: &Path) -> Result<Archive, Error> {
        let name = path.display().to_string();
        let bytes =
            fs::read(path).map_err(|e| Error::new(format!("cannot be read ({e})")).at(&name))?;
        Archive::new(bytes, name)
    }

    pub fn new(bytes: Vec<u8>, name: String) -> Result<Archive, Error> {
        let Ok(mut zip) = ZipArchive::new(Cursor::new(bytes)) else {
            return Err(Error::new("not a zip archive, or a truncated one").at(name));
        };
        let mut size = 0_u64;
        for k in 0..zip.len() {
            size = size.saturating_add(zip.by_index_raw(k).map_or(0, |file| file.size()));
        }
        limited(size).map_err(|e| e.at(&name))?;
        Ok(Archive { name, zip, size })
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn members(&self) -> Vec<String> {
        self.zip.file_names().map(str::to_owned).collect()
    }

    /// One file of the archive.
    pub fn read(&mut self, member: &str) -> Result<Vec<u8>, Error> {
        let mut file = match self.zip.by_name(member) {
            Ok(file) => file,
            Err(ZipError::FileNotFound) => {
                let text = format!("{member} is missing in the archive");
                return Err(Error::new(text).at(&self.name));
            }
            Err(error) => return Err(damaged(member, &error.to_string()).at(&self.name)),
        };
        let mut bytes = Vec::new();
        // no more than the archive declares, whatever it holds
        let declared = file.size();
        match (&mut file).take(declared).read_to_end(&mut bytes) {
            Ok(_) => Ok(bytes),
            Err(error) => Err(damaged(member, &error.to_string()).at(&self.name)),
        }
    }

    /// One file of the archive as text.
    pub fn text(&mut self, member: &str) -> Result<String, Error> {
        let bytes = self.read(member)?;
        String::from_utf8(bytes)
            .map_err(|_| Error::new(format!("{member} is not text in UTF-8")).at(&self.name))
    }

    /// Writes one file below a folder; its name was checked by `enclosed`.
    pub fn extract(&mut self, member: &str, root: &Path) -> Result<(), Error> {
        let target = root.join(member);
        let bytes = self.read(member)?;
        let parent = target.parent().unwrap_or(root);
        fs::create_dir_all(parent)
            .and_then(|()| fs::write(&target, bytes))
            .map_err(|e| Error::new(format!("cannot be written ({e})")).at(target.display()))
    }
}

/// Refuses what unpacks to more than is opened.
pub(crate) fn limited(size: u64) -> Result<(), Error> {
    if size <= MOST_BYTES {
        return Ok(());
    }
    let (size, most) = (size >> 20, MOST_BYTES >> 20);
    Err(Error::new(format!("unpacks to {size} MB, at most {most} MB are opened")))
}

/// Whether a member's name stays below the folder that it is written to.
pub(crate) fn enclosed(member: &str) -> bool {
    !member.starts_with('/') && !member.contains('\\') && member.split('/').all(|p| p != "..")
}

fn damaged(member: &str, reason: &str) -> Error {
    Error::new(format!("{member} is damaged in the archive ({reason})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_zip_is_refused_by_name() {
        let refused = Archive::new(b"PK is not enough".to_vec(), "a.ssp".to_owned());
        let text = refused.err().map(|e| e.to_string());
        assert_eq!(text.as_deref(), Some("a.ssp: not a zip archive, or a truncated one"));
    }

    #[test]
    fn what_unpacks_to_too_much_is_refused_before_it_is_unpacked() {
        // an empty file "a" whose directory declares 4 GB
        let local = b"PK\x03\x04\x0a\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x01\0\0\0a";
        let head = b"PK\x01\x02\x0a\0\x0a\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xfe\xff\xff\xff";
        let tail = b"\x01\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0a";
        let end = b"PK\x05\x06\0\0\0\0\x01\0\x01\0\x2f\0\0\0\x1f\0\0\0\0\0";
        let bytes = [&local[..], &head[..], &tail[..], &end[..]].concat();
        let text = Archive::new(bytes, "a.fmu".to_owned()).err().map(|e| e.to_string());
        assert_eq!(text.as_deref(), Some("a.fmu: unpacks to 4095 MB, at most 1024 MB are opened"));
    }

    #[test]
    fn names_that_leave_the_folder_are_not_enclosed() {
        for name in ["../a", "resources/../../a", "/etc/a", "resources\\..\\a"] {
            assert!(!enclosed(name), "{name}");
        }
        assert!(enclosed("resources/a..b/c.csv"));
    }
}
