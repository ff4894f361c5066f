//! Real terrain, from files beside the repository.

use super::photo::with_photo;
use anyhow::{Context, Result};
use sandtable_terrain::{Ground, TerrainSource, open};
use std::path::{Path, PathBuf};

/// Scenes and their files in `../shared/data`.
const FILES: [(&str, &str); 2] = [
    ("pyrenees", "pyrenees/N42E001.hgt"),
    ("ruby-range", "ruby-range/ruby_range_10m_nad83_cog.tif"),
];

/// The names of the real scenes.
pub(super) const NAMES: [&str; 2] = [FILES[0].0, FILES[1].0];

/// Where the file of scene `name` would lie, or `None` where there is no such scene.
pub(super) fn file(name: &str) -> Option<PathBuf> {
    let (_, file) = FILES.into_iter().find(|(scene, _)| *scene == name)?;
    // Tests of several crates come here: the repository's root is where the lock file is.
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = here
        .ancestors()
        .find(|dir| dir.join("Cargo.lock").exists())?;
    Some(root.join("../shared/data").join(file))
}

/// The ground in `file` under a photograph of a pixel a post.
pub(super) fn ground(file: &Path) -> Result<Ground> {
    let terrain = open(&TerrainSource::File(file.to_owned()), None)
        .with_context(|| format!("cannot read {}", file.display()))?;
    Ok(with_photo(terrain.ground))
}
