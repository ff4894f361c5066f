//! Accurate casting of a volume of densities (papers' rows W4, W5).

use crate::voxels::{Search, VoxelCaster, VoxelOptions};
use crate::{CastError, Caster, PreparedScene, Scene};
use std::sync::Arc;

/// Equidistant samples along the true 3D ray; the density is interpolated between eight voxels, in
/// boundary cells only, and a ray ends at the first sample above the threshold. A ray begins at the
/// distance at which the one below it ended, and retraces where that is inside the terrain already
/// (Wan, Qu and Kaufman, Virtual flythrough over a voxel-based terrain, 1999).
///
/// Known error: a hit lies up to one interval behind the surface, what is thinner than an interval
/// may be stepped over, and coherence along image columns misses what the ray below has passed
/// already where columns do not lie in vertical planes: mostly under roll.
#[derive(Clone, Copy, Debug)]
pub struct Volume(pub VoxelOptions);

impl Caster for Volume {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        let caster = VoxelCaster {
            name: "volume",
            options: self.0,
            interpolates: true,
            search: Search::Coherent,
            rolled_lines: false,
        };
        caster.prepare(scene)
    }
}
