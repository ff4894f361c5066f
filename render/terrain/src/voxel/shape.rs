//! Where the slices of a voxel volume lie.

use super::VoxelError;
use crate::Ground;

/// Fewest slices of a volume: one step of relief between the margins.
pub const MIN_LEVELS: u32 = 8;
/// Most slices of a volume.
pub const MAX_LEVELS: u32 = 1024;
/// The lowest level at which a surface is held. Ground that an edit lowers farther lies here.
pub const LOWEST_LEVEL: i32 = -2048;
/// The highest level at which a surface is held. Ground that an edit raises farther lies here.
pub const HIGHEST_LEVEL: i32 = 4096;

/// Slices below the lowest and above the highest height, for filters to fade in.
const MARGIN: u32 = 3;
/// Most slices that [`VoxelShape::cubic`] makes.
const MAX_CUBIC_LEVELS: u32 = 1022;

/// The slices of a volume: voxel (`col`, `row`, `level`) stands at post (`col`, `row`), at
/// z = `base` + `level` · `height` in world metres.
///
/// Cell (`col`, `row`, `level`) lies between slices `level` and `level` + 1. Levels are counted
/// in `i32`: they are below 0 or past `levels` where an edit leaves the range that the shape was
/// made for. A surface is held from [`LOWEST_LEVEL`] to [`HIGHEST_LEVEL`], and an edit that goes
/// farther is cut off there; make a new shape for such a ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelShape {
    /// Height of slice 0, world metres.
    pub base: f64,
    /// Metres from slice to slice, above 0.
    pub height: f64,
    /// Number of slices.
    pub levels: u32,
}

impl VoxelShape {
    /// Slices as far apart as a cell is long, over the ground's range and a margin of three
    /// slices at both ends; farther apart where that would make more than 1022 slices.
    #[must_use]
    pub fn cubic(ground: &Ground) -> Self {
        let [low, high] = ground.range().map(f64::from);
        let most = f64::from(MAX_CUBIC_LEVELS - 1 - 2 * MARGIN);
        let height = distinct(ground, ground.grid().cell_length().max((high - low) / most));
        let steps = ((high - low) / height).ceil().clamp(1.0, most);
        Self {
            base: low - f64::from(MARGIN) * height,
            height,
            levels: steps as u32 + 1 + 2 * MARGIN,
        }
    }

    /// Exactly `levels` slices over the ground's range, three of them below the lowest and three
    /// above the highest height. On a plane they lie a cell's length apart.
    ///
    /// # Errors
    /// [`VoxelError::Levels`] for fewer than [`MIN_LEVELS`] or more than [`MAX_LEVELS`].
    pub fn with_levels(ground: &Ground, levels: u32) -> Result<Self, VoxelError> {
        if !(MIN_LEVELS..=MAX_LEVELS).contains(&levels) {
            return Err(VoxelError::Levels(levels));
        }
        let [low, high] = ground.range().map(f64::from);
        let height = if high > low {
            (high - low) / f64::from(levels - 1 - 2 * MARGIN)
        } else {
            ground.grid().cell_length()
        };
        let height = distinct(ground, height);
        Ok(Self {
            base: low - f64::from(MARGIN) * height,
            height,
            levels,
        })
    }

    /// The height of a slice, world metres.
    #[inline]
    #[must_use]
    pub fn z(&self, level: i32) -> f64 {
        self.base + f64::from(level) * self.height
    }

    /// The level at a height in world metres, with its fraction.
    #[inline]
    #[must_use]
    pub fn level_at(&self, z: f64) -> f64 {
        (z - self.base) / self.height
    }

    /// The lowest level whose voxel is not below a surface at `height` metres (z ≥ height), from
    /// [`LOWEST_LEVEL`] to [`HIGHEST_LEVEL`].
    #[inline]
    #[must_use]
    pub fn first_above(&self, height: f32) -> i32 {
        let height = f64::from(height);
        let level = self
            .level_at(height)
            .ceil()
            .clamp(f64::from(LOWEST_LEVEL), f64::from(HIGHEST_LEVEL)) as i32;
        // The quotient is rounded; what counts is the slices' own heights.
        if level > LOWEST_LEVEL && self.z(level - 1) >= height {
            level - 1
        } else if level < HIGHEST_LEVEL && self.z(level) < height {
            level + 1
        } else {
            level
        }
    }

