//! The volume of densities, packed down to what lies near the surface.

use super::boundary::BoundaryArray;
use super::column::Run;
use super::gaussian::{Gaussian, Profile};
use super::oriented_box::{OrientedBox, slope_at};
use super::packed::PackedTile;
use super::{DensityFilter, VoxelError, VoxelShape};
use crate::{Grid, Ground, TILE_CELLS, TileIndex, TiledCells, reach};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

const SHIFT: u32 = TILE_CELLS.trailing_zeros();
const MASK: u32 = TILE_CELLS - 1;

/// The densities of a ground's voxels (Wan, Qu, Kaufman 1999, section 3).
///
/// Each column keeps only its densities between 255 and 0, four bytes to find them, and nothing
/// for the rest, so a volume grows with the ground's area and not with its number of slices.
/// Tiles are those of a [`TiledRaster`](crate::TiledRaster): neighbours both hold the columns on
/// their common border, so that a cell is read from one tile. They are shared between snapshots.
#[derive(Clone, Debug)]
pub struct VoxelVolume {
    grid: Grid,
    shape: VoxelShape,
    filter: DensityFilter,
    tiles_across: u32,
    tiles: Vec<Arc<PackedTile>>,
}

/// What makes the columns of a tile.
enum Columns {
    Binary,
    Gaussian(Gaussian),
    OrientedBox(OrientedBox),
}

impl VoxelVolume {
    /// Makes the volume of a ground, tiles in parallel.
    ///
    /// # Errors
    /// [`VoxelError`] for a shape without distinct slices and a filter without a sound size.
    pub fn new(
        ground: &Ground,
        shape: VoxelShape,
        filter: DensityFilter,
    ) -> Result<Self, VoxelError> {
        Ok(Self::made(ground, shape.check()?, filter.check()?))
    }

    /// [`VoxelVolume::new`] for a shape and a filter that have been found sound.
    fn made(ground: &Ground, shape: VoxelShape, filter: DensityFilter) -> Self {
        let columns = Columns::new(ground, shape, filter);
        let indices: Vec<_> = ground.heights().tile_indices().collect();
        let grid = ground.grid();
        Self {
            grid,
            shape,
            filter,
            tiles_across: (grid.cols - 1).div_ceil(TILE_CELLS),
            tiles: indices
                .into_par_iter()
                .map(|index| Arc::new(columns.tile(ground, shape, index)))
                .collect(),
        }
    }

    /// The volume after an edit: equal to one made anew from `ground` with the same shape and
    /// filter, made of the tiles that the edit can reach and sharing all others.
    ///
    /// `changed` has all tiles that hold a changed height. A surface that leaves the shape's
    /// range is held up to the limits of [`VoxelShape`] and cut off there. A ground on another
    /// grid gives a volume made anew.
    #[must_use]
    pub fn updated(&self, ground: &Ground, changed: &[TileIndex]) -> Self {
        if ground.grid() != self.grid {
            return Self::made(ground, self.shape, self.filter);
        }
        let columns = Columns::new(ground, self.shape, self.filter);
        let renewed: Vec<_> = self
            .renewed_tiles(changed)
            .into_par_iter()
            .map(|index| (index, Arc::new(columns.tile(ground, self.shape, index))))
            .collect();
        let mut result = self.clone();
        for (index, tile) in renewed {
            result.tiles[(index.row * self.tiles_across + index.col) as usize] = tile;
        }
        result
    }

    /// The tiles that an edit of the `changed` ones can reach through the filter.
    #[must_use]
    pub fn renewed_tiles(&self, changed: &[TileIndex]) -> Vec<TileIndex> {
        if self.filter.radius() == 0 {
            let indices = self.tile_indices();
            return indices.filter(|index| changed.contains(index)).collect();
        }
        reach::with_neighbours(changed, self.grid.cols, self.grid.rows)
    }

    /// Where the slices lie.
    #[must_use]
    pub fn shape(&self) -> VoxelShape {
        self.shape
    }

    /// How the densities were filtered.
    #[must_use]
    pub fn filter(&self) -> DensityFilter {
        self.filter
    }

