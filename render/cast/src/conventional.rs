//! Casting every ray from the eye: the rival of coherence (papers' row W10).

use crate::voxels::{Search, VoxelCaster, VoxelOptions};
use crate::{CastError, Caster, PreparedScene, Scene};
use std::sync::Arc;

/// The samples and densities of [`Volume`](crate::Volume), but each ray is sampled from where it
/// enters the volume's bounds, as if no other had been cast before (the standard that Wan, Qu and
/// Kaufman 1999 compare with).
///
/// Known error: a hit lies up to one interval behind the surface, and what is thinner than an
/// interval may be stepped over.
#[derive(Clone, Copy, Debug)]
pub struct Conventional(pub VoxelOptions);

impl Caster for Conventional {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        let caster = VoxelCaster {
            name: "conventional",
            options: self.0,
            interpolates: true,
            search: Search::FromEye,
            rolled_lines: false,
        };
        caster.prepare(scene)
    }
}
