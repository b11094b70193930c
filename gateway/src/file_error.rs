//! Why a file cannot be read or written: which one, and how to mend it.

use std::fmt::{self, Display, Formatter};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

#[derive(Debug)]
pub struct FileError {
    pub path: PathBuf,
    pub why: io::Error,
}

impl FileError {
    pub fn of(path: &Path) -> impl Fn(io::Error) -> FileError + '_ {
        |why| FileError { path: path.to_owned(), why }
    }
}

impl Display for FileError {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let mend = match self.why.kind() {
            ErrorKind::StorageFull => "free some space, or name a file on another disk",
            ErrorKind::AlreadyExists => {
                "recordings are never overwritten: give another name, or move it away"
            }
            ErrorKind::IsADirectory => "this is a folder: name a file in it",
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                "name a file in a folder that may be written"
            }
            _ => "check the path and its permissions",
        };
        write!(f, "{}: {}: {mend}", self.path.display(), self.why)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_its_remedy() {
        let text = |kind: ErrorKind| FileError::of(Path::new("a.csv"))(kind.into()).to_string();
        assert!(text(ErrorKind::StorageFull).starts_with("a.csv: "));
        assert!(text(ErrorKind::StorageFull).ends_with("another disk"));
        assert!(text(ErrorKind::AlreadyExists).contains("never overwritten"));
        assert!(text(ErrorKind::NotFound).ends_with("check the path and its permissions"));
    }
}
