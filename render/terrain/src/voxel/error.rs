//! Why no voxel model can be made.

use super::{MAX_LEVELS, MAX_SIGMA, MAX_WIDTH, MIN_LEVELS};

/// Why a shape, a filter or a volume of voxels is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum VoxelError {
    /// Too few slices for a surface and the margins of a filter, or more than are counted.
    #[error("a volume of {0} levels cannot be made; ask for {MIN_LEVELS} to {MAX_LEVELS} levels")]
    Levels(u32),
    /// Slices without a place or a distance.
    #[error(
        "voxel slices from {base} m on, {height} m apart, make no volume; the base must be \
         finite, the height finite and above 0: take VoxelShape::cubic or with_levels"
    )]
    Slices {
        /// Height of the lowest slice, metres.
        base: f64,
        /// Metres between slices.
        height: f64,
    },
    /// A Gaussian without a breadth, or a broader one than is meant for voxels.
    #[error(
        "a Gaussian filter of {0} voxels' standard deviation cannot be made; it must be above 0 \
         and at most {MAX_SIGMA}"
    )]
    Sigma(f64),
    /// A box filter without a width, or a wider one than is meant for voxels.
    #[error(
        "an oriented box filter of {0} voxels' width cannot be made; it must be above 0 and at \
         most {MAX_WIDTH}"
    )]
    Width(f64),
}
