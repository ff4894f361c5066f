//! Names of terrains: a file, or `builtin:NAME?size=N&seed=S`.

use std::ffi::OsStr;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Largest side of `builtin:ridges`, in posts.
pub const MAX_RIDGES_SIZE: u32 = 16_385;
const DEFAULT_RIDGES_SIZE: u32 = 1025;
const PREFIX: &str = "builtin:";

/// Where a terrain comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TerrainSource {
    /// A DEM file, read as it is.
    File(PathBuf),
    /// `builtin:ridges`: procedural mountains with an eroded look.
    Ridges {
        /// Posts along each side, 2 to [`MAX_RIDGES_SIZE`].
        size: u32,
        /// Another seed gives other mountains.
        seed: u64,
    },
    /// `builtin:jacksboro`: the Jacksboro Fault, Tennessee, from SRTM.
    Jacksboro,
}

/// Why a name names no terrain.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SourceError {
    /// No such built-in terrain.
    #[error("there is no builtin terrain {0:?}; there are builtin:ridges and builtin:jacksboro")]
    UnknownName(String),
    /// The built-in terrain has no such setting.
    #[error("builtin:{name} has no setting {key:?}; {allowed}")]
    UnknownKey {
        /// The built-in terrain.
        name: &'static str,
        /// What was written.
        key: String,
        /// What may be written.
        allowed: &'static str,
    },
    /// A setting's value is out of bounds or no number.
    #[error("builtin:{name}: {key}={value:?} is not right; {key} is {allowed}")]
    BadValue {
        /// The built-in terrain.
        name: &'static str,
        /// The setting.
        key: String,
        /// What was written.
        value: String,
        /// What may be written.
        allowed: String,
    },
    /// Nothing was named.
    #[error("no terrain is named; give a DEM file, builtin:ridges or builtin:jacksboro")]
    Empty,
}

impl TerrainSource {
    /// As [`FromStr`], for names as the operating system has them: a file's need not be Unicode.
    ///
    /// # Errors
    /// [`SourceError`], which names what is wrong.
    pub fn named(name: &OsStr) -> Result<Self, SourceError> {
        match name.to_str() {
            Some(text) => text.parse(),
            None if Self::is_builtin(name) => name.to_string_lossy().parse(),
            None => Ok(Self::File(name.into())),
        }
    }

    /// Whether a name is a built-in terrain's, be there such a one or not.
    #[must_use]
    pub fn is_builtin(name: &OsStr) -> bool {
        name.as_encoded_bytes().starts_with(PREFIX.as_bytes())
    }
}

impl FromStr for TerrainSource {
    type Err = SourceError;

    fn from_str(text: &str) -> Result<Self, SourceError> {
        if text.is_empty() {
            return Err(SourceError::Empty);
        }
        let Some(builtin) = text.strip_prefix(PREFIX) else {
            return Ok(Self::File(text.into()));
        };
        let (name, settings) = builtin.split_once('?').unwrap_or((builtin, ""));
        let settings = settings
            .split('&')
            .filter(|setting| !setting.is_empty())
            .map(|setting| setting.split_once('=').unwrap_or((setting, "")));
        match name {
            "ridges" => ridges(settings),
            "jacksboro" => match { settings }.next() {
                None => Ok(Self::Jacksboro),
                Some((key, _)) => Err(SourceError::UnknownKey {
                    name: "jacksboro",
                    key: key.to_owned(),
                    allowed: "it has none",
                }),
            },
            other => Err(SourceError::UnknownName(other.to_owned())),
        }
    }
}

fn ridges<'a>(
    settings: impl Iterator<Item = (&'a str, &'a str)>,
) -> Result<TerrainSource, SourceError> {
    let (mut size, mut seed) = (DEFAULT_RIDGES_SIZE, 0);
    for (key, value) in settings {
        let bad = |allowed: String| SourceError::BadValue {
            name: "ridges",
            key: key.to_owned(),
            value: value.to_owned(),
            allowed,
        };
        match key {
            "size" => {
                size = value
                    .parse()
                    .ok()
                    .filter(|size| (2..=MAX_RIDGES_SIZE).contains(size))
                    .ok_or_else(|| {
                        bad(format!(
                            "a whole number of posts from 2 to {MAX_RIDGES_SIZE}"
                        ))
                    })?;
            }
            "seed" => {
                seed = value
                    .parse()
                    .map_err(|_| bad(format!("a whole number from 0 to {}", u64::MAX)))?;
            }
            _ => {
                return Err(SourceError::UnknownKey {
                    name: "ridges",
                    key: key.to_owned(),
                    allowed: "it has size (posts a side) and seed",
                });
            }
        }
    }
    Ok(TerrainSource::Ridges { size, seed })
}

impl fmt::Display for TerrainSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => path.display().fmt(f),
            Self::Ridges { size, seed } => write!(f, "{PREFIX}ridges?size={size}&seed={seed}"),
            Self::Jacksboro => write!(f, "{PREFIX}jacksboro"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_read_and_written_is_the_same() {
        for text in [
            "builtin:ridges?size=4097&seed=7",
            "builtin:jacksboro",
            "dir/N42E001.hgt",
        ] {
            assert_eq!(text.parse::<TerrainSource>().unwrap().to_string(), text);
        }
        assert_eq!(
            "builtin:ridges".parse(),
            Ok(TerrainSource::Ridges {
                size: 1025,
                seed: 0
            })
        );
    }

    #[test]
    fn each_wrong_part_is_named_with_what_is_right() {
        for (text, parts) in [
            ("builtin:alps", ["alps", "builtin:ridges"]),
            ("builtin:ridges?sise=5", ["sise", "size"]),
            ("builtin:ridges?size=1", ["\"1\"", "2 to 16385"]),
            ("builtin:ridges?size=99999", ["99999", "2 to 16385"]),
            ("builtin:ridges?size", ["\"\"", "2 to 16385"]),
            ("builtin:ridges?seed=-1", ["-1", "from 0"]),
            ("builtin:jacksboro?size=5", ["size", "none"]),
            ("", ["no terrain", "builtin:"]),
        ] {
            let error = text.parse::<TerrainSource>().unwrap_err().to_string();
            for part in parts {
                assert!(error.contains(part), "{text}: {error}");
            }
        }
    }
}
