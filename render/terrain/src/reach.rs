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
}
