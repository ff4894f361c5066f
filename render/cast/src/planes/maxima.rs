//! The highest ground in blocks of cells: the pyramid that rays descend.

use rayon::prelude::*;
use sandtable_terrain::{Slab, SlabView, Slot, TILE_CELLS, TileIndex, TiledRaster};
use std::sync::Arc;

/// The coarsest level: one block a tile.
pub(super) const TOP: u32 = TILE_CELLS.trailing_zeros();

/// Where each level's blocks begin in a tile's; level 0, the cells themselves, has none.
pub(super) const LEVEL_BEGIN: [i32; TOP as usize + 1] = {
    let mut begins = [0; TOP as usize + 1];
    let mut level = 1;
    while level < TOP as usize {
        let side = TILE_CELLS as i32 >> level;
        begins[level + 1] = begins[level] + side * side;
        level += 1;
    }
    begins
};

/// Kernels read two bytes more than they ask for: these are the slot's own.
const SPARE: usize = 1;

const BLOCKS: usize = LEVEL_BEGIN[TOP as usize] as usize + 1;

/// For each tile of the ground, upper bounds of the height in blocks of 2ˡ × 2ˡ cells, l from 1 to
/// [`TOP`], row by row from the south-west, in even steps.
#[derive(Clone)]
pub(super) struct Maxima {
    slab: Arc<Slab<u16>>,
    tiles: Vec<Arc<Slot<u16>>>,
    /// The height of code 0, and the metres from code to code.
    pub(super) base: f32,
    pub(super) step: f32,
}

impl Maxima {
    /// Of all tiles of `heights`, which lie in `range`, in parallel.
    pub(super) fn new(heights: &TiledRaster<f32>, [low, high]: [f32; 2]) -> Self {
        // Half the range below and above is left to edits. And a step too long by a little: the
        // highest code must not fall short of the highest post.
        let low = low - 0.5 * (high - low);
        let step = ((high - low) / 49150.0).max(f32::MIN_POSITIVE) * 1.000_001;
        let indices: Vec<_> = heights.tile_indices().collect();
        let slab = Slab::new(indices.len() + indices.len() / 8 + 4, BLOCKS + SPARE);
        let mut maxima = Self {
            tiles: Vec::new(),
            base: low,
            step,
            slab,
        };
        let slots: Vec<_> = indices.iter().map_while(|_| maxima.slab.take()).collect();
        maxima.tiles = indices
            .into_par_iter()
            .zip(slots)
            .map(|(index, mut slot)| {
                maxima.fill(heights, index, slot.items_mut());
                Arc::new(slot)
            })
            .collect();
        maxima
    }

    /// With the `changed` tiles made anew, and the rest shared.
    pub(super) fn updated(
        &self,
        heights: &TiledRaster<f32>,
        [low, high]: [f32; 2],
        changed: &[TileIndex],
    ) -> Self {
        if low < self.base || high > self.base + 65533.0 * self.step {
            return Self::new(heights, [low, high]);
        }
        let mut result = self.clone();
        let across = heights.tiles_across();
        for &index in changed {
            let slot = (index.row * across + index.col) as usize;
            if slot >= result.tiles.len() {
                continue;
            }
            let Some(mut blocks) = self.slab.take() else {
                return Self::new(heights, [low, high]);
            };
            self.fill(heights, index, blocks.items_mut());
            result.tiles[slot] = Arc::new(blocks);
        }
        result
    }

