//! How steep the ground is.

use rayon::prelude::*;
use sandtable_terrain::{TileIndex, TiledRaster};

/// How steep the ground is at most, along a row of posts, eastwards, and along a column, northwards:
/// metres a cell.
#[derive(Clone)]
pub(super) struct Steepness {
    /// Of each tile, in the order of the ground's tiles.
    tiles: Vec<[f32; 2]>,
}

impl Steepness {
    /// Of all tiles of `heights`, in parallel.
    pub(super) fn new(heights: &TiledRaster<f32>) -> Self {
        let indices: Vec<_> = heights.tile_indices().collect();
        Self {
            tiles: indices
                .into_par_iter()
                .map(|index| Self::of_tile(heights, index))
                .collect(),
        }
    }

    /// With the `changed` tiles looked at anew.
    pub(super) fn updated(&self, heights: &TiledRaster<f32>, changed: &[TileIndex]) -> Self {
        let mut result = self.clone();
        let across = heights.tiles_across();
        for &index in changed {
            let slot = (index.row * across + index.col) as usize;
            if let Some(tile) = result.tiles.get_mut(slot) {
                *tile = Self::of_tile(heights, index);
            }
        }
        result
    }

    /// Anywhere.
    pub(super) fn steepest(&self) -> [f32; 2] {
        let greater = |a: [f32; 2], b: &[f32; 2]| [a[0].max(b[0]), a[1].max(b[1])];
        self.tiles.iter().fold([0.0; 2], greater)
    }

    fn of_tile(heights: &TiledRaster<f32>, index: TileIndex) -> [f32; 2] {
        let stride = heights.tile_stride();
        let posts = heights.tile_posts(index);
        let mut steepest = [0.0_f32; 2];
        for row in posts.chunks_exact(stride) {
            for pair in row.windows(2) {
                steepest[0] = steepest[0].max((pair[1] - pair[0]).abs());
            }
        }
        for (south, north) in posts.iter().zip(&posts[stride..]) {
            steepest[1] = steepest[1].max((north - south).abs());
        }
        steepest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use sandtable_terrain::Ground;

    #[test]
    fn an_edit_is_followed() {
        let rough = |col: u32, row: u32| ((col * 37 + row * 91) % 113) as f32 * 1.7 - 40.0;
        let before = Ground::from_fn(300, 270, DVec2::ONE, rough).expect("a sound grid");
        let edited = before.edited(250..258, 100..103, |_, _, height| height + 35.0);
        let (after, changed) = edited.expect("finite");
        let steepness = Steepness::new(before.heights()).updated(after.heights(), &changed);
        assert_eq!(
            steepness.steepest(),
            Steepness::new(after.heights()).steepest()
        );
        assert!(steepness.steepest()[0] > Steepness::new(before.heights()).steepest()[0]);
    }
}
