//! Rasters cut into square tiles, each complete in itself.

use crate::NoMemory;
use crate::slab::{Slab, SlabView, Slot};
use bytemuck::Zeroable;
use rayon::prelude::*;
use std::sync::Arc;

/// Cells along a tile's side; a whole tile has one post more, shared with its neighbour.
pub const TILE_CELLS: u32 = 1 << TILE_SHIFT;
const TILE_SHIFT: u32 = 8;
const TILE_MASK: u32 = TILE_CELLS - 1;

/// Items behind a tile's posts, so that whoever reads some bytes more than asked for stays in the
/// tile's own memory.
const SPARE: usize = 4;

/// A raster of posts in tiles of [`TILE_CELLS`]² cells. Row 0 is south.
///
/// Neighbouring tiles both hold the posts on their common border (papers' row H1: (2ⁿ+1)² blocks),
/// so that any cell is read from one tile. Tiles are shared between snapshots: a clone copies no
/// posts. All of them lie in one piece of memory, in slots of equal length.
///
/// A tile's posts are row by row from its south-west corner. Rows are as long in all tiles of a
/// raster; in the last tile of a side, what lies beyond the raster repeats its last post.
#[derive(Clone, Debug)]
pub struct TiledRaster<T> {
    cols: u32,
    rows: u32,
    tiles_across: u32,
    stride: usize,
    slab: Arc<Slab<T>>,
    tiles: Vec<Arc<Slot<T>>>,
}

/// A tile's place: column from the west, row from the south.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TileIndex {
    /// Column of the tile, from the west.
    pub col: u32,
    /// Row of the tile, from the south.
    pub row: u32,
}

impl<T: Copy + Send + Sync + Zeroable> TiledRaster<T> {
    /// A raster of zeros, and the slots of its tiles to be filled.
    fn empty(cols: u32, rows: u32) -> Result<(Self, Vec<Slot<T>>), NoMemory> {
        assert!(
            cols >= 2 && rows >= 2,
            "a raster of {cols} by {rows} posts has no cell"
        );
        let tiles_across = (cols - 1).div_ceil(TILE_CELLS);
        let tiles = (tiles_across * (rows - 1).div_ceil(TILE_CELLS)) as usize;
        let stride = cols.min(TILE_CELLS + 1) as usize;
        // Some slots more: for edits, and for a mipmap's levels beside the raster and their edits.
        let slab = Slab::try_new(
            tiles + tiles / 8 + 4 + 2 * crate::mipmap::coarser_tiles(cols, rows),
            stride * rows.min(TILE_CELLS + 1) as usize + SPARE,
        )?;
        let slots = (0..tiles).map_while(|_| slab.take()).collect();
        let raster = Self {
            cols,
            rows,
            tiles_across,
            stride,
            slab,
            tiles: Vec::new(),
        };
        Ok((raster, slots))
    }

    /// Number of rows of posts in a tile.
    fn height(&self, tile: usize) -> usize {
        let row0 = tile as u32 / self.tiles_across * TILE_CELLS;
        self.rows.min(row0 + TILE_CELLS + 1) as usize - row0 as usize
    }

    /// A tile's posts, to be changed; a copy of them where another snapshot shares the tile.
    fn posts_mut(&mut self, tile: usize) -> &mut [T] {
        if Arc::get_mut(&mut self.tiles[tile]).is_none() {
            let mut slot = self.free_slots(1).remove(0);
            slot.items_mut().copy_from_slice(&self.tiles[tile]);
            self.tiles[tile] = Arc::new(slot);
        }
        let posts = self.height(tile) * self.stride;
        let slot = Arc::get_mut(&mut self.tiles[tile]).expect("no other snapshot has this tile");
        &mut slot.items_mut()[..posts]
    }

