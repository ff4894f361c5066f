//! Tilted planes over all ground of a block of cells: the pyramid that rays descend.

use rayon::prelude::*;
use sandtable_terrain::{Slab, SlabView, Slot, TILE_CELLS, TileIndex, TiledRaster};
use std::sync::Arc;

/// The finest level: blocks of 4 × 4 cells.
pub(super) const FINEST: u32 = 2;

/// The coarsest level: one block a tile.
pub(super) const TOP: u32 = TILE_CELLS.trailing_zeros();

/// Where each level's blocks begin in a tile's.
pub(super) const LEVEL_BEGIN: [i32; TOP as usize + 1] = {
    let mut begins = [0; TOP as usize + 1];
    let mut level = FINEST as usize;
    while level < TOP as usize {
        let side = TILE_CELLS as i32 >> level;
        begins[level + 1] = begins[level] + side * side;
        level += 1;
    }
    begins
};

const BLOCKS: usize = LEVEL_BEGIN[TOP as usize] as usize + 1;

/// A block's roof, a plane that no ground in the block rises over: the bits of its height over the
/// block's middle in metres; and how it rises eastwards and northwards in metres a cell, each as the
/// upper half of a float's bits, northwards in the upper half.
pub(super) type Roof = [u32; 2];

/// For each tile of the ground, the roofs of blocks of 2ˡ × 2ˡ cells, l from [`FINEST`] to [`TOP`],
/// row by row from the south-west.
#[derive(Clone)]
pub(super) struct Roofs {
    slab: Arc<Slab<Roof>>,
    tiles: Vec<Arc<Slot<Roof>>>,
}

impl Roofs {
    /// Of all tiles of `heights`, in parallel.
    pub(super) fn new(heights: &TiledRaster<f32>) -> Self {
        let indices: Vec<_> = heights.tile_indices().collect();
        let slab = Slab::new(indices.len() + indices.len() / 8 + 4, BLOCKS);
        let slots: Vec<_> = indices.iter().map_while(|_| slab.take()).collect();
        let tiles = indices
            .into_par_iter()
            .zip(slots)
            .map(|(index, mut slot)| {
                fill(heights, index, slot.items_mut());
                Arc::new(slot)
            })
            .collect();
        Self { slab, tiles }
    }

    /// With the `changed` tiles of the same grid made anew, and the rest shared; places off it are left out.
    pub(super) fn updated(&self, heights: &TiledRaster<f32>, changed: &[TileIndex]) -> Self {
        let across = heights.tiles_across();
        let places: Vec<_> = changed
            .iter()
            .filter(|&&index| heights.has_tile(index))
            .map(|&index| ((index.row * across + index.col) as usize, index))
            .collect();
        let free: Vec<_> = places.iter().map_while(|_| self.slab.take()).collect();
        if free.len() < places.len() {
            return Self::new(heights);
        }
        let renewed: Vec<_> = places
            .into_par_iter()
            .zip(free)
            .map(|((slot, index), mut roofs)| {
                fill(heights, index, roofs.items_mut());
                (slot, Arc::new(roofs))
            })
            .collect();
        let mut result = self.clone();
        for (slot, roofs) in renewed {
            result.tiles[slot] = roofs;
        }
        result
    }

    /// All tiles' roofs, in the order of the ground's tiles.
    pub(super) fn view(&self) -> SlabView<'_, Roof> {
        SlabView::new(&self.slab, self.tiles.iter().map(|tile| &**tile))
    }
}

/// The numbers of a roof: its height over the block's middle, and its rises.
pub(super) fn numbers([height, rises]: Roof) -> [f32; 3] {
    [height, rises << 16, rises & UPPER].map(f32::from_bits)
}

/// The upper half of a float's bits.
const UPPER: u32 = 0xffff_0000;

/// No roof: where there is no ground.
const NONE: Roof = [f32::MIN.to_bits(), 0];

/// The lowest roof of a block with `size` cells along a side that rises so, eastwards and
/// northwards; `highest` gives how high a plane must be over the block's middle that rises as it is
/// told, but for rounding.
fn lowest_roof(size: f32, rises: [f32; 2], highest: impl FnOnce([f32; 2]) -> f32) -> Roof {
    let [east, north] = rises.map(|rise| {
        let nearest = rise.to_bits().wrapping_add(0x8000) & UPPER;
        if f32::from_bits(nearest).is_finite() {
            nearest
        } else {
            0
        }
    });
    let rises = [east, north].map(f32::from_bits);
    let height = highest(rises);
    // Four roundings or less of numbers that are no larger.
    let largest = height.abs() + (rises[0].abs() + rises[1].abs()) * size;
    let height = height + 2.0 * f32::EPSILON * largest;
    [height.to_bits(), east >> 16 | north]
}