    /// All tiles' blocks, in the order of the ground's tiles.
    pub(super) fn view(&self) -> SlabView<'_, u16> {
        SlabView::new(&self.slab, self.tiles.iter().map(|tile| &**tile))
    }

    /// The least code that stands for `height` or more.
    fn code(&self, height: f32) -> u16 {
        let code = ((height - self.base) / self.step) as u16;
        if self.base + f32::from(code) * self.step >= height {
            code
        } else {
            code.saturating_add(1)
        }
    }

    fn fill(&self, heights: &TiledRaster<f32>, index: TileIndex, blocks: &mut [u16]) {
        let stride = heights.tile_stride();
        let posts = heights.tile_posts(index);
        let rows = posts.len() / stride;
        blocks.fill(0);
        let side = (TILE_CELLS / 2) as usize;
        for row in 0..side.min((rows - 1).div_ceil(2)) {
            let mut highest = [f32::NEG_INFINITY; TILE_CELLS as usize + 1];
            for row in 2 * row..rows.min(2 * row + 3) {
                let row = &posts[row * stride..(row + 1) * stride];
                for (highest, &post) in highest.iter_mut().zip(row) {
                    *highest = highest.max(post);
                }
            }
            for col in 0..side.min((stride - 1).div_ceil(2)) {
                let [a, b, c] = [2 * col, 2 * col + 1, 2 * col + 2].map(|col| highest[col]);
                blocks[row * side + col] = self.code(a.max(b).max(c));
            }
        }
        for level in 2..=TOP as usize {
            let side = TILE_CELLS as usize >> level;
            let (finer, coarser) = blocks.split_at_mut(LEVEL_BEGIN[level] as usize);
            let finer = &finer[LEVEL_BEGIN[level - 1] as usize..];
            for row in 0..side {
                for col in 0..side {
                    let at = |row: usize, col: usize| finer[row * 2 * side + col];
                    let south = at(2 * row, 2 * col).max(at(2 * row, 2 * col + 1));
                    let north = at(2 * row + 1, 2 * col).max(at(2 * row + 1, 2 * col + 1));
                    coarser[row * side + col] = south.max(north);
                }
            }
        }
    }
}

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

    fn ground(height: impl Fn(u32, u32) -> f32 + Sync) -> Ground {
        Ground::from_fn(300, 270, DVec2::ONE, height).expect("a sound grid")
    }

    fn rough(col: u32, row: u32) -> f32 {
        ((col * 37 + row * 91) % 113) as f32 * 1.7 - 40.0
    }

    #[test]
    fn blocks_are_bounded_from_above_and_tightly() {
        let ground = ground(rough);
        let maxima = Maxima::new(ground.heights(), ground.range());
        let view = maxima.view();
        for (tile, index) in ground.heights().tile_indices().enumerate() {
            let blocks = view.from_place(view.bases()[tile]);
            for level in 1..=TOP {
                let side = TILE_CELLS >> level;
                for (row, col) in (0..side).flat_map(|row| (0..side).map(move |col| (row, col))) {
                    let first = |at: u32, tile: u32| tile * TILE_CELLS + (at << level);
                    let (x, y) = (first(col, index.col), first(row, index.row));
                    if x >= 299 || y >= 269 {
                        continue;
                    }
                    let code =
                        blocks[LEVEL_BEGIN[level as usize] as usize + (row * side + col) as usize];
                    let bound = maxima.base + f32::from(code) * maxima.step;
                    let (right, top) = ((x + (1 << level)).min(299), (y + (1 << level)).min(269));
                    let posts = (y..=top).flat_map(|y| (x..=right).map(move |x| rough(x, y)));
                    let highest = posts.fold(f32::NEG_INFINITY, f32::max);
                    assert!(bound >= highest && bound <= highest + 2.0 * maxima.step);
                }
            }
        }
    }

    #[test]
    fn an_edit_is_followed() {
        let before = ground(rough);
        let edited = before.edited(250..258, 100..103, |_, _, height| height + 35.0);
        let (after, changed) = edited.expect("finite");
        let maxima = Maxima::new(before.heights(), before.range());
        let maxima = maxima.updated(after.heights(), after.range(), &changed);
        let steepness = Steepness::new(before.heights()).updated(after.heights(), &changed);
        assert_eq!(
            steepness.steepest(),
            Steepness::new(after.heights()).steepest()
        );
        assert!(steepness.steepest()[0] > Steepness::new(before.heights()).steepest()[0]);
        let view = maxima.view();
        let bound = |place: usize| {
            let code = view.from_place(view.bases()[place])[LEVEL_BEGIN[TOP as usize] as usize];
            maxima.base + f32::from(code) * maxima.step
        };
        let [_, high] = after.range();
        assert!(bound(0) >= high - 20.0 && bound(1) >= high - 20.0);
        assert!(bound(0).max(bound(1)) >= high);
    }
}
