//! Which tiles a change reaches, in what is derived from the ground.

use crate::{TILE_CELLS, TileIndex};

/// Tiles along a side of `posts` posts.
fn tiles_along(posts: u32) -> u32 {
    (posts - 1).div_ceil(TILE_CELLS)
}

/// The changed tiles of a raster of `cols` by `rows` posts and all that touch them, without
/// repetition.
///
/// These are the tiles whose values can differ where a value depends on posts up to
/// [`TILE_CELLS`] away: no tile is narrower but the last of a side, and nothing lies behind that.
pub(crate) fn with_neighbours(changed: &[TileIndex], cols: u32, rows: u32) -> Vec<TileIndex> {
    tiles_where(cols, rows, |tile| {
        changed
            .iter()
            .any(|at| at.col.abs_diff(tile.col) <= 1 && at.row.abs_diff(tile.row) <= 1)
    })
}

/// The tiles of a raster of `cols` by `rows` posts that depend on changed tiles of the raster of
/// twice its density, where post i depends on posts 2i − 2 to 2i + 3 at most.
pub(crate) fn coarser(changed: &[TileIndex], cols: u32, rows: u32) -> Vec<TileIndex> {
    // Tile k has posts 256 k to 256 k + 256, so it depends on posts 512 k − 2 to 512 k + 515,
    // which are in tiles 2 k − 1 to 2 k + 2.
    let depends = |coarse: u32, fine: u32| (2 * coarse..=2 * coarse + 3).contains(&(fine + 1));
    tiles_where(cols, rows, |tile| {
        changed
            .iter()
            .any(|at| depends(tile.col, at.col) && depends(tile.row, at.row))
    })
}

/// All tiles of a raster of `cols` by `rows` posts.
pub(crate) fn all(cols: u32, rows: u32) -> Vec<TileIndex> {
    tiles_where(cols, rows, |_| true)
}

fn tiles_where(cols: u32, rows: u32, reached: impl Fn(TileIndex) -> bool) -> Vec<TileIndex> {
    (0..tiles_along(rows))
        .flat_map(|row| (0..tiles_along(cols)).map(move |col| TileIndex { col, row }))
        .filter(|&tile| reached(tile))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(col: u32, row: u32) -> TileIndex {
        TileIndex { col, row }
    }

    #[test]
    fn neighbours_end_at_the_border_and_come_once() {
        let reached = with_neighbours(&[at(0, 0), at(1, 0)], 1025, 600);
        assert_eq!(
            reached,
            [at(0, 0), at(1, 0), at(2, 0), at(0, 1), at(1, 1), at(2, 1)]
        );
        assert!(with_neighbours(&[], 1025, 600).is_empty());
    }

    #[test]
    fn a_coarser_tile_depends_on_those_within_its_filter() {
        // Eight tiles across become four; the filter looks one post over the border.
        let reached = |col| -> Vec<u32> {
            let tiles = coarser(&[at(col, 0)], 1025, 2);
            tiles.iter().map(|tile| tile.col).collect()
        };
        assert_eq!(reached(0), [0]);
        assert_eq!(reached(1), [0, 1]);
        assert_eq!(reached(2), [0, 1]);
        assert_eq!(reached(3), [1, 2]);
        assert_eq!(reached(7), [3]);
    }
}
