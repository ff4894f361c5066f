//! Coherence along slanted pixel lines, for rolled images (papers' row W8).

use crate::voxels::{Search, VoxelCaster, VoxelOptions};
use crate::{CastError, Caster, PreparedScene, Scene};
use std::sync::Arc;

/// [`Volume`](crate::Volume) along lines of pixels that follow the vertical of the world as it
/// appears in the middle of the image: one Bresenham line as a bit array, shifted, covers the
/// image, and rays are coherent along it under any roll (Wan, Qu and Kaufman 1999).
///
/// Known error: that of [`Volume`](crate::Volume) in a level image. The lines are parallel where
/// verticals converge, and pixels lie up to half a pixel beside the ideal line; retracing repairs
/// the most of it.
#[derive(Clone, Copy, Debug)]
pub struct RollLines(pub VoxelOptions);

impl Caster for RollLines {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        let caster = VoxelCaster {
            name: "roll-lines",
            options: self.0,
            interpolates: true,
            search: Search::Coherent,
            rolled_lines: true,
        };
        caster.prepare(scene)
    }
}
