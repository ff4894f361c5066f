//! Filtered voxelization with an oriented box (Šrámek, Kaufman 1999) of a height field.

use super::column::Run;
use super::{HIGHEST_LEVEL, LOWEST_LEVEL, VoxelShape};
use crate::TiledRaster;
use glam::DVec2;

/// Half the levels over which a density falls at most: one step of 255 a level.
const MAX_HALF_FALL: f64 = 127.5;

/// A box filter over slices and posts.
#[derive(Clone, Copy, Debug)]
pub(super) struct OrientedBox {
    shape: VoxelShape,
    /// Metres over which the density falls along the surface's normal.
    width: f64,
}

impl OrientedBox {
    /// `width` in voxels; posts lie `spacing` metres apart.
    pub(super) fn new(width: f64, shape: VoxelShape, spacing: DVec2) -> Self {
        let voxel = shape.height.min(spacing.min_element());
        Self {
            shape,
            width: width * voxel,
        }
    }

    /// Fills the column of a post at `height` metres where the ground's `slope` is metres a metre
    /// eastwards and northwards.
    pub(super) fn column(&self, height: f32, slope: DVec2, run: &mut Run) {
        let first_above = self.shape.first_above(height);
        let height = f64::from(height);
        // A level's distance to the surface is shorter than its height over it by this root.
        let fall = (self.width * (1.0 + slope.length_squared()).sqrt())
            .min(2.0 * MAX_HALF_FALL * self.shape.height);
        let steps_a_metre = 255.0 / fall;
        let reach = (0.5 * fall / self.shape.height).ceil() as i32 + 1;
        let levels =
            (first_above - reach).max(LOWEST_LEVEL)..(first_above + reach).min(HIGHEST_LEVEL);
        let densities = levels.clone().map(|level| {
            let density = 127.5 - (self.shape.z(level) - height) * steps_a_metre;
            // The conversion saturates.
            let nearest = (density + 0.5) as u8;
            // A half is rounded up, but not where the voxel is on or above the surface.
            if level < first_above {
                nearest
            } else {
                nearest.min(127)
            }
        });
        run.set(levels.start, densities);
    }
}

/// Central differences at a post (one-sided at the border): metres a metre eastwards and
/// northwards.
pub(super) fn slope_at(heights: &TiledRaster<f32>, spacing: DVec2, col: u32, row: u32) -> DVec2 {
    let (west, east) = (col.saturating_sub(1), (col + 1).min(heights.cols() - 1));
    let (south, north) = (row.saturating_sub(1), (row + 1).min(heights.rows() - 1));
    let post = |col, row| f64::from(heights.post(col, row));
    let rise = DVec2::new(
        post(east, row) - post(west, row),
        post(col, north) - post(col, south),
    );
    rise / (DVec2::new(f64::from(east - west), f64::from(north - south)) * spacing)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: VoxelShape = VoxelShape {
        base: 0.0,
        height: 1.0,
        levels: 64,
    };

    fn run(width: f64, height: f32, slope: DVec2) -> Run {
        let mut run = Run::default();
        OrientedBox::new(width, SHAPE, DVec2::ONE).column(height, slope, &mut run);
        run
    }

    #[test]
    fn densities_fall_linearly_with_the_distance_along_the_normal() {
        let level = run(4.0, 10.25, DVec2::ZERO);
        // Distances −1.25, −0.25, 0.75, 1.75 of a half width of 2.
        assert_eq!(
            (level.first, &level.densities[..]),
            (9, &[207, 143, 80, 16][..])
        );
        // At 45° the same densities lie √2 as far apart.
        let steep = run(4.0, 10.0, DVec2::new(1.0, 0.0));
        assert_eq!(steep.first, 8);
        assert_eq!(steep.densities, [218, 173, 127, 82, 37]);
    }

    #[test]
    fn the_half_is_rounded_by_the_side_of_the_surface() {
        for width in [1e-9, 0.5, 1.0, 16.0] {
            for height in [20.0_f32.next_down(), 20.0, 20.0_f32.next_up()] {
                let run = run(width, height, DVec2::ZERO);
                let density = |level: i32| match level - run.first {
                    ..0 => 255,
                    at => run.densities.get(at as usize).copied().unwrap_or(0),
                };
                let first = if height > 20.0 { 21 } else { 20 };
                assert!(
                    density(first) <= 127 && density(first - 1) > 127,
                    "{width} {height}"
                );
            }
        }
    }

    #[test]
    fn walls_and_edits_far_off_stay_within_bounds() {
        for slope in [1e3, 1e300, f64::INFINITY] {
            for height in [0.0, 1e6, -3e38, 3e38] {
                let run = run(16.0, height, DVec2::new(slope, 0.0));
                assert!(run.densities.len() <= 255, "{}", run.densities.len());
                assert!(run.densities.is_sorted_by(|a, b| a >= b));
                let end = run.first + run.densities.len() as i32;
                assert!(run.first >= LOWEST_LEVEL && end <= HIGHEST_LEVEL);
            }
        }
    }
}
