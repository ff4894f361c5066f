//! Heights at half the resolution.

use crate::{TILE_CELLS, TileIndex, TiledRaster, reach};

/// Posts along a side at half the resolution of `posts`.
pub(crate) fn half(posts: u32) -> u32 {
    (posts - 1).div_ceil(2) + 1
}

/// The level of half the resolution of `finer`, vertex-centred: post i stands at post 2 i, and is
/// the mean of the posts around it, weighted by [1 2 1] / 4 along each axis; beyond the border the
/// outermost post repeats.
pub(crate) fn halved(finer: &TiledRaster<f32>) -> TiledRaster<f32> {
    TiledRaster::from_rows(half(finer.cols()), half(finer.rows()), means(finer))
}

/// [`halved`] where it was `old`, with these tiles made anew.
pub(crate) fn halved_renewed(
    finer: &TiledRaster<f32>,
    old: &TiledRaster<f32>,
    tiles: &[TileIndex],
) -> TiledRaster<f32> {
    old.with_rows_renewed(tiles, means(finer))
}

/// Fills rows of the coarser level.
fn means(finer: &TiledRaster<f32>) -> impl Fn(u32, u32, &mut [f32]) {
    const LENGTH: usize = 2 * TILE_CELLS as usize + 3;
    move |row, col, into| {
        let mut sum = [0.0; LENGTH];
        let mut posts = [0.0; LENGTH];
        let count = 2 * into.len() + 1;
        for (row, weight) in (2 * i64::from(row) - 1..).zip([0.25, 0.5, 0.25]) {
            let posts = &mut posts[..count];
            finer.copy_row(2 * i64::from(col) - 1, row, posts);
            for (sum, &post) in sum.iter_mut().zip(&*posts) {
                *sum += weight * f64::from(post);
            }
        }
        for (to, around) in into.iter_mut().zip(sum.windows(3).step_by(2)) {
            *to = ((around[0] + around[2]) * 0.25 + around[1] * 0.5) as f32;
        }
    }
}

/// Heights at all resolutions: level 0 is the ground's own, and each further one has half the
/// posts a side.
#[derive(Clone, Debug)]
pub struct HeightPyramid {
    levels: Vec<TiledRaster<f32>>,
}

/// Cells along the longer side of the coarsest level, at most.
const COARSEST: u32 = 16;

impl HeightPyramid {
    /// Builds all levels over `heights`, whose tiles it shares.
    #[must_use]
    pub fn new(heights: &TiledRaster<f32>) -> Self {
        let mut levels = vec![heights.clone()];
        while let Some(finer) = levels.last()
            && finer.cols().max(finer.rows()) > COARSEST + 1
        {
            levels.push(halved(finer));
        }
        Self { levels }
    }

    /// The pyramid after an edit that changed the tiles `changed` of the finest level, and for each
    /// level the tiles that may differ. The others are shared with `self`.
    #[must_use]
    pub fn updated(
        &self,
        heights: &TiledRaster<f32>,
        changed: &[TileIndex],
    ) -> (Self, Vec<Vec<TileIndex>>) {
        let mut levels = vec![heights.clone()];
        let mut reached = vec![changed.to_vec()];
        for (finer, old) in self.levels[1..].iter().enumerate() {
            reached.push(reach::coarser(&reached[finer], old.cols(), old.rows()));
            levels.push(halved_renewed(&levels[finer], old, &reached[finer + 1]));
        }
        (Self { levels }, reached)
    }

    /// The levels, the finest first.
    #[must_use]
    pub fn levels(&self) -> &[TiledRaster<f32>] {
        &self.levels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_stay_planes_inside_and_an_edit_is_followed() {
        let plane = TiledRaster::from_fn(1100, 900, |col, row| (3 * col + 5 * row) as f32);
        let pyramid = HeightPyramid::new(&plane);
        for (level, heights) in pyramid.levels().iter().enumerate() {
            let (x, y) = (heights.cols() / 2, heights.rows() / 2);
            assert_eq!(heights.post(x, y), ((3 * x + 5 * y) << level) as f32);
        }
        assert_eq!(pyramid.levels().last().map(TiledRaster::cols), Some(10));
        let (edited, changed) = plane.edited(250..260, 500..520, |_, _, height| height + 70.0);
        let (updated, reached) = pyramid.updated(&edited, &changed);
        assert!(reached.len() == updated.levels().len() && reached[1].len() == 4);
        let anew = HeightPyramid::new(&edited);
        for (a, b) in updated.levels().iter().zip(anew.levels()) {
            for tile in a.tile_indices() {
                assert_eq!(a.tile_posts(tile), b.tile_posts(tile));
            }
        }
    }
}
