//! From the command line's words to a scene: terrain, photograph and caster.

use crate::cli::TerrainArgs;
use crate::exit::usage;
use anyhow::Result;
use sandtable_cast::{Caster, Scene, caster_by_name};
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

/// A caster, and the words that asked for it.
#[derive(Clone)]
pub(crate) struct ChosenCaster {
    /// Its name, with its options as they were given.
    pub(crate) name: String,
    /// The caster.
    pub(crate) caster: Arc<dyn Caster>,
}

/// The caster that `name` asks for: a name, or `name?key=value&key=value`.
pub(crate) fn caster(name: &str) -> Result<ChosenCaster> {
    let caster = caster_by_name(name).map_err(usage)?;
    let name = name.to_owned();
    Ok(ChosenCaster { name, caster })
}
