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
///
/// Post i of a level stands at post 2 i of the finer one, and is the mean of the posts around it by
/// [−1 2 6 2 −1] / 8 along each axis: the filter that belongs to linear interpolation between posts
/// (LeGall and Tabatabai 1988), under which ridges stay as high as a level can have them. Beyond the
/// border slopes go on; and no post is higher or lower than all ground.
#[derive(Clone, Debug)]
pub struct HeightPyramid {
    levels: Vec<TiledRaster<f32>>,
}

/// Cells along the longer side of the coarsest level, at most.
const COARSEST: u32 = 16;

/// The size of the level below one of so many posts, or `None` below the coarsest.
pub(crate) fn coarser_size([cols, rows]: [u32; 2]) -> Option<[u32; 2]> {
    (cols.max(rows) > COARSEST + 1).then(|| [half(cols), half(rows)])
}

impl HeightPyramid {
    /// Builds all levels over `heights`, which lie in `range` (metres), and whose tiles it shares.
    #[must_use]
    pub fn new(heights: &TiledRaster<f32>, range: [f32; 2]) -> Self {
        let mut levels = vec![heights.clone()];
        while let Some(finer) = levels.last()
            && let Some([cols, rows]) = coarser_size([finer.cols(), finer.rows()])
        {
            let coarser = TiledRaster::from_rows(cols, rows, sharp_means(finer, range));
            levels.push(coarser);
        }
        Self { levels }
    }

    /// The pyramid after an edit that changed the tiles `changed` of the finest level, and for each
    /// level the tiles that may differ. The others are shared with `self`; `range` holds the
    /// heights of before and after.
    #[must_use]
    pub fn updated(
        &self,
        heights: &TiledRaster<f32>,
        range: [f32; 2],
        changed: &[TileIndex],
    ) -> (Self, Vec<Vec<TileIndex>>) {
        let mut levels = vec![heights.clone()];
        let mut reached = vec![changed.to_vec()];
        for (number, old) in self.levels[1..].iter().enumerate() {
            let finer = &levels[number];
            let tiles = reach::coarser(&reached[number], old.cols(), old.rows());
            let level = old.with_rows_renewed(&tiles, sharp_means(finer, range));
            reached.push(tiles);
            levels.push(level);
        }
        (Self { levels }, reached)
    }

    /// The levels, the finest first.
    #[must_use]
    pub fn levels(&self) -> &[TiledRaster<f32>] {
        &self.levels
    }
}

/// A post along a side as a sum of posts that there are: beyond the border slopes go on, so that
/// what is even stays even up to there.
fn continued(post: i64, last: i64) -> [(i64, f64); 2] {
    let edge = post.clamp(0, last);
    let mirrored = (2 * edge - post).clamp(0, last);
    if post == edge {
        [(post, 1.0), (post, 0.0)]
    } else {
        [(edge, 2.0), (mirrored, -1.0)]
    }
}

/// Fills rows of the coarser level of a [`HeightPyramid`].
fn sharp_means(finer: &TiledRaster<f32>, [low, high]: [f32; 2]) -> impl Fn(u32, u32, &mut [f32]) {
    const LENGTH: usize = 2 * TILE_CELLS as usize + 5;
    const WEIGHTS: [f64; 5] = [-0.125, 0.25, 0.75, 0.25, -0.125];
    let last = [finer.cols(), finer.rows()].map(|posts| i64::from(posts) - 1);
    move |row, col, into| {
        let mut sum = [0.0; LENGTH];
        let mut posts = [0.0; LENGTH];
        let count = 2 * into.len() + 3;
        let first = 2 * i64::from(col) - 2;
        for (row, weight) in (2 * i64::from(row) - 2..).zip(WEIGHTS) {
            for (row, part) in continued(row, last[1]) {
                if part == 0.0 {
                    continue;
                }
                let weight = part * weight;
                let posts = &mut posts[..count];
                finer.copy_row(first, row, posts);
                for (sum, &post) in sum.iter_mut().zip(&*posts) {
                    *sum += weight * f64::from(post);
                }
            }
        }
        for (at, col) in (0..count).zip(first..) {
            if !(0..=last[0]).contains(&col) {
                let parts = continued(col, last[0]).map(|(col, part)| {
                    let at = (col - first).clamp(0, count as i64 - 1);
                    part * sum[at as usize]
                });
                sum[at] = parts[0] + parts[1];
            }
        }
        for (to, around) in into.iter_mut().zip(sum.windows(5).step_by(2)) {
            let outer = (around[0] + around[4]) * WEIGHTS[0];
            let inner = (around[1] + around[3]) * WEIGHTS[1];
            *to = ((around[2] * WEIGHTS[2] + inner + outer) as f32).clamp(low, high);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_stay_planes_inside_and_an_edit_is_followed() {
        let plane = TiledRaster::from_fn(1100, 900, |col, row| (3 * col + 5 * row) as f32);
        let pyramid = HeightPyramid::new(&plane, [0.0, 1e4]);
        for (level, heights) in pyramid.levels().iter().enumerate() {
            let last = [heights.cols() - 1, heights.rows() - 1];
            for (x, y) in [
                (last[0] / 2, last[1] / 2),
                (0, 0),
                (last[0], 0),
                (0, last[1]),
            ] {
                assert_eq!(heights.post(x, y), ((3 * x + 5 * y) << level) as f32);
            }
        }
        assert_eq!(pyramid.levels().last().map(TiledRaster::cols), Some(10));
        let (edited, changed) = plane.edited(250..260, 500..520, |_, _, height| height + 70.0);
        let (updated, reached) = pyramid.updated(&edited, [0.0, 1e4], &changed);
        assert!(reached.len() == updated.levels().len() && reached[1].len() == 4);
        let anew = HeightPyramid::new(&edited, [0.0, 1e4]);
        for (a, b) in updated.levels().iter().zip(anew.levels()) {
            for tile in a.tile_indices() {
                assert_eq!(a.tile_posts(tile), b.tile_posts(tile));
            }
        }
    }
}