    /// The posts on which the columns stand.
    #[must_use]
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// The tiles' places, in the order in which they are stored.
    pub fn tile_indices(&self) -> impl ExactSizeIterator<Item = TileIndex> + use<> {
        let across = self.tiles_across;
        (0..self.tiles.len() as u32).map(move |slot| TileIndex {
            col: slot % across,
            row: slot / across,
        })
    }

    fn tile(&self, col: u32, row: u32) -> &PackedTile {
        &self.tiles[(row * self.tiles_across + col) as usize]
    }

    /// The density of one voxel; 255 anywhere under the ground, 0 anywhere over it.
    ///
    /// # Panics
    /// Where there is no such post.
    #[must_use]
    pub fn density(&self, col: u32, row: u32, level: i32) -> u8 {
        assert!(
            col < self.grid.cols && row < self.grid.rows,
            "there is no post in column {col}, row {row}"
        );
        // The last post of a side that ends on a tile border has no tile of its own.
        let tile_col = col.min(self.grid.cols - 2) >> SHIFT;
        let tile_row = row.min(self.grid.rows - 2) >> SHIFT;
        let (x, y) = (col - tile_col * TILE_CELLS, row - tile_row * TILE_CELLS);
        self.tile(tile_col, tile_row)
            .density(x as usize, y as usize, level)
    }

    /// The densities of a cell's eight voxels: south-west, south-east, north-west, north-east at
    /// `level`, then the same at `level` + 1. Any level may be asked for.
    ///
    /// # Panics
    /// May panic where there is no such column of cells; if not, the densities are those of some
    /// other cell.
    #[inline]
    #[must_use]
    pub fn cell(&self, col: u32, row: u32, level: i32) -> [u8; 8] {
        let tile = self.tile(col >> SHIFT, row >> SHIFT);
        tile.cell((col & MASK) as usize, (row & MASK) as usize, level)
    }

    /// Bytes held by the packed densities and their index.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.tiles.iter().map(|tile| tile.bytes()).sum()
    }

    /// Bytes of the same volume with each voxel stored: columns · rows · levels.
    #[must_use]
    pub fn full_bytes(&self) -> usize {
        self.grid.posts() as usize * self.shape.levels as usize
    }

    /// The boundary cells, where a voxel is below the surface if its density is above
    /// `threshold`. A threshold of 255 would leave nothing below and is taken as 254.
    #[must_use]
    pub fn boundary(&self, threshold: u8) -> BoundaryArray {
        let threshold = threshold.min(254);
        let spans = TiledCells::from_tiles(
            self.grid.cols - 1,
            self.grid.rows - 1,
            |index, cols, rows| self.spans(index, cols.len(), rows.len(), threshold),
        );
        BoundaryArray::new(spans, threshold)
    }

    /// The boundary cells after an edit of the ground's tiles `changed`: `self` is the volume
    /// after the edit, `old` the boundary of the volume before it. Equal to
    /// [`VoxelVolume::boundary`] with the same threshold; tiles out of the edit's reach are
    /// shared with `old`.
    #[must_use]
    pub fn boundary_updated(&self, old: &BoundaryArray, changed: &[TileIndex]) -> BoundaryArray {
        let threshold = old.threshold();
        let spans = old.spans();
        if (spans.cols() + 1, spans.rows() + 1) != (self.grid.cols, self.grid.rows) {
            return self.boundary(threshold);
        }
        let renewed = spans.with_tiles(&self.renewed_tiles(changed), |index, cols, rows| {
            self.spans(index, cols.len(), rows.len(), threshold)
        });
        BoundaryArray::new(renewed, threshold)
    }

    /// The boundary cells' spans in one tile of `cols` by `rows` cells.
    fn spans(&self, index: TileIndex, cols: usize, rows: usize, threshold: u8) -> Vec<[i16; 2]> {
        let tile = self.tile(index.col, index.row);
        BoundaryArray::tile_spans(cols, rows, |col, row| tile.first_above(col, row, threshold))
    }
}

impl Columns {
    fn new(ground: &Ground, shape: VoxelShape, filter: DensityFilter) -> Self {
        match filter {
            DensityFilter::None => Self::Binary,
            DensityFilter::Gaussian { sigma } => {
                Self::Gaussian(Gaussian::new(sigma, filter.radius() as usize))
            }
            DensityFilter::OrientedBox { width } => {
                Self::OrientedBox(OrientedBox::new(width, shape, ground.grid().spacing))
            }
        }
    }