    pub(super) fn check(self) -> Result<Self, VoxelError> {
        let Self {
            base,
            height,
            levels,
        } = self;
        if !(MIN_LEVELS..=MAX_LEVELS).contains(&levels) {
            return Err(VoxelError::Levels(levels));
        }
        if !(base.is_finite() && height.is_finite() && height > 0.0) {
            return Err(VoxelError::Slices { base, height });
        }
        Ok(self)
    }
}

/// `height` metres between slices, held to where slices at the ground's heights are distinct and
/// finite numbers.
fn distinct(ground: &Ground, height: f64) -> f64 {
    let [low, high] = ground.range().map(|height| f64::from(height).abs());
    let finest = (low.max(high) * 2.0_f64.powi(-40)).max(f64::MIN_POSITIVE);
    height.clamp(finest, 1e40)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn ground(heights: [f32; 4], spacing: f64) -> Ground {
        Ground::from_fn(2, 2, DVec2::splat(spacing), |col, row| {
            heights[(2 * row + col) as usize]
        })
        .unwrap()
    }

    #[test]
    fn cubic_slices_are_a_cell_apart_with_three_to_spare_at_both_ends() {
        let shape = VoxelShape::cubic(&ground([10.0, 12.0, 20.0, 30.5], 2.0));
        assert_eq!(shape.height, 2.0);
        assert_eq!(shape.z(3), 10.0);
        let top = shape.levels as i32 - 1;
        assert!(shape.z(top - 3) >= 30.5 && shape.z(top - 4) < 30.5);
    }

    #[test]
    fn a_spike_gets_taller_voxels_rather_than_more_of_them() {
        let shape = VoxelShape::cubic(&ground([0.0, 0.0, 0.0, 1e6], 1.0));
        assert_eq!(shape.levels, 1022);
        assert!((shape.height - 1e6 / 1015.0).abs() < 1e-6);
    }

    #[test]
    fn with_levels_has_the_margin_inside_and_refuses_what_leaves_no_room() {
        let ground = ground([100.0, 200.0, 150.0, 157.0], 30.0);
        let shape = VoxelShape::with_levels(&ground, 64).unwrap();
        assert_eq!(shape.levels, 64);
        assert!((shape.z(3) - 100.0).abs() < 1e-9 && (shape.z(60) - 200.0).abs() < 1e-9);
        assert!(VoxelShape::with_levels(&ground, 8).is_ok());
        for levels in [0, 7, 1025, u32::MAX] {
            let error = VoxelShape::with_levels(&ground, levels).unwrap_err();
            assert_eq!(error, VoxelError::Levels(levels));
        }
    }

    #[test]
    fn grounds_of_any_size_have_distinct_slices() {
        let planes = [0.0, 1e30, -3e38, 1e-40].map(|height| [height; 4]);
        let others = [[-3e38, 3e38, 0.0, 0.0], [1e30, 1.000_001e30, 1e30, 1e30]];
        for heights in planes.into_iter().chain(others) {
            for spacing in [f64::MIN_POSITIVE, 1.0, f64::MAX] {
                let ground = ground(heights, spacing);
                for shape in [
                    VoxelShape::cubic(&ground),
                    VoxelShape::with_levels(&ground, 8).unwrap(),
                ] {
                    assert_eq!(shape.check(), Ok(shape));
                    assert!((1..shape.levels as i32).all(|l| shape.z(l) > shape.z(l - 1)));
                }
            }
        }
    }

    #[test]
    fn the_first_level_above_is_that_of_the_slices_own_heights() {
        let shape = VoxelShape {
            base: -0.3,
            height: 0.1,
            levels: 64,
        };
        for level in -2000..4000 {
            let near = shape.z(level) as f32;
            for height in [near.next_down(), near, near.next_up()] {
                let first = shape.first_above(height);
                assert!(shape.z(first) >= f64::from(height));
                assert!(shape.z(first - 1) < f64::from(height));
            }
        }
        assert_eq!(shape.first_above(1e30), HIGHEST_LEVEL);
        assert_eq!(shape.first_above(-1e30), LOWEST_LEVEL);
    }
}