fn fill(heights: &TiledRaster<f32>, index: TileIndex, roofs: &mut [Roof]) {
    let stride = heights.tile_stride();
    let posts = heights.tile_posts(index);
    // What lies beyond the border repeats the last post.
    let cells = |posts: u32, tile: u32| (posts - 1 - tile * TILE_CELLS).min(TILE_CELLS) as usize;
    let cols = cells(heights.cols(), index.col);
    let rows = cells(heights.rows(), index.row);
    roofs.fill(NONE);
    let size = 1 << FINEST;
    let side = TILE_CELLS as usize / size;
    for row in 0..side.min(rows.div_ceil(size)) {
        for col in 0..side.min(cols.div_ceil(size)) {
            let [x, y] = [col * size, row * size];
            let block = &posts[y * stride + x..];
            roofs[row * side + col] = if x + size <= cols && y + size <= rows {
                whole_block(block, stride)
            } else {
                part_of_block(block, stride, [(cols - x).min(size), (rows - y).min(size)])
            };
        }
    }
    for level in FINEST + 1..=TOP {
        let side = TILE_CELLS as usize >> level;
        let (finer, coarser) = roofs.split_at_mut(LEVEL_BEGIN[level as usize] as usize);
        let finer = &finer[LEVEL_BEGIN[level as usize - 1] as usize..];
        for row in 0..side {
            for col in 0..side {
                let at = |east, north| finer[(2 * row + north) * 2 * side + 2 * col + east];
                let quarters = [[at(0, 0), at(1, 0)], [at(0, 1), at(1, 1)]];
                coarser[row * side + col] = over_quarters(quarters, (1 << level) as f32);
            }
        }
    }
}

/// Cells and posts along a side of a finest block.
const SIZE: f32 = (1 << FINEST) as f32;
const POSTS: usize = (1 << FINEST) + 1;

/// The roof of a finest block of which the posts begin with the first of `posts`: it rises as the
/// plane does that is nearest to them.
fn whole_block(posts: &[f32], stride: usize) -> Roof {
    let rows: [&[f32; POSTS]; POSTS] =
        std::array::from_fn(|row| posts[row * stride..].first_chunk().expect("a row of posts"));
    let from_middle: [f32; POSTS] = std::array::from_fn(|k| k as f32 - (POSTS / 2) as f32);
    let squares: f32 = POSTS as f32 * from_middle.iter().map(|d| d * d).sum::<f32>();
    let (mut east, mut north) = (0.0, 0.0);
    for (row, y) in rows.iter().zip(from_middle) {
        let mut sum = 0.0;
        for (post, x) in row.iter().zip(from_middle) {
            east += x * post;
            sum += post;
        }
        north += y * sum;
    }
    lowest_roof(SIZE, [east / squares, north / squares], |[east, north]| {
        let mut highest = [f32::MIN; POSTS];
        for (row, y) in rows.iter().zip(from_middle) {
            for k in 0..POSTS {
                highest[k] = highest[k].max(row[k] - (east * from_middle[k] + north * y));
            }
        }
        highest.into_iter().fold(f32::MIN, f32::max)
    })
}

/// The roof of a finest block at the ground's border, which has so many cells along x and y: it
/// rises as the ground does from corner to corner.
fn part_of_block(posts: &[f32], stride: usize, [cols, rows]: [usize; 2]) -> Roof {
    let at = |x: usize, y: usize| posts[y * stride + x];
    let along = |from: f32, to: f32, cells: usize| (to - from) / cells as f32;
    let east = along(at(0, 0), at(cols, 0), cols) + along(at(0, rows), at(cols, rows), cols);
    let north = along(at(0, 0), at(0, rows), rows) + along(at(cols, 0), at(cols, rows), rows);
    let middle = SIZE * 0.5;
    lowest_roof(SIZE, [0.5 * east, 0.5 * north], |[east, north]| {
        (0..=rows)
            .flat_map(|y| (0..=cols).map(move |x| (x, y)))
            .map(|(x, y)| at(x, y) - (east * (x as f32 - middle) + north * (y as f32 - middle)))
            .fold(f32::MIN, f32::max)
    })
}

