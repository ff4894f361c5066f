//! From the command line's words to a scene: terrain, photograph and caster.

use crate::cli::TerrainArgs;
use crate::exit::usage;
use anyhow::Result;
use sandtable_cast::{CASTERS, Caster, Scene, caster_by_name};
use sandtable_terrain::{Terrain, TerrainSource};
use std::sync::Arc;

impl TerrainArgs {
    /// The terrain's name, as it was given or the default one's.
    pub(crate) fn source(&self) -> &str {
        self.terrain.as_deref().unwrap_or("builtin:jacksboro")
    }
}

/// A terrain that stands as a scene.
pub(crate) struct OpenScene {
    /// What people call the terrain.
    pub(crate) name: String,
    /// What casters see.
    pub(crate) scene: Arc<Scene>,
    /// How the world relates to the terrain's coordinate system.
    pub(crate) georeference: sandtable_terrain::Georeference,
}

/// Opens the terrain that `args` name, and says what was noteworthy about it.
pub(crate) fn open(args: &TerrainArgs) -> Result<OpenScene> {
    let source: TerrainSource = args.source().parse().map_err(usage)?;
    let Terrain {
        name,
        ground,
        georeference,
        notes,
    } = sandtable_terrain::open(&source, args.photo.as_deref())?;
    for note in notes {
        tracing::info!("{note}");
    }
    Ok(OpenScene {
        name,
        scene: Scene::new(ground),
        georeference,
    })
}

/// The caster of that name.
pub(crate) fn caster(name: &str) -> Result<&'static dyn Caster> {
    caster_by_name(name).ok_or_else(|| {
        let known: Vec<_> = CASTERS.iter().map(|caster| caster.name()).collect();
        usage(format!(
            "no caster is called {name:?}: use {}",
            known.join(" or ")
        ))
    })
}
