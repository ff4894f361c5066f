//! Files that take their names only when they are complete.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The path of an unfinished file or folder, beside the one it will be; goes away with its owner.
pub(crate) struct Partial {
    path: PathBuf,
    unfinished: PathBuf,
}

impl Partial {
    /// Nothing is created yet.
    pub(crate) fn beside(path: &Path) -> Self {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(".part");
        Self {
            path: path.to_owned(),
            unfinished: path.with_file_name(name),
        }
    }

    /// What it will be called.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// What it is called until then.
    pub(crate) fn unfinished(&self) -> &Path {
        &self.unfinished
    }

    /// Gives it its name, in place of whatever file had it.
    pub(crate) fn complete(self) -> io::Result<()> {
        fs::rename(&self.unfinished, &self.path)
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        // Once complete, or if it is a folder, there is no such file.
        let _ = fs::remove_file(&self.unfinished);
    }
}
