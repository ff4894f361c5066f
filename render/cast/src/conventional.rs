//! Casting every ray from the eye: the rival of coherence (papers' row W10).

use crate::options::{CasterOption, Options};
use crate::voxels::{Search, VOXEL_OPTIONS, VoxelCaster, VoxelOptions};
use crate::{CastError, Caster, PreparedScene, Scene};
use std::sync::Arc;

/// The samples and densities of [`Volume`](crate::Volume), but each ray is sampled anew, as if no
/// other had been cast before (the standard that Wan, Qu and Kaufman 1999 compare with).
///
/// Known error: a hit lies up to one interval behind the surface, and what is thinner than an
/// interval may be stepped over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conventional {
    /// How the ground is sampled.
    pub voxels: VoxelOptions,
    /// Whether the first sample lies at the eye, as in the paper, where that is over the terrain,
    /// or not before the ray enters the volume's bounds: a quicker rival, with the same image.
    pub from_eye: bool,
}

impl Conventional {
    /// What can be set.
    pub(crate) const OPTIONS: [CasterOption; 5] = {
        let [interval, threshold, levels, filter] = VOXEL_OPTIONS;
        let start = CasterOption {
            name: "start",
            meaning: "where rays are sampled from: eye, or volume, the volume's bounds; eye",
        };
        [start, interval, threshold, levels, filter]
    };

    pub(crate) fn read(options: &Options<'_>) -> Result<Self, CastError> {
        Ok(Self {
            voxels: VoxelOptions::FILTERED.read(options)?,
            from_eye: options.choice("start", &[("eye", true), ("volume", false)])?,
        })
    }
}

impl Caster for Conventional {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        let caster = VoxelCaster {
            name: "conventional",
            options: self.voxels,
            interpolates: true,
            search: if self.from_eye {
                Search::FromEye
            } else {
                Search::FromBounds
            },
            rolled_lines: false,
        };
        caster.prepare(scene)
    }
}
