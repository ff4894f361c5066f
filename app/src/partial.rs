//! Files that take their names only when they are complete.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The path of an unfinished file or folder, beside the one it will be; goes away with its owner.
///
/// A link stays one: what it leads to is replaced. A device or a pipe is written as it is.
pub(crate) struct Partial {
    path: PathBuf,
    unfinished: PathBuf,
}

impl Partial {
    /// Nothing is created yet.
    pub(crate) fn beside(path: &Path) -> Self {
        let path = behind_links(path);
        let unfinished = if is_special(&path) {
            path.clone()
        } else {
            let mut name = path.file_name().unwrap_or_default().to_owned();
            name.push(".part");
            path.with_file_name(name)
        };
        Self { path, unfinished }
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
        if self.unfinished == self.path {
            return Ok(());
        }
        fs::rename(&self.unfinished, &self.path)
    }
}

/// Where a link leads, whether anything is there or not.
pub(crate) fn behind_links(path: &Path) -> PathBuf {
    /// As many as systems follow.
    const MOST: usize = 40;
    let mut path = path.to_owned();
    for _ in 0..MOST {
        let Ok(target) = fs::read_link(&path) else {
            break;
        };
        path = path.parent().unwrap_or(Path::new("")).join(target);
    }
    path
}

/// Whether there is something that is neither a file nor a folder, which no file may replace.
fn is_special(path: &Path) -> bool {
    path.metadata()
        .is_ok_and(|there| !there.is_file() && !there.is_dir())
}

impl Drop for Partial {
    fn drop(&mut self) {
        if self.unfinished != self.path {
            // Once complete, or if it is a folder, there is no such file.
            let _ = fs::remove_file(&self.unfinished);
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{FileTypeExt, symlink};

    fn write(path: &Path, text: &str) {
        let partial = Partial::beside(path);
        fs::write(partial.unfinished(), text).expect("a folder to write in");
        partial.complete().expect("the same folder");
    }

    #[test]
    fn what_a_link_leads_to_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("more")).unwrap();
        fs::write(path("more/old"), "old").unwrap();
        symlink("more/old", path("link")).unwrap();
        symlink("link", path("again")).unwrap();
        symlink("more/new", path("to-new")).unwrap();
        write(&path("again"), "one");
        write(&path("to-new"), "two");
        assert!(path("link").is_symlink() && path("again").is_symlink());
        assert_eq!(fs::read_to_string(path("more/old")).unwrap(), "one");
        assert_eq!(fs::read_to_string(path("more/new")).unwrap(), "two");
        assert_eq!(fs::read_dir(path("more")).unwrap().count(), 2);
    }

    #[test]
    fn a_pipe_stays_one() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RWXU).unwrap();
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read_to_string(pipe).unwrap()
        });
        write(&pipe, "through");
        assert_eq!(reader.join().unwrap(), "through");
        drop(Partial::beside(&pipe));
        assert!(pipe.metadata().unwrap().file_type().is_fifo());
        write(Path::new("/dev/null"), "nothing");
        assert!(
            Path::new("/dev/null")
                .metadata()
                .unwrap()
                .file_type()
                .is_char_device()
        );
    }
}
