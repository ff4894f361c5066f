//! Approximate casting of boundary cells (papers' row W6).

use crate::voxels::{Search, VoxelCaster, VoxelOptions};
use crate::{CastError, Caster, PreparedScene, Scene};
use std::sync::Arc;

/// The samples of [`Volume`](crate::Volume), but a ray ends at the first one in a boundary cell or
/// below: no density is interpolated, and of the model only the 2D boundary array is kept, which
/// without a filter comes straight from the elevation map (Wan, Qu and Kaufman 1999).
///
/// Known error: a hit lies before the surface by up to a boundary cell's diagonal (of the steepest
/// cell column: its height), so that the ground shows the edges of cells; besides those of
/// [`Volume`](crate::Volume).
#[derive(Clone, Copy, Debug)]
pub struct Boundary(pub VoxelOptions);

impl Caster for Boundary {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        let caster = VoxelCaster {
            name: "boundary",
            options: self.0,
            interpolates: false,
            search: Search::Coherent,
            rolled_lines: false,
        };
        caster.prepare(scene)
    }
}
