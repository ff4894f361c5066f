//! Values of cells, cut into square tiles.

use crate::{TILE_CELLS, TileIndex};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

const SHIFT: u32 = TILE_CELLS.trailing_zeros();
const MASK: u32 = TILE_CELLS - 1;

/// One tile's cells, row by row from its south-west corner.
#[derive(Debug)]
struct Tile<T> {
    stride: usize,
    cells: Box<[T]>,
}

/// A raster of cells in tiles of [`TILE_CELLS`]² cells. Row 0 is south.
///
/// It lies over a [`TiledRaster`](crate::TiledRaster) of one post more a side: tile for tile and
/// cell for cell, without a shared border. Tiles are shared between snapshots: a clone copies no
/// cells.
#[derive(Clone, Debug)]
pub struct TiledCells<T> {
    cols: u32,
    rows: u32,
    tiles_across: u32,
    tiles: Vec<Arc<Tile<T>>>,
}

impl<T: Copy + Send + Sync> TiledCells<T> {
    /// Builds a raster of `cols` by `rows` cells from a function of column and row, tiles in
    /// parallel.
    ///
    /// # Panics
    /// Where a side has no cell.
    pub fn from_fn(cols: u32, rows: u32, cell: impl Fn(u32, u32) -> T + Sync) -> Self {
        Self::from_tiles(cols, rows, |_, tile_cols, tile_rows| {
            each_cell(tile_cols, tile_rows, &cell)
        })
    }

    /// Builds a raster tile by tile, in parallel: `tile` gets a tile's place and its columns and
    /// rows, and answers its cells row by row from the south-west.
    pub(crate) fn from_tiles(
        cols: u32,
        rows: u32,
        tile: impl Fn(TileIndex, Range<u32>, Range<u32>) -> Vec<T> + Sync,
    ) -> Self {
        assert!(
            cols >= 1 && rows >= 1,
            "a raster of {cols} by {rows} cells has no cell"
        );
        let tiles_across = cols.div_ceil(TILE_CELLS);
        let mut result = Self {
            cols,
            rows,
            tiles_across,
            tiles: Vec::new(),
        };
        result.tiles = (0..tiles_across * rows.div_ceil(TILE_CELLS))
            .into_par_iter()
            .map(|index| result.build(result.index(index), &tile))
            .collect();
        result
    }

    fn build(
        &self,
        index: TileIndex,
        tile: &impl Fn(TileIndex, Range<u32>, Range<u32>) -> Vec<T>,
    ) -> Arc<Tile<T>> {
        let span = |first: u32, cells: u32| first..cells.min(first + TILE_CELLS);
        let cols = span(index.col * TILE_CELLS, self.cols);
        let rows = span(index.row * TILE_CELLS, self.rows);
        let (stride, count) = (cols.len(), cols.len() * rows.len());
        let cells = tile(index, cols, rows).into_boxed_slice();
        assert_eq!(cells.len(), count, "a tile has a value for each cell");
        Arc::new(Tile { stride, cells })
    }

    fn index(&self, slot: u32) -> TileIndex {
        TileIndex {
            col: slot % self.tiles_across,
            row: slot / self.tiles_across,
        }
    }

    /// A snapshot in which the cells of `tiles` are asked for anew, in parallel; all other tiles
    /// are shared with `self`. Places off the raster are left out.
    #[must_use]
    pub fn with_tiles_renewed(
        &self,
        tiles: &[TileIndex],
        cell: impl Fn(u32, u32) -> T + Sync,
    ) -> Self {
        self.with_tiles(tiles, |_, cols, rows| each_cell(cols, rows, &cell))
    }

    /// [`TiledCells::with_tiles_renewed`] a whole tile at a time, as [`TiledCells::from_tiles`].
    pub(crate) fn with_tiles(
        &self,
        tiles: &[TileIndex],
        tile: impl Fn(TileIndex, Range<u32>, Range<u32>) -> Vec<T> + Sync,
    ) -> Self {
        let mut result = self.clone();
        let tiles_up = self.rows.div_ceil(TILE_CELLS);
        result
            .tiles
            .par_iter_mut()
            .enumerate()
            .map(|(slot, tile)| (self.index(slot as u32), tile))
            .filter(|(index, _)| index.row < tiles_up && tiles.contains(index))
            .for_each(|(index, slot)| *slot = self.build(index, &tile));
        result
    }

    /// Number of cells from west to east.
    #[must_use]
    pub fn cols(&self) -> u32 {
        self.cols
    }

    /// Number of cells from south to north.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// The tiles' places, in the order in which they are stored.
    pub fn tile_indices(&self) -> impl ExactSizeIterator<Item = TileIndex> + use<T> {
        let across = self.tiles_across;
        (0..self.tiles.len() as u32).map(move |slot| TileIndex {
            col: slot % across,
            row: slot / across,
        })
    }

    /// The value of cell (`col`, `row`).
    ///
    /// # Panics
    /// Where there is no such cell.
    #[inline]
    #[must_use]
    pub fn get(&self, col: u32, row: u32) -> T {
        // A column past the last one could otherwise be read from the next row or tile.
        assert!(col < self.cols, "there is no cell in column {col}");
        let tile = &self.tiles[((row >> SHIFT) * self.tiles_across + (col >> SHIFT)) as usize];
        tile.cells[(row & MASK) as usize * tile.stride + (col & MASK) as usize]
    }

    /// Bytes held by the cells.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.tiles
            .iter()
            .map(|tile| size_of_val(&*tile.cells))
            .sum()
    }

    /// Whether both snapshots hold the very same tile.
    #[cfg(test)]
    pub(crate) fn shares(&self, other: &Self, tile: TileIndex) -> bool {
        let slot = (tile.row * self.tiles_across + tile.col) as usize;
        Arc::ptr_eq(&self.tiles[slot], &other.tiles[slot])
    }
}

fn each_cell<T>(cols: Range<u32>, rows: Range<u32>, cell: &impl Fn(u32, u32) -> T) -> Vec<T> {
    let mut cells = Vec::with_capacity(cols.len() * rows.len());
    for row in rows {
        cells.extend(cols.clone().map(|col| cell(col, row)));
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_where_it_was_put() {
        for (cols, rows) in [(1, 1), (256, 257), (600, 3), (257, 512)] {
            let cells = TiledCells::from_fn(cols, rows, |col, row| (col, row));
            assert_eq!((cells.cols(), cells.rows()), (cols, rows));
            assert_eq!(cells.bytes(), 8 * (cols * rows) as usize);
            for row in 0..rows {
                for col in 0..cols {
                    assert_eq!(cells.get(col, row), (col, row));
                }
            }
        }
    }

    #[test]
    fn renewed_tiles_are_new_and_the_rest_is_shared() {
        let cells = TiledCells::from_fn(300, 300, |_, _| 0);
        let tile = TileIndex { col: 1, row: 0 };
        let off = TileIndex { col: 2, row: 0 };
        let renewed = cells.with_tiles_renewed(&[tile, off], |col, row| col * 1000 + row);
        for index in cells.tile_indices() {
            assert_eq!(cells.shares(&renewed, index), index != tile);
        }
        assert_eq!(renewed.get(256, 255), 256_255);
        assert_eq!(renewed.get(255, 255), 0);
        assert_eq!(renewed.get(256, 256), 0);
        assert_eq!(cells.get(256, 255), 0);
    }

    #[test]
    #[should_panic(expected = "there is no cell in column 3")]
    fn a_column_past_the_last_is_not_read_from_the_next_row() {
        let _ = TiledCells::from_fn(3, 2, |_, _| 0).get(3, 0);
    }
}
