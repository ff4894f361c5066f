//! The boundary array: in each column of cells, the lowest and highest that the surface pierces.

use super::VoxelShape;
use crate::{Ground, TILE_CELLS, TileIndex, TiledCells};
use std::ops::Range;

/// On which side of the surface a cell lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CellFlag {
    /// All eight voxels are above the surface.
    Above,
    /// Voxels are on both sides: the surface pierces the cell.
    Boundary,
    /// All eight voxels are below the surface.
    Below,
}

/// The lowest and highest boundary cell of each column of cells (Wan, Qu, Kaufman 1999,
/// section 3).
///
/// As densities never rise with the level, the cells of a column are below, on and above the
/// surface in this order, and each column has at least one boundary cell. These two levels
/// stand for a flag a cell.
#[derive(Clone, Debug)]
pub struct BoundaryArray {
    spans: TiledCells<[i16; 2]>,
    threshold: u8,
}

impl BoundaryArray {
    pub(super) fn new(spans: TiledCells<[i16; 2]>, threshold: u8) -> Self {
        Self { spans, threshold }
    }

    /// The boundary cells of a ground's binary voxels, straight from its heights; the same as
    /// those of a volume without a filter, and of one under an oriented box at threshold 127.
    ///
    /// Takes a shape with distinct slices; any other gives levels without meaning.
    #[must_use]
    pub fn from_heights(ground: &Ground, shape: VoxelShape) -> Self {
        let grid = ground.grid();
        let spans = TiledCells::from_tiles(grid.cols - 1, grid.rows - 1, |index, cols, rows| {
            Self::spans_of_heights(ground, shape, index, &cols, &rows)
        });
        Self::new(spans, 127)
    }

    /// The array of [`BoundaryArray::from_heights`] after an edit of the tiles `changed`, which
    /// are all that hold a changed height. Other tiles are shared with `self`, which must have
    /// been made by [`BoundaryArray::from_heights`] with the same shape.
    #[must_use]
    pub fn from_heights_updated(
        &self,
        ground: &Ground,
        shape: VoxelShape,
        changed: &[TileIndex],
    ) -> Self {
        let grid = ground.grid();
        if (self.spans.cols() + 1, self.spans.rows() + 1) != (grid.cols, grid.rows) {
            return Self::from_heights(ground, shape);
        }
        let spans = self.spans.with_tiles(changed, |index, cols, rows| {
            Self::spans_of_heights(ground, shape, index, &cols, &rows)
        });
        Self::new(spans, self.threshold)
    }

    fn spans_of_heights(
        ground: &Ground,
        shape: VoxelShape,
        index: TileIndex,
        cols: &Range<u32>,
        rows: &Range<u32>,
    ) -> Vec<[i16; 2]> {
        debug_assert_eq!(cols.start, index.col * TILE_CELLS);
        let posts = ground.heights().tile_posts(index);
        let stride = ground.heights().tile_stride();
        Self::tile_spans(cols.len(), rows.len(), |col, row| {
            shape.first_above(posts[row * stride + col]) as i16
        })
    }

    /// The spans of a tile of `cols` by `rows` cells from the first level above the surface at
    /// each of its posts.
    pub(super) fn tile_spans(
        cols: usize,
        rows: usize,
        first_above: impl Fn(usize, usize) -> i16,
    ) -> Vec<[i16; 2]> {
        let row_of = |row: usize| (0..=cols).map(|col| first_above(col, row)).collect();
        let mut spans = Vec::with_capacity(cols * rows);
        let mut south: Vec<i16> = row_of(0);
        for row in 1..=rows {
            let north: Vec<i16> = row_of(row);
            spans.extend(
                south
                    .windows(2)
                    .zip(north.windows(2))
                    .map(|(south, north)| {
                        let [sw, se, nw, ne] = [south[0], south[1], north[0], north[1]];
                        // The highest cell that is wholly below has its upper slice under the lowest
                        // column's first level above; the lowest that is wholly above has its lower
                        // slice on the highest column's.
                        [
                            sw.min(se).min(nw).min(ne) - 1,
                            sw.max(se).max(nw).max(ne) - 1,
                        ]
                    }),
            );
            south = north;
        }
        spans
    }

    /// The lowest and the highest boundary cell in a column of cells.
    ///
    /// # Panics
    /// Where there is no such column.
    #[inline]
    #[must_use]
    pub fn span(&self, col: u32, row: u32) -> [i16; 2] {
        self.spans.get(col, row)
    }

    /// On which side of the surface a cell lies.
    ///
    /// # Panics
    /// Where there is no such column.
    #[inline]
    #[must_use]
    pub fn flag(&self, col: u32, row: u32, level: i32) -> CellFlag {
        let [lowest, highest] = self.span(col, row).map(i32::from);
        if level < lowest {
            CellFlag::Below
        } else if level <= highest {
            CellFlag::Boundary
        } else {
            CellFlag::Above
        }
    }

    /// All spans.
    #[must_use]
    pub fn spans(&self) -> &TiledCells<[i16; 2]> {
        &self.spans
    }

    /// The density that is not below the surface; 127 for an array from heights.
    #[must_use]
    pub fn threshold(&self) -> u8 {
        self.threshold
    }

    /// Bytes held by the array.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.spans.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn cells_are_below_on_and_above_a_step_in_this_order() {
        // Heights 2.5 and 5 over slices a metre apart: first levels above are 3 and 5.
        let ground = Ground::from_fn(2, 2, DVec2::ONE, |col, _| [2.5, 5.0][col as usize]).unwrap();
        let shape = VoxelShape {
            base: 0.0,
            height: 1.0,
            levels: 64,
        };
        let boundary = BoundaryArray::from_heights(&ground, shape);
        assert_eq!(boundary.span(0, 0), [2, 4]);
        let flags = (0..7).map(|level| boundary.flag(0, 0, level));
        use CellFlag::{Above, Below, Boundary};
        assert!(flags.eq([Below, Below, Boundary, Boundary, Boundary, Above, Above]));
    }
}
