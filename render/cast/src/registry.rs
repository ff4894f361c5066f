//! All casters by their names.

use crate::options::Options;
use crate::voxels::{VOXEL_OPTIONS, VoxelOptions};
use crate::{
    Boundary, Brute, CastError, Caster, CasterOption, Coherent, Conventional, FloatingHorizon,
    Inclined, Multiresolution, Planes, RollLines, Volume, floating_horizon, inclined,
};
use std::sync::Arc;

/// A caster as people choose it.
pub struct CasterKind {
    /// The name by which users ask for it.
    pub name: &'static str,
    /// One line for help texts: what it does and how exact it is.
    pub summary: &'static str,
    /// What can be set.
    pub options: &'static [CasterOption],
    build: fn(&Options<'_>) -> Result<Arc<dyn Caster>, CastError>,
}

impl CasterKind {
    /// The caster with its default options.
    #[must_use]
    pub fn by_default(&self) -> Arc<dyn Caster> {
        self.with_options("").expect("defaults are sound")
    }

    /// The caster with `options`, written `key=value&key=value`.
    ///
    /// # Errors
    /// Where there is no such option or value.
    pub fn with_options(&self, options: &str) -> Result<Arc<dyn Caster>, CastError> {
        (self.build)(&Options::parse(self.name, self.options, options)?)
    }
}

/// All casters, the default one first.
pub static CASTERS: [CasterKind; 12] = [
    CasterKind {
        name: "planes",
        summary: "along vertical planes away from the nadir: exact for any eye and \
                  window, and fast",
        options: &Planes::OPTIONS,
        build: |options| Ok(Arc::new(Planes::read(options)?)),
    },
    CasterKind {
        name: "coherent",
        summary: "each column from its bottom up, starting at the last hit, with retracing: for \
                  level views",
        options: &[],
        build: |_| Ok(Arc::new(Coherent)),
    },
    CasterKind {
        name: "volume",
        summary: "3D samples of a volume of densities, coherent along columns, with retracing",
        options: &VOXEL_OPTIONS,
        build: |options| Ok(Arc::new(Volume(VoxelOptions::FILTERED.read(options)?))),
    },
    CasterKind {
        name: "boundary",
        summary: "volume's samples, ending at the first boundary cell: fast and approximate",
        options: &VOXEL_OPTIONS,
        build: |options| Ok(Arc::new(Boundary(VoxelOptions::BINARY.read(options)?))),
    },
    CasterKind {
        name: "conventional",
        summary: "volume's samples, each ray from the eye: the standard without coherence",
        options: &Conventional::OPTIONS,
        build: |options| Ok(Arc::new(Conventional::read(options)?)),
    },
    CasterKind {
        name: "roll-lines",
        summary: "volume, coherent along pixel lines that follow the roll",
        options: &VOXEL_OPTIONS,
        build: |options| Ok(Arc::new(RollLines(VoxelOptions::FILTERED.read(options)?))),
    },
    CasterKind {
        name: Multiresolution::NAME,
        summary: "grid lines in doubling steps over a pyramid, blended levels: level rows only",
        options: &Multiresolution::OPTIONS,
        build: |options| Ok(Arc::new(Multiresolution::read(options)?)),
    },
    CasterKind {
        name: "brute",
        summary: "each pixel alone, first intersection with the solid terrain in f64: exact and \
                  slow",
        options: &[],
        build: |_| Ok(Arc::new(Brute)),
    },
    CasterKind {
        name: "floating-horizon",
        summary: "each column from its bottom up over slices parallel to the screen, to within a \
                  cell: for upright windows",
        options: &floating_horizon::OPTIONS,
        build: |options| Ok(Arc::new(FloatingHorizon::from_options(options)?)),
    },
    CasterKind {
        name: "inclined-naive",
        summary: "slices, each column taken for a vertical plane: bends inclined views, for \
                  comparison",
        options: &inclined::OPTIONS,
        build: |options| Ok(Arc::new(Inclined::naive(options)?)),
    },
    CasterKind {
        name: "inclined",
        summary: "slices, columns' planes met at the lowest height: higher ground is shifted, \
                  vertical lines stay vertical",
        options: &inclined::OPTIONS,
        build: |options| Ok(Arc::new(Inclined::on_base_plane(options)?)),
    },
    CasterKind {
        name: "inclined-corrected",
        summary: "slices, columns' planes met at each ray's height: for level rows at any \
                  inclination, table tops too",
        options: &inclined::OPTIONS,
        build: |options| Ok(Arc::new(Inclined::corrected(options)?)),
    },
];

/// The caster of that name.
#[must_use]
pub fn caster_kind(name: &str) -> Option<&'static CasterKind> {
    CASTERS.iter().find(|kind| kind.name == name)
}

/// The caster that `text` asks for: a name, or `name?key=value&key=value`.
///
/// # Errors
/// Where there is no such caster, option or value.
pub fn caster_by_name(text: &str) -> Result<Arc<dyn Caster>, CastError> {
    let (name, options) = text.split_once('?').unwrap_or((text, ""));
    let kind = caster_kind(name).ok_or_else(|| CastError::UnknownCaster {
        name: name.to_owned(),
        known: CASTERS
            .iter()
            .map(|kind| kind.name)
            .collect::<Vec<_>>()
            .join(", "),
    })?;
    kind.with_options(options)
}