/// The roof over those of a block's quarters (southern and northern rows), of which the block has
/// `size` cells along a side.
fn over_quarters(quarters: [[Roof; 2]; 2], size: f32) -> Roof {
    let there = |roof: Roof| roof != NONE;
    let quarter = 0.25 * size;
    let [[sw, se], [nw, ne]] = quarters.map(|row| row.map(|roof| numbers(roof)[0]));
    let mut all = quarters.into_iter().flatten();
    if !all.clone().any(there) {
        return NONE;
    }
    let whole = all.all(there);
    let rises = if whole {
        [se - sw + ne - nw, nw - sw + ne - se].map(|rise| rise / size)
    } else {
        let [_, east, north] = numbers(quarters[0][0]);
        [east, north]
    };
    lowest_roof(size, rises, |[east, north]| {
        let mut highest = f32::MIN;
        for (row, y) in quarters.iter().zip([-quarter, quarter]) {
            for (&roof, x) in row.iter().zip([-quarter, quarter]) {
                if there(roof) {
                    let [height, its_east, its_north] = numbers(roof);
                    let corner = ((its_east - east).abs() + (its_north - north).abs()) * quarter;
                    highest = highest.max(height - (east * x + north * y) + corner);
                }
            }
        }
        highest
    })
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

    /// Calls `look` with each block's level, its roof, and by how much that is over each post, the
    /// posts' places being counted from the south-west.
    fn each_block(ground: &Ground, mut look: impl FnMut(u32, Roof, &mut dyn Iterator<Item = f32>)) {
        let heights = ground.heights();
        let roofs = Roofs::new(heights);
        let view = roofs.view();
        let last = [heights.cols() - 1, heights.rows() - 1];
        for (tile, index) in heights.tile_indices().enumerate() {
            let blocks = view.from_place(view.bases()[tile]);
            for level in FINEST..=TOP {
                let side = TILE_CELLS >> level;
                for (row, col) in (0..side).flat_map(|row| (0..side).map(move |col| (row, col))) {
                    let first = |at: u32, tile: u32| tile * TILE_CELLS + (at << level);
                    let [x, y] = [first(col, index.col), first(row, index.row)];
                    if x >= last[0] || y >= last[1] {
                        continue;
                    }
                    let at = LEVEL_BEGIN[level as usize] as usize + (row * side + col) as usize;
                    let [height, east, north] = numbers(blocks[at]);
                    let size = 1 << level;
                    let half = size as f32 * 0.5;
                    let posts = (y..=last[1].min(y + size))
                        .flat_map(|y| (x..=last[0].min(x + size)).map(move |x| [x, y]));
                    let mut over = posts.map(|[col, row]| {
                        let aside = [(col - x) as f32 - half, (row - y) as f32 - half];
                        let roof = height + (east * aside[0] + north * aside[1]);
                        roof - heights.post(col, row)
                    });
                    look(level, blocks[at], &mut over);
                }
            }
        }
    }

    #[test]
    fn no_ground_is_over_a_roof() {
        each_block(&ground(rough), |level, _, over| {
            let least = over.fold(f32::INFINITY, f32::min);
            assert!(least >= -1e-3, "{least} in a block of level {level}");
            // The finest lie on a post; the others on finer ones.
            assert!(level > FINEST || least <= 1e-3, "{least}");
        });
    }

    #[test]
    fn a_slope_has_its_roofs_upon_it() {
        let slope = ground(|col, row| 3.0 * col as f32 - 0.5 * row as f32);
        each_block(&slope, |level, _, over| {
            let most = over.fold(0.0, f32::max);
            assert!(most <= 1e-2, "{most} in a block of level {level}");
        });
    }

    #[test]
    fn smooth_hills_have_their_roofs_close() {
        let wave = |at: u32| (at as f32 * 0.12).sin() * 12.0;
        let hills = ground(|col, row| wave(col) + wave(row));
        let (mut sum, mut count) = (0.0, 0);
        each_block(&hills, |level, _, over| {
            if level == FINEST {
                sum += over.fold(0.0, f32::max);
                count += 1;
            }
        });
        // A bound without a tilt would be 2 to 8 m over the lowest post of most blocks.
        let mean = sum / count as f32;
        assert!(mean < 0.8, "{mean}");
    }

    #[test]
    fn an_edit_is_followed() {
        let before = ground(rough);
        let edited = before.edited(250..258, 100..103, |_, _, height| height + 35.0);
        let (after, mut changed) = edited.expect("finite");
        // What is off the raster is left out.
        changed.extend([[2, 0], [0, 2], [9, 9]].map(|[col, row]| TileIndex { col, row }));
        let followed = Roofs::new(before.heights()).updated(after.heights(), &changed);
        let anew = Roofs::new(after.heights());
        let (followed, anew) = (followed.view(), anew.view());
        assert_eq!(followed.bases().len(), anew.bases().len());
        for (&a, &b) in followed.bases().iter().zip(anew.bases()) {
            assert_eq!(
                followed.from_place(a)[..BLOCKS],
                anew.from_place(b)[..BLOCKS]
            );
        }
        let old = Roofs::new(before.heights());
        let top = LEVEL_BEGIN[TOP as usize] as usize;
        assert_ne!(old.view().from_place(0)[top], anew.from_place(0)[top]);
    }
}
