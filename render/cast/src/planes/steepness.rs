//! How steep the ground is, block by block, and how twisted.

mod seen;

#[cfg(test)]
pub(super) use seen::AROUND;
pub(super) use seen::{GRADIENT, SQUARE, SteepnessSeen};

use rayon::prelude::*;
use sandtable_terrain::{TILE_CELLS, TileIndex, TiledRaster};

/// Blocks along the ground's longer side, at most, as long as they are no larger than tiles.
const MOST_ALONG: u32 = 32;

/// Cells along the smallest blocks' sides.
const LEAST_SIDE: u32 = 8;

/// A block of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Block {
    /// How steep it is at most along a row of posts, eastwards, and along a column, northwards: metres
    /// a cell.
    steepest: [f32; 2],
    /// And in whatever direction.
    gradient: f32,
    /// Its lowest and its highest post.
    heights: [f32; 2],
    /// How much more, at most, one side of a cell rises than the other: metres.
    twist: f32,
}

impl Block {
    /// Without any ground.
    const EMPTY: Self = Self {
        steepest: [0.0; 2],
        gradient: 0.0,
        heights: [f32::INFINITY, f32::NEG_INFINITY],
        twist: 0.0,
    };
}

/// How steep the ground is at most, in blocks of cells that divide its tiles.
#[derive(Clone)]
pub(super) struct Steepness {
    /// Cells along a block's side.
    side: u32,
    /// Blocks from west to east.
    across: usize,
    /// Row by row from the south.
    blocks: Vec<Block>,
    /// Anywhere, along x and along y.
    steepest: [f32; 2],
    gradient: f32,
    twist: f32,
}

impl Steepness {
    /// Of all tiles of `heights`, in parallel.
    pub(super) fn new(heights: &TiledRaster<f32>) -> Self {
        let cells = [heights.cols() - 1, heights.rows() - 1];
        let side = cells[0].max(cells[1]).div_ceil(MOST_ALONG);
        let side = side.next_power_of_two().clamp(LEAST_SIDE, TILE_CELLS);
        let [across, along] = cells.map(|cells| cells.div_ceil(side) as usize);
        let mut steepness = Self {
            side,
            across,
            blocks: vec![Block::EMPTY; across * along],
            steepest: [0.0; 2],
            gradient: 0.0,
            twist: 0.0,
        };
        let indices: Vec<_> = heights.tile_indices().collect();
        steepness.look_at(heights, &indices);
        steepness
    }

    /// With the `changed` tiles of the same grid looked at anew; places off it are left out.
    pub(super) fn updated(&self, heights: &TiledRaster<f32>, changed: &[TileIndex]) -> Self {
        let mut result = self.clone();
        result.look_at(heights, changed);
        result
    }

    /// How many blocks there are.
    pub(super) fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Anywhere, along x and along y.
    pub(super) fn steepest(&self) -> [f32; 2] {
        self.steepest
    }

    /// Anywhere, in whatever direction.
    pub(super) fn gradient(&self) -> f32 {
        self.gradient
    }

    /// How much more one side of a cell rises than the other, anywhere: metres.
    pub(super) fn twist(&self) -> f32 {
        self.twist
    }

    /// What lies in the cells from the first to the last along x, and along y: by how much one of these rises at
    /// most, along either axis, and the highest post, in metres.
    pub(super) fn among(&self, [x, y]: [[i32; 2]; 2]) -> [f32; 2] {
        let along = self.blocks.len() / self.across;
        let blocks = |[first, last]: [i32; 2], count: usize| {
            let block = |cell: i32| (cell.max(0) as usize / self.side as usize).min(count - 1);
            block(first)..=block(last)
        };
        let mut most = [0.0, f32::NEG_INFINITY];
        for row in blocks(y, along) {
            for col in blocks(x, self.across) {
                let block = &self.blocks[row * self.across + col];
                let [east, north] = block.steepest;
                most = [most[0].max(east).max(north), most[1].max(block.heights[1])];
            }
        }
        most
    }