    /// So many free slots; where there are too few, all tiles move to a larger piece of memory first.
    fn free_slots(&mut self, wanted: usize) -> Vec<Slot<T>> {
        let slots: Vec<_> = (0..wanted).map_while(|_| self.slab.take()).collect();
        if slots.len() == wanted {
            return slots;
        }
        let held = self.tiles.len();
        self.slab = Slab::new(held + wanted + held / 4 + 3, self.slab.slot_len());
        for tile in &mut self.tiles {
            let mut slot = self.slab.take().expect("it is larger");
            slot.items_mut().copy_from_slice(tile);
            *tile = Arc::new(slot);
        }
        (0..wanted).map_while(|_| self.slab.take()).collect()
    }

    /// The memory of all tiles, for reading many posts at a time.
    #[must_use]
    pub fn view(&self) -> SlabView<'_, T> {
        SlabView::new(&self.slab, self.tiles.iter().map(|tile| &**tile))
    }

    /// Builds a raster of `cols` by `rows` posts from a function of column and row, in parallel.
    ///
    /// Posts on tile borders are asked for once by each tile that holds them, so the function must
    /// give the same answer each time.
    ///
    /// # Panics
    /// Where a side has fewer than 2 posts, or where memory for all tiles would have more than 2³² places.
    pub fn from_fn(cols: u32, rows: u32, post: impl Fn(u32, u32) -> T + Sync) -> Self {
        Self::from_rows(cols, rows, each_post(post))
    }

    /// As [`TiledRaster::from_fn`], with an error where there is not the memory for it.
    pub(crate) fn try_from_fn(
        cols: u32,
        rows: u32,
        post: impl Fn(u32, u32) -> T + Sync,
    ) -> Result<Self, NoMemory> {
        Self::try_from_rows(cols, rows, each_post(post))
    }

    /// As [`TiledRaster::from_fn`], a tile's row at a time: `fill(row, col, into)` fills `into` with
    /// the posts of a row from column `col` on.
    pub(crate) fn from_rows(
        cols: u32,
        rows: u32,
        fill: impl Fn(u32, u32, &mut [T]) + Sync,
    ) -> Self {
        Self::try_from_rows(cols, rows, fill).unwrap_or_else(|refused| panic!("{refused}"))
    }

    /// As [`TiledRaster::from_rows`], with an error where there is not the memory for it.
    fn try_from_rows(
        cols: u32,
        rows: u32,
        fill: impl Fn(u32, u32, &mut [T]) + Sync,
    ) -> Result<Self, NoMemory> {
        let (mut raster, slots) = Self::empty(cols, rows)?;
        raster.tiles = raster.filled(slots.into_iter().enumerate().collect(), fill);
        Ok(raster)
    }

    /// As [`TiledRaster::from_rows`], in free slots of this raster's memory; or `None` where there
    /// are too few of them. The new raster must not be larger than this one.
    pub(crate) fn laid_beside(
        &self,
        cols: u32,
        rows: u32,
        fill: impl Fn(u32, u32, &mut [T]) + Sync,
    ) -> Option<Self> {
        let tiles_across = (cols - 1).div_ceil(TILE_CELLS);
        let tiles = (tiles_across * (rows - 1).div_ceil(TILE_CELLS)) as usize;
        let slots: Vec<_> = (0..tiles).map_while(|_| self.slab.take()).collect();
        let mut raster = Self {
            cols,
            rows,
            tiles_across,
            stride: self.stride,
            slab: Arc::clone(&self.slab),
            tiles: Vec::new(),
        };
        if slots.len() < tiles {
            return None;
        }
        raster.tiles = raster.filled(slots.into_iter().enumerate().collect(), fill);
        Some(raster)
    }

    /// Fills slots, each for the tile of the number beside it, in parallel.
    fn filled(
        &self,
        slots: Vec<(usize, Slot<T>)>,
        fill: impl Fn(u32, u32, &mut [T]) + Sync,
    ) -> Vec<Arc<Slot<T>>> {
        let (across, stride) = (self.tiles_across, self.stride);
        let fill_tile = |(tile, mut slot): (usize, Slot<T>)| {
            let col0 = tile as u32 % across * TILE_CELLS;
            let row0 = tile as u32 / across * TILE_CELLS;
            let width = self.cols.min(col0 + TILE_CELLS + 1) - col0;
            let posts = &mut slot.items_mut()[..self.height(tile) * stride];
            for (row, posts) in (row0..).zip(posts.chunks_exact_mut(stride)) {
                let (posts, beyond) = posts.split_at_mut(width as usize);
                fill(row, col0, posts);
                beyond.fill(posts[posts.len() - 1]);
            }
            Arc::new(slot)
        };
        slots.into_par_iter().map(fill_tile).collect()
    }

    /// Copies the posts of row `row` from column `col` on; off the raster the nearest post repeats.
    pub(crate) fn copy_row(&self, col: i64, row: i64, into: &mut [T]) {
        let row = row.clamp(0, i64::from(self.rows) - 1) as u32;
        let tile_row = row.min(self.rows - 2) >> TILE_SHIFT;
        let within = (row - tile_row * TILE_CELLS) as usize * self.stride;
        let count = into.len() as i64;
        let last = i64::from(self.cols) - 1;
        let mut at = 0;
        while at < count {
            let col = col + at;
            let inside = col.clamp(0, last) as u32;
            let tile_col = inside.min(self.cols - 2) >> TILE_SHIFT;
            let tile = &self.tiles[(tile_row * self.tiles_across + tile_col) as usize];
            let x = inside - tile_col * TILE_CELLS;
            let posts = &tile[within + x as usize..];
            let run = if col < 0 {
                -col
            } else if col >= last {
                count - at
            } else {
                (last - col).min(i64::from(TILE_CELLS - x))
            };
            let to = &mut into[at as usize..(at + run).min(count) as usize];
            if (0..last).contains(&col) {
                to.copy_from_slice(&posts[..to.len()]);
            } else {
                to.fill(posts[0]);
            }
            at += run;
        }
    }

    /// Builds a raster from rows that come as files store them, the northern first.
    ///
    /// `read(first, into)` fills whole rows from row `first` on, counted from the north; it is
    /// asked for each row once and in order. No more than one row of tiles is held beside the
    /// raster.
    ///
    /// # Errors
    /// The first error of `read`, or what `refused` makes of it that there is not the memory for all
    /// posts.
    ///
    /// # Panics
    /// As [`TiledRaster::from_fn`].
    pub fn try_from_northern_rows<E>(
        cols: u32,
        rows: u32,
        refused: impl FnOnce(NoMemory) -> E,
        mut read: impl FnMut(u32, &mut [T]) -> Result<(), E>,
    ) -> Result<Self, E>
    where
        T: Default,
    {
        let (mut raster, mut slots) = Self::empty(cols, rows).map_err(refused)?;
        let (tiles_across, stride) = (raster.tiles_across, raster.stride);
        let tiles_up = (rows - 1).div_ceil(TILE_CELLS);
        let width = cols as usize;
        let mut band = vec![T::default(); width * rows.min(TILE_CELLS + 1) as usize];
        // Rows of tiles from the north; `north` and `south` are post rows, from the south.
        for tile_row in (0..tiles_up).rev() {
            let south = tile_row * TILE_CELLS;
            let north = (rows - 1).min(south + TILE_CELLS);
            let height = (north - south + 1) as usize;
            // The row shared with the tiles north of these has been read.
            let mut known = 0;
            if tile_row + 1 < tiles_up {
                let last = (rows - 1 - north).min(TILE_CELLS) as usize;
                band.copy_within(last * width..(last + 1) * width, 0);
                known = 1;
            }
            read(
                rows - 1 - north + known as u32,
                &mut band[known * width..height * width],
            )?;
            let band = &band;
            let first = (tile_row * tiles_across) as usize;
            let tiles = &mut slots[first..first + tiles_across as usize];
            tiles.par_iter_mut().enumerate().for_each(|(tile, slot)| {
                let west = tile * TILE_CELLS as usize;
                let rows = slot.items_mut().chunks_exact_mut(stride);
                for (row, posts) in (0..height).rev().zip(rows) {
                    for (col, to) in (west..).zip(posts) {
                        *to = band[row * width + col.min(width - 1)];
                    }
                }
            });
        }
        raster.tiles = slots.into_iter().map(Arc::new).collect();
        Ok(raster)
    }

    /// Number of posts from west to east.
    #[must_use]
    pub fn cols(&self) -> u32 {
        self.cols
    }

    /// Number of posts from south to north.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// The tiles' places, in the order in which they are stored.
    pub fn tile_indices(&self) -> impl ExactSizeIterator<Item = TileIndex> + use<T> {
        let across = self.tiles_across;
        (0..self.tiles.len() as u32).map(move |index| TileIndex {
            col: index % across,
            row: index / across,
        })
    }

    /// Whether there is such a tile.
    #[must_use]
    pub fn has_tile(&self, tile: TileIndex) -> bool {
        tile.col < self.tiles_across && tile.row < self.tiles.len() as u32 / self.tiles_across
    }

    /// All posts of one tile.
    #[must_use]
    pub fn tile_posts(&self, tile: TileIndex) -> &[T] {
        let tile = (tile.row * self.tiles_across + tile.col) as usize;
        &self.tiles[tile][..self.height(tile) * self.stride]
    }

    /// How far apart two rows begin within [`TiledRaster::tile_posts`], in posts: the same in all
    /// tiles of a raster. In a side's last tile, what lies beyond the raster repeats its last
    /// post.
    #[inline]
    #[must_use]
    pub fn tile_stride(&self) -> usize {
        self.stride
    }

    /// Number of tiles from west to east.
    #[must_use]
    pub fn tiles_across(&self) -> u32 {
        self.tiles_across
    }

    /// The posts of cell (`col`, `row`): south-west, south-east, north-west, north-east.
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    #[must_use]
    pub fn cell(&self, col: u32, row: u32) -> [T; 4] {
        let tile =
            &self.tiles[((row >> TILE_SHIFT) * self.tiles_across + (col >> TILE_SHIFT)) as usize];
        let at = (row & TILE_MASK) as usize * self.stride + (col & TILE_MASK) as usize;
        let south = &tile[at..at + 2];
        let north = &tile[at + self.stride..at + self.stride + 2];
        [south[0], south[1], north[0], north[1]]
    }

    /// The post at (`col`, `row`).
    ///
    /// # Panics
    /// Where there is no such post.
    #[inline]
    #[must_use]
    pub fn post(&self, col: u32, row: u32) -> T {
        // The last post of a side that ends on a tile border has no tile of its own.
        let tile_col = col.min(self.cols - 2) >> TILE_SHIFT;
        let tile_row = row.min(self.rows - 2) >> TILE_SHIFT;
        let tile = &self.tiles[(tile_row * self.tiles_across + tile_col) as usize];
        let (x, y) = (col - tile_col * TILE_CELLS, row - tile_row * TILE_CELLS);
        assert!(col < self.cols, "there is no post in column {col}");
        tile[y as usize * self.stride + x as usize]
    }

    /// Replaces one post in every tile that holds it; cheap while no snapshot shares the tiles.
    pub(crate) fn set(&mut self, col: u32, row: u32, value: T) {
        let spans = [(col, self.cols), (row, self.rows)].map(|(at, posts)| {
            let last = (posts - 1).div_ceil(TILE_CELLS) - 1;
            let own = (at >> TILE_SHIFT).min(last);
            let shared = at & TILE_MASK == 0 && at > 0;
            let first = if shared { (at >> TILE_SHIFT) - 1 } else { own };
            first..=own
        });
        for tile_row in spans[1].clone() {
            for tile_col in spans[0].clone() {
                let index = (tile_row * self.tiles_across + tile_col) as usize;
                let (x, y) = (col - tile_col * TILE_CELLS, row - tile_row * TILE_CELLS);
                let from = y as usize * self.stride + x as usize;
                let to = if col == self.cols - 1 {
                    (y as usize + 1) * self.stride
                } else {
                    from + 1
                };
                self.posts_mut(index)[from..to].fill(value);
            }
        }
    }

    /// The cell that holds `(x, y)`, in posts from the south-west one, and the place within it in
    /// [0, 1]². Points off the raster give the nearest cell's border.
    #[inline]
    #[must_use]
    pub fn locate(&self, x: f64, y: f64) -> ([u32; 2], [f64; 2]) {
        let x = x.clamp(0.0, f64::from(self.cols - 1));
        let y = y.clamp(0.0, f64::from(self.rows - 1));
        let col = (x as u32).min(self.cols - 2);
        let row = (y as u32).min(self.rows - 2);
        ([col, row], [x - f64::from(col), y - f64::from(row)])
    }

    /// Bytes held by the posts.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.tiles.iter().map(|tile| size_of_val(&***tile)).sum()
    }

    /// The tiles that hold any of the posts of `cols` by `rows` (half-open).
    #[must_use]
    pub fn tiles_of(
        &self,
        cols: &std::ops::Range<u32>,
        rows: &std::ops::Range<u32>,
    ) -> Vec<TileIndex> {
        let meets = |range: &std::ops::Range<u32>, posts: u32, tile: u32| {
            let first = tile * TILE_CELLS;
            range.start.max(first) < range.end.min(posts).min(first + TILE_CELLS + 1)
        };
        self.tile_indices()
            .filter(|index| meets(cols, self.cols, index.col) && meets(rows, self.rows, index.row))
            .collect()
    }

    /// A snapshot in which the posts of `cols` by `rows` (half-open) are replaced by `post`, and
    /// the tiles that hold any of them. All other tiles are shared with `self`.
    #[must_use]
    pub fn edited(
        &self,
        cols: std::ops::Range<u32>,
        rows: std::ops::Range<u32>,
        post: impl Fn(u32, u32, T) -> T,
    ) -> (Self, Vec<TileIndex>) {
        let mut result = self.clone();
        let mut changed = Vec::new();
        for index in self.tile_indices() {
            let (col0, row0) = (index.col * TILE_CELLS, index.row * TILE_CELLS);
            let slot = (index.row * self.tiles_across + index.col) as usize;
            let stride = self.stride;
            let height = self.height(slot) as u32;
            let width = (stride as u32).min(self.cols - col0);
            let col_range = cols.start.max(col0)..cols.end.min(col0 + width);
            let row_range = rows.start.max(row0)..rows.end.min(row0 + height);
            if col_range.is_empty() || row_range.is_empty() {
                continue;
            }
            let tile = result.posts_mut(slot);
            for row in row_range {
                for col in col_range.clone() {
                    let value = &mut tile[(row - row0) as usize * stride + (col - col0) as usize];
                    *value = post(col, row, *value);
                }
                if col_range.end == self.cols {
                    let begin = (row - row0) as usize * stride;
                    let last = tile[begin + width as usize - 1];
                    tile[begin + width as usize..begin + stride].fill(last);
                }
            }
            changed.push(index);
        }
        (result, changed)
    }

    /// A snapshot in which all posts of `tiles` are asked for anew, in parallel. All other tiles
    /// are shared with `self`; places off the raster are left out.
    ///
    /// Neighbours hold the posts on their common border too, so tiles that hold a post with a new
    /// value must be asked for together.
    #[must_use]
    pub fn with_tiles_renewed(
        &self,
        tiles: &[TileIndex],
        post: impl Fn(u32, u32) -> T + Sync,
    ) -> Self {
        self.with_rows_renewed(tiles, each_post(post))
    }

    /// As [`TiledRaster::with_tiles_renewed`], a tile's row at a time like
    /// [`TiledRaster::from_rows`].
    pub(crate) fn with_rows_renewed(
        &self,
        tiles: &[TileIndex],
        fill: impl Fn(u32, u32, &mut [T]) + Sync,
    ) -> Self {
        let mut result = self.clone();
        let renewed = self.tile_indices().enumerate();
        let numbers: Vec<_> = renewed
            .filter(|(_, index)| tiles.contains(index))
            .map(|(tile, _)| tile)
            .collect();
        // All at once: who moves for one of them leaves those behind that were taken before.
        let slots = result.free_slots(numbers.len());
        let renewed = numbers.iter().copied().zip(slots).collect();
        for (tile, slot) in numbers.into_iter().zip(self.filled(renewed, fill)) {
            result.tiles[tile] = slot;
        }
        result
    }

    /// Whether both are snapshots of a raster between which nothing was changed.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        let tiles = self.tiles.iter().zip(&other.tiles);
        self.tiles.len() == other.tiles.len()
            && self.cols == other.cols
            && tiles.into_iter().all(|(a, b)| Arc::ptr_eq(a, b))
    }

    /// Whether both rasters' tiles lie in the same memory.
    pub(crate) fn is_beside(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.slab, &other.slab)
    }

    /// The memory of the tiles of several rasters that lie beside one another, in their order.
    pub(crate) fn view_of<'a>(rasters: &'a [Self]) -> SlabView<'a, T> {
        let tiles = rasters.iter().flat_map(|raster| &raster.tiles);
        SlabView::new(&rasters[0].slab, tiles.map(|tile| &**tile))
    }

    /// The same raster in memory of its own.
    pub(crate) fn moved(&self) -> Self {
        Self::from_rows(self.cols, self.rows, |row, col, into| {
            self.copy_row(i64::from(col), i64::from(row), into);
        })
    }

    /// Whether both snapshots hold the very same tile.
    #[cfg(test)]
    pub(crate) fn shares(&self, other: &Self, tile: TileIndex) -> bool {
        let slot = (tile.row * self.tiles_across + tile.col) as usize;
        Arc::ptr_eq(&self.tiles[slot], &other.tiles[slot])
    }
}

