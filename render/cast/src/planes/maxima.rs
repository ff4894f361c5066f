//! The highest ground in blocks of cells: the pyramid that rays descend.

use rayon::prelude::*;
use sandtable_terrain::{Ground, Slab, SlabView, Slot, TILE_CELLS, TileIndex};
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

pub(super) const BLOCKS: usize = LEVEL_BEGIN[TOP as usize] as usize + 1;

/// For each tile of the ground, upper bounds of the height in blocks of 2ˡ × 2ˡ cells, l from 1 to
/// [`TOP`], row by row from the south-west, in steps of 1/65535 of the ground's range.
#[derive(Clone)]
pub(super) struct Maxima {
    slab: Arc<Slab<u16>>,
    tiles: Vec<Arc<Slot<u16>>>,
    /// The height of code 0, and the metres from code to code.
    pub(super) base: f32,
    pub(super) step: f32,
}

impl Maxima {
    /// Of all tiles of `ground`, in parallel.
    pub(super) fn new(ground: &Ground) -> Self {
        let [low, high] = ground.range();
        // A step too long by a little: the highest code must not fall short of the highest post.
        let step = ((high - low) / 65534.0).max(f32::MIN_POSITIVE) * 1.000_001;
        let indices: Vec<_> = ground.heights().tile_indices().collect();
        let slab = Slab::new(indices.len() + indices.len() / 8 + 4, BLOCKS);
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
                maxima.fill(ground, index, slot.items_mut());
                Arc::new(slot)
            })
            .collect();
        maxima
    }

    /// With the `changed` tiles made anew, and the rest shared.
    pub(super) fn updated(&self, ground: &Ground, changed: &[TileIndex]) -> Self {
        let [low, high] = ground.range();
        if low < self.base || high > self.base + 65533.0 * self.step {
            return Self::new(ground);
        }
        let mut result = self.clone();
        let across = ground.heights().tiles_across();
        for &index in changed {
            let slot = (index.row * across + index.col) as usize;
            if slot >= result.tiles.len() {
                continue;
            }
            let Some(mut blocks) = self.slab.take() else {
                return Self::new(ground);
            };
            self.fill(ground, index, blocks.items_mut());
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

    fn fill(&self, ground: &Ground, index: TileIndex, blocks: &mut [u16]) {
        let heights = ground.heights();
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

/// The steepest the ground is along a row of posts, eastwards, and along a column, northwards:
/// metres a cell.
pub(super) fn steepest(ground: &Ground) -> [f32; 2] {
    let heights = ground.heights();
    let stride = heights.tile_stride();
    let indices: Vec<_> = heights.tile_indices().collect();
    let of_tile = |&index: &TileIndex| {
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
    };
    let greater = |a: [f32; 2], b: [f32; 2]| [a[0].max(b[0]), a[1].max(b[1])];
    indices
        .par_iter()
        .map(of_tile)
        .reduce(|| [0.0; 2], greater)
}
