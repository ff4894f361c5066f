//! From the command line's words to a scene: terrain, photograph and caster.

use crate::cli::{OnOff, TerrainArgs};
use crate::exit::usage;
use anyhow::Result;
use sandtable_cast::{CASTERS, Caster, CasterKind, Planes, Scene, caster_by_name, caster_kind};
use sandtable_terrain::{Terrain, TerrainSource};
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;

impl TerrainArgs {
    /// The terrain's name, as it was given or the default one's.
    pub(crate) fn source(&self) -> &OsStr {
        let default = || OsStr::new("builtin:jacksboro");
        self.terrain.as_deref().unwrap_or_else(default)
    }

    /// The files that are read, each with what it is.
    pub(crate) fn files(&self) -> [(&'static str, Option<&Path>); 2] {
        let is_file = !TerrainSource::is_builtin(self.source());
        [
            ("the terrain", is_file.then_some(Path::new(self.source()))),
            ("the photo", self.photo.as_deref()),
        ]
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
    let source = TerrainSource::named(args.source()).map_err(usage)?;
    if let Some(word @ ("on" | "off")) = args.source().to_str()
        && !Path::new(word).exists()
    {
        return Err(usage(format_args!(
            "there is no terrain {word:?}; if it was meant for --lod, write --lod={word}"
        )));
    }
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

/// The casters that people choose among, and what they do: each with its default options, and the
/// default one with level of detail too.
pub(crate) fn caster_choices() -> impl Iterator<Item = (&'static str, &'static str)> {
    let with_detail = |(index, kind): (usize, &CasterKind)| {
        let summary = "heights and colours at the resolution of what a pixel covers: calm, and fast \
                       over large terrains";
        let detail = (index == 0).then_some((Planes::WITH_DETAIL, summary));
        std::iter::once((kind.name, kind.summary)).chain(detail)
    };
    CASTERS.iter().enumerate().flat_map(with_detail)
}

/// The caster that `name` asks for, with or without level of detail where that is said, or else
/// with it if `by_default` and the caster can.
pub(crate) fn caster_at_detail(
    name: &str,
    lod: Option<OnOff>,
    by_default: bool,
) -> Result<ChosenCaster> {
    let (kind, options) = name.split_once('?').unwrap_or((name, ""));
    let can = caster_kind(kind)
        .is_some_and(|kind| kind.options.iter().any(|option| option.name == "lod"));
    let given = options.split('&').any(|option| option.starts_with("lod"));
    let value = match lod {
        Some(_) if given => {
            return Err(usage(format!(
                "--lod and --caster '{name}' both say which level of detail: leave one of them out"
            )));
        }
        Some(OnOff::On) if !can && caster_kind(kind).is_some() => {
            return Err(usage(format!(
                "the caster {kind} has no level of detail: leave --lod out, or take --caster {}",
                CASTERS[0].name
            )));
        }
        Some(OnOff::On) => "on",
        None if by_default && can && !given => "on",
        _ => return caster(name),
    };
    let separator = if options.is_empty() { "" } else { "&" };
    caster(&format!("{kind}?{options}{separator}lod={value}"))
}

/// The caster that `name` asks for: a name, or `name?key=value&key=value`.
pub(crate) fn caster(name: &str) -> Result<ChosenCaster> {
    let caster = caster_by_name(name).map_err(usage)?;
    let name = name.to_owned();
    Ok(ChosenCaster { name, caster })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_of_detail_is_asked_for_once_and_where_there_is_one() {
        let name = |name, lod, by_default| {
            caster_at_detail(name, lod, by_default)
                .map(|chosen| chosen.name)
                .map_err(|error| error.to_string())
        };
        let (on, off) = (Some(OnOff::On), Some(OnOff::Off));
        assert_eq!(name("planes", on, false), Ok("planes?lod=on".into()));
        assert_eq!(name("planes", None, true), Ok("planes?lod=on".into()));
        assert_eq!(name("planes", off, true), Ok("planes".into()));
        assert_eq!(name("planes", None, false), Ok("planes".into()));
        assert_eq!(
            name("planes?cell=4", on, false),
            Ok("planes?cell=4&lod=on".into())
        );
        assert_eq!(
            name("planes?lod=off", None, true),
            Ok("planes?lod=off".into())
        );
        assert_eq!(name("brute", None, true), Ok("brute".into()));
        assert_eq!(name("brute", off, true), Ok("brute".into()));
        assert!(name("brute", on, false).is_err_and(|error| error.contains("brute has no level")));
        assert!(name("planes?lod=on", on, false).is_err_and(|error| error.contains("both say")));
        assert!(name("fast", on, false).is_err());
    }

    #[test]
    fn each_choice_is_a_caster() {
        for (name, _) in caster_choices() {
            assert!(caster(name).is_ok(), "{name}");
        }
    }
}