    fn tile(&self, ground: &Ground, shape: VoxelShape, index: TileIndex) -> PackedTile {
        let grid = ground.grid();
        let posts = |tile: u32, posts: u32| {
            let first = tile * TILE_CELLS;
            first..posts.min(first + TILE_CELLS + 1)
        };
        let (cols, rows) = (posts(index.col, grid.cols), posts(index.row, grid.rows));
        let post = |x: usize, y: usize| (cols.start + x as u32, rows.start + y as u32);
        match self {
            Self::Binary => PackedTile::new(cols.len(), rows.len(), |x, y, run| {
                let (col, row) = post(x, y);
                run.set_binary(shape.first_above(ground.heights().post(col, row)));
            }),
            Self::OrientedBox(filter) => PackedTile::new(cols.len(), rows.len(), |x, y, run| {
                let (col, row) = post(x, y);
                let slope = slope_at(ground.heights(), grid.spacing, col, row);
                filter.column(ground.heights().post(col, row), slope, run);
            }),
            Self::Gaussian(filter) => {
                gaussian_tile(filter, ground, shape, cols.clone(), rows.clone())
            }
        }
    }
}

/// A tile under a Gaussian: the first levels above the surface are found once a
/// post, with a margin around the tile.
fn gaussian_tile(
    filter: &Gaussian,
    ground: &Ground,
    shape: VoxelShape,
    cols: Range<u32>,
    rows: Range<u32>,
) -> PackedTile {
    let radius = filter.radius();
    let around = |range: &Range<u32>, posts: u32| {
        // Beyond the border the outermost posts repeat.
        (i64::from(range.start) - radius as i64..i64::from(range.end) + radius as i64)
            .map(move |at| at.clamp(0, i64::from(posts - 1)) as u32)
    };
    let grid = ground.grid();
    let pitch = cols.len() + 2 * radius;
    let mut firsts = Vec::with_capacity(pitch * (rows.len() + 2 * radius));
    for row in around(&rows, grid.rows) {
        firsts.extend(
            around(&cols, grid.cols).map(|col| shape.first_above(ground.heights().post(col, row))),
        );
    }
    let mut profile = Profile::default();
    let taps = 2 * radius + 1;
    PackedTile::new(cols.len(), rows.len(), |x, y, run: &mut Run| {
        let rows = (y..y + taps).map(|row| &firsts[row * pitch + x..][..taps]);
        filter.column(rows, &mut profile, run);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn an_update_makes_what_it_reaches_and_shares_the_rest() {
        let ground = Ground::from_fn(800, 300, DVec2::ONE, |col, row| {
            ((col * 7 + row * 13) % 11) as f32
        })
        .unwrap();
        let (edited, changed) = ground.edited(600..610, 20..30, |_, _, _| 5.0).unwrap();
        assert_eq!(changed, [TileIndex { col: 2, row: 0 }]);
        for (filter, reached) in [
            (DensityFilter::None, 1),
            (DensityFilter::Gaussian { sigma: 1.0 }, 6),
            (DensityFilter::OrientedBox { width: 2.0 }, 6),
        ] {
            let before = VoxelVolume::new(&ground, VoxelShape::cubic(&ground), filter).unwrap();
            let after = before.updated(&edited, &changed);
            let shared = before.tiles.iter().zip(&after.tiles);
            let shared = shared.filter(|(a, b)| Arc::ptr_eq(a, b)).count();
            assert_eq!(shared, before.tiles.len() - reached, "{filter:?}");
            let fresh = VoxelVolume::new(&edited, before.shape, filter).unwrap();
            assert_eq!(after.tiles, fresh.tiles, "{filter:?}");
            let (old, new) = (before.boundary(127), after.boundary(127));
            let updated = after.boundary_updated(&old, &changed);
            for index in new.spans().tile_indices() {
                let renewed = after.renewed_tiles(&changed).contains(&index);
                assert_eq!(updated.spans().shares(old.spans(), index), !renewed);
            }
        }
    }
}