    fn look_at(&mut self, heights: &TiledRaster<f32>, tiles: &[TileIndex]) {
        let side = self.side as usize;
        let in_tile = (TILE_CELLS / self.side) as usize;
        let rows_of_blocks: Vec<_> = tiles
            .par_iter()
            .filter(|&&tile| heights.has_tile(tile))
            .map(|&tile| (tile, rows_of_blocks(heights, tile, side)))
            .collect();
        for (tile, rows) in rows_of_blocks {
            let first = tile.row as usize * in_tile * self.across + tile.col as usize * in_tile;
            for (row, blocks) in rows.iter().enumerate() {
                let first = first + row * self.across;
                self.blocks[first..first + blocks.len()].copy_from_slice(blocks);
            }
        }
        let steepest = self.blocks.iter().map(|block| block.steepest);
        self.steepest = steepest.fold([0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let gradients = self.blocks.iter().map(|block| block.gradient);
        self.gradient = gradients.fold(0.0, f32::max);
        let twists = self.blocks.iter().map(|block| block.twist);
        self.twist = twists.fold(0.0, f32::max);
    }
}

/// The blocks of a tile, row by row.
fn rows_of_blocks(heights: &TiledRaster<f32>, tile: TileIndex, side: usize) -> Vec<Vec<Block>> {
    let stride = heights.tile_stride();
    let posts: Vec<_> = heights.tile_posts(tile).chunks_exact(stride).collect();
    let cells = (heights.cols() - 1 - tile.col * TILE_CELLS).min(TILE_CELLS) as usize;
    let row_of_blocks = |first: usize| {
        // A block has the posts on all of its sides.
        let posts = &posts[first..posts.len().min(first + side + 1)];
        let mut blocks = vec![Block::EMPTY; cells.div_ceil(side)];
        for (number, &row) in posts.iter().enumerate() {
            let north = posts.get(number + 1).copied().unwrap_or(row);
            for (k, block) in blocks.iter_mut().enumerate() {
                let range = k * side..cells.min((k + 1) * side) + 1;
                block.add(&row[range.clone()], &north[range]);
            }
        }
        blocks
    };
    (0..posts.len() - 1)
        .step_by(side)
        .map(row_of_blocks)
        .collect()
}

impl Block {
    /// Takes in a row of posts, and how much those to the north of them are higher.
    fn add(&mut self, row: &[f32], north: &[f32]) {
        let [mut east, mut up] = self.steepest;
        let [mut low, mut high] = self.heights;
        let mut twist = self.twist;
        let mut square = self.gradient * self.gradient;
        for (&post, &next) in row.iter().zip(&row[1..]) {
            east = east.max((next - post).abs());
        }
        for (&post, &north) in row.iter().zip(north) {
            up = up.max((north - post).abs());
            (low, high) = (low.min(post), high.max(post));
        }
        for (south, north) in row.windows(2).zip(north.windows(2)) {
            let [by_south, by_north] = [south[1] - south[0], north[1] - north[0]];
            let [by_west, by_east] = [north[0] - south[0], north[1] - south[1]];
            twist = twist.max((by_north - by_south).abs());
            // A cell is steepest in one of its corners.
            let along_x = (by_south * by_south).max(by_north * by_north);
            let along_y = (by_west * by_west).max(by_east * by_east);
            square = square.max(along_x + along_y);
        }
        *self = Self {
            steepest: [east, up],
            gradient: square.sqrt(),
            heights: [low, high],
            twist,
        };
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
        let (after, mut changed) = edited.expect("finite");
        // What is off the raster is left out.
        changed.extend([[2, 0], [0, 2], [9, 9]].map(|[col, row]| TileIndex { col, row }));
        let steepness = Steepness::new(before.heights()).updated(after.heights(), &changed);
        assert_eq!(steepness.blocks, Steepness::new(after.heights()).blocks);
        assert!(steepness.steepest()[0] > Steepness::new(before.heights()).steepest()[0]);
        let anew = Steepness::new(after.heights());
        assert_eq!(steepness.gradient(), anew.gradient());
        assert_eq!(steepness.twist(), anew.twist());
    }
}
