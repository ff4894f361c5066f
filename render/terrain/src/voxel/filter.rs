//! How densities fade across the surface.

use super::VoxelError;

/// The broadest Gaussian, in voxels.
pub const MAX_SIGMA: f64 = 8.0;
/// The widest oriented box, in voxels.
pub const MAX_WIDTH: f64 = 16.0;

/// How the binary voxels of a ground become densities (Wan, Qu, Kaufman 1999, section 3).
///
/// Whatever the filter, densities never rise from one level to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DensityFilter {
    /// Binary voxels: 255 where a voxel is below the surface (z < height), else 0.
    None,
    /// A Gaussian over the binary voxels in all three directions, cut off at ⌈2.5 σ⌉ voxels.
    /// Beyond the border the outermost columns repeat. It rounds ridges off, so its surface is
    /// not the ground's.
    Gaussian {
        /// Standard deviation in voxels, above 0 and at most [`MAX_SIGMA`].
        sigma: f64,
    },
    /// Filtered voxelization with an oriented box filter (Šrámek, Kaufman 1999): the density
    /// falls linearly with the signed distance to the surface, 255 · (½ − distance / width).
    ///
    /// The distance is that to the plane of the central differences (one-sided at the border)
    /// at the post. A density is above 127 exactly where its voxel is below the surface.
    /// In cubic voxels, trilinear densities of a plane of up to 45° cross 127.5 within 0.02 voxels
    /// of it from a width of 2 on; a narrower box leaves too few densities between 0 and 255. On
    /// walls so steep that the fall would be slower than one step of density a level, it is that.
    OrientedBox {
        /// Width over which the density falls, in voxels, above 0 and at most [`MAX_WIDTH`]. A
        /// voxel as a length is the shorter of cell length and slice distance.
        width: f64,
    },
}

impl DensityFilter {
    pub(super) fn check(self) -> Result<Self, VoxelError> {
        match self {
            // Comparisons are false for NaN.
            Self::Gaussian { sigma } if !(sigma > 0.0 && sigma <= MAX_SIGMA) => {
                Err(VoxelError::Sigma(sigma))
            }
            Self::OrientedBox { width } if !(width > 0.0 && width <= MAX_WIDTH) => {
                Err(VoxelError::Width(width))
            }
            sound => Ok(sound),
        }
    }

    /// How many posts away a height still has a share in a column's densities.
    #[must_use]
    pub fn radius(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Gaussian { sigma } => (2.5 * sigma).ceil() as u32,
            Self::OrientedBox { .. } => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_without_a_sound_size_are_refused() {
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY, 16.1] {
            let gaussian = DensityFilter::Gaussian { sigma: size }.check();
            assert!(matches!(gaussian, Err(VoxelError::Sigma(_))), "{size}");
            let oriented = DensityFilter::OrientedBox { width: size }.check();
            assert!(matches!(oriented, Err(VoxelError::Width(_))), "{size}");
        }
        assert_eq!(DensityFilter::Gaussian { sigma: 1.0 }.radius(), 3);
        assert_eq!(DensityFilter::Gaussian { sigma: 8.0 }.radius(), 20);
    }
}
