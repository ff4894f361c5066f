//! Files that a rig names, and where they are.

use std::collections::BTreeMap;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::{Component, Path};

/// The most that such a file may have, in bytes: thrice the largest correction that is fitted.
const LIMIT: u64 = 4 << 20;

/// Where the files are that a text names.
#[derive(Clone, Copy)]
pub(crate) enum Beside<'a> {
    /// In the text's own folder.
    Folder(&'a Path),
    /// They came with the text, by the names that it has for them.
    Texts(&'a BTreeMap<String, String>),
    /// The same, in a recording: what the text says was done.
    Recorded(&'a BTreeMap<String, String>),
    /// Nobody asks what is in them.
    Unread,
}

impl Beside<'_> {
    /// What is in the file that the text calls `name`; none where nobody asks.
    pub(crate) fn read(self, name: &str) -> Result<Option<String>> {
        match self {
            Self::Folder(folder) => read(&folder.join(name)).map(Some),
            Self::Texts(texts) | Self::Recorded(texts) => match texts.get(name) {
                Some(text) => Ok(Some(text.clone())),
                None => Err(Error::new(
                    ErrorKind::NotFound,
                    "it did not come with the rig's text",
                )),
            },
            Self::Unread => Ok(None),
        }
    }
}

fn read(path: &Path) -> Result<String> {
    // A pipe would be waited for without end.
    if !path.metadata()?.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is no plain file"));
    }
    let mut text = String::new();
    let size = std::fs::File::open(path)?
        .take(LIMIT + 1)
        .read_to_string(&mut text)?;
    if size as u64 > LIMIT {
        let problem = format!("it has more than {LIMIT} bytes");
        return Err(Error::new(ErrorKind::InvalidData, problem));
    }
    Ok(text)
}

/// Whether a name leads to the text's folder or below it, on any computer that it is copied to.
pub(crate) fn is_beside(name: &str) -> bool {
    let plain = |part| matches!(part, Component::Normal(_));
    !name.is_empty()
        && !name.contains(|c: char| c.is_control() || c == '\\' || c == ':')
        && Path::new(name).components().all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_below_the_rigs_folder() {
        for good in ["lab.flock-field.toml", "fields/a.toml", "ä b.toml"] {
            assert!(is_beside(good), "{good}");
        }
        for bad in [
            "",
            "/etc/passwd",
            "../a.toml",
            "a/../../b",
            ".",
            "C:\\a",
            "C:a",
            "a\n",
        ] {
            assert!(!is_beside(bad), "{bad}");
        }
    }
}