/// Fills rows post by post.
fn each_post<T>(post: impl Fn(u32, u32) -> T) -> impl Fn(u32, u32, &mut [T]) {
    move |row, col0, into| {
        for (col, to) in (col0..).zip(into) {
            *to = post(col, row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_copied_over_tile_borders_and_beyond_the_raster() {
        for (cols, rows) in [(600, 515), (2, 2), (257, 300), (258, 257)] {
            let raster = TiledRaster::from_fn(cols, rows, |col, row| col * 1000 + row);
            for row in [-3, 0, 1, 255, 256, 257, 512, 513, 514, 999] {
                for (col, len) in [(-5, 620), (255, 4), (256, 1), (0, 2), (599, 3), (700, 2)] {
                    let mut copy = vec![0; len];
                    raster.copy_row(col, row, &mut copy);
                    let clamp = |at: i64, posts: u32| at.clamp(0, i64::from(posts) - 1) as u32;
                    for (at, &post) in (col..).zip(&copy) {
                        assert_eq!(post, raster.post(clamp(at, cols), clamp(row, rows)));
                    }
                }
            }
        }
    }

    #[test]
    fn cells_across_tile_borders_have_the_right_posts() {
        let raster = TiledRaster::from_fn(600, 515, |col, row| (col, row));
        for (col, row) in [
            (0, 0),
            (255, 255),
            (256, 255),
            (255, 256),
            (511, 511),
            (598, 513),
        ] {
            let cell = raster.cell(col, row);
            assert_eq!(
                cell,
                [
                    (col, row),
                    (col + 1, row),
                    (col, row + 1),
                    (col + 1, row + 1)
                ]
            );
        }
        assert_eq!(raster.post(599, 514), (599, 514));
        assert_eq!(raster.post(0, 514), (0, 514));
    }

    #[test]
    fn rows_from_the_north_give_the_same_raster_and_each_is_asked_for_once() {
        for (cols, rows) in [(2, 2), (600, 515), (257, 513), (5, 514), (300, 258)] {
            let mut next = 0;
            let read = TiledRaster::try_from_northern_rows(cols, rows, drop, |first, into| {
                assert_eq!(first, next);
                for (row, posts) in into.chunks_mut(cols as usize).enumerate() {
                    for (col, post) in posts.iter_mut().enumerate() {
                        *post = (col as u32, rows - 1 - first - row as u32);
                    }
                }
                next = first + into.len() as u32 / cols;
                Ok::<(), ()>(())
            })
            .unwrap();
            assert_eq!(next, rows);
            let made = TiledRaster::from_fn(cols, rows, |col, row| (col, row));
            for tile in made.tile_indices() {
                assert_eq!(read.tile_posts(tile), made.tile_posts(tile));
            }
        }
    }

    #[test]
    fn a_post_that_is_set_reaches_every_tile_that_holds_it() {
        let mut raster = TiledRaster::from_fn(513, 300, |_, _| 0);
        for (col, row) in [(256, 256), (512, 0), (0, 299), (100, 256)] {
            raster.set(col, row, 7);
            let (edited, _) = raster.edited(col..col + 1, row..row + 1, |_, _, _| 7);
            for tile in raster.tile_indices() {
                // An edit is known to reach every copy of the post.
                assert_eq!(raster.tile_posts(tile), edited.tile_posts(tile));
            }
            assert_eq!(raster.post(col, row), 7);
            raster.set(col, row, 0);
        }
    }

    #[test]
    fn an_edit_reaches_every_tile_that_holds_the_post_and_no_other() {
        let raster = TiledRaster::from_fn(600, 515, |_, _| 0);
        let (edited, changed) = raster.edited(256..257, 256..257, |_, _, _| 7);
        assert_eq!(changed.len(), 4);
        assert_eq!(changed, raster.tiles_of(&(256..257), &(256..257)));
        assert_eq!(raster.tiles_of(&(255..256), &(500..900)).len(), 2);
        assert_eq!(raster.tiles_of(&(7..7), &(0..900)), []);
        assert_eq!(edited.cell(255, 255), [0, 0, 0, 7]);
        assert_eq!(edited.cell(256, 256), [7, 0, 0, 0]);
        assert_eq!(raster.cell(256, 256), [0; 4]);
    }

    #[test]
    fn renewed_tiles_are_new_and_the_rest_is_shared() {
        let raster = TiledRaster::from_fn(300, 600, |col, row| col + 1000 * row);
        let tile = TileIndex { col: 1, row: 1 };
        let off = TileIndex { col: 2, row: 0 };
        let renewed = raster.with_tiles_renewed(&[tile, off], |col, row| 7 + col + 1000 * row);
        for index in raster.tile_indices() {
            assert_eq!(raster.shares(&renewed, index), index != tile);
        }
        let fresh = TiledRaster::from_fn(300, 600, |col, row| 7 + col + 1000 * row);
        assert_eq!(renewed.tile_posts(tile), fresh.tile_posts(tile));
    }

    #[test]
    fn more_tiles_than_there_is_room_for_move_together() {
        let raster = TiledRaster::from_fn(2000, 1800, |col, row| col + 10_000 * row);
        let all: Vec<_> = raster.tile_indices().collect();
        // Snapshots that are held leave their slots to nobody.
        let mut held = vec![raster];
        for more in 1..5 {
            let post = |col: u32, row: u32| more + col + 10_000 * row;
            let renewed = held[held.len() - 1].with_tiles_renewed(&all, post);
            let view = renewed.view();
            for (number, &tile) in all.iter().enumerate() {
                let posts = renewed.tile_posts(tile);
                assert_eq!(posts[0], post(tile.col * TILE_CELLS, tile.row * TILE_CELLS));
                assert_eq!(view.nth(number)[..posts.len()], *posts);
            }
            held.push(renewed);
        }
        assert_eq!(held[0].post(1999, 1799), 17_991_999);
    }

    #[test]
    fn the_smallest_raster_is_one_cell() {
        let raster = TiledRaster::from_fn(2, 2, |col, row| col + 10 * row);
        assert_eq!(raster.cell(0, 0), [0, 1, 10, 11]);
        assert_eq!(raster.locate(1.0, 1.0), ([0, 0], [1.0, 1.0]));
        assert_eq!(raster.locate(-3.0, f64::NAN).0, [0, 0]);
    }
}
