//! The same ground on a finer grid.

use super::{Grid, Ground, tile_range};
use crate::{TILE_CELLS, TileIndex, TiledRaster};
use bytemuck::Zeroable;
use rayon::prelude::*;

impl Ground {
    /// The same ground with `times` by `times` cells for each of its own: its heights are those of the
    /// same surface, so that a finer photograph has a post for each of its pixels. Which posts were
    /// filled in is not told.
    ///
    /// # Panics
    /// Where `times` is 0.
    #[must_use]
    pub fn refined(&self, times: u32) -> Self {
        assert!(times > 0, "no cell can be divided by 0");
        let grid = Grid {
            cols: (self.grid.cols - 1) * times + 1,
            rows: (self.grid.rows - 1) * times + 1,
            spacing: self.grid.spacing / f64::from(times),
        };
        let Grid { cols, rows, .. } = grid;
        let heights = TiledRaster::from_rows(cols, rows, lines(&self.heights, times, height));
        let tiles: Vec<_> = heights.tile_indices().collect();
        let tile_ranges = tiles
            .into_par_iter()
            .map(|tile| range_of(&heights, tile))
            .collect();
        let light = self.light.as_ref();
        Self {
            grid,
            tile_ranges,
            heights,
            range: self.range,
            light: light.map(|light| TiledRaster::from_rows(cols, rows, lines(light, times, code))),
            photo: self.photo.clone(),
            holes: None,
        }
    }

    /// What [`Ground::refined`] with so many `times` makes of `ground`, if this one is what it made of
    /// another one, of which the tiles `changed` hold all posts that have another height or light; and
    /// the tiles that may differ from this one's. The others are shared.
    #[must_use]
    pub fn refined_again(
        &self,
        ground: &Self,
        times: u32,
        changed: &[TileIndex],
    ) -> (Self, Vec<TileIndex>) {
        // Tiles share the posts between them, so no other tile's cells have changed.
        let parts = |at: u32| at * times..(at + 1) * times;
        let tiles: Vec<_> = changed
            .iter()
            .flat_map(|tile| {
                parts(tile.row)
                    .flat_map(|row| parts(tile.col).map(move |col| TileIndex { col, row }))
            })
            .filter(|tile| {
                let [cols, rows] = [self.grid.cols, self.grid.rows];
                tile.col * TILE_CELLS < cols - 1 && tile.row * TILE_CELLS < rows - 1
            })
            .collect();
        let heights =
            (self.heights).with_rows_renewed(&tiles, lines(&ground.heights, times, height));
        let mut tile_ranges = self.tile_ranges.clone();
        for tile in &tiles {
            let slot = tile.row * heights.tiles_across() + tile.col;
            tile_ranges[slot as usize] = range_of(&heights, *tile);
        }
        let lights = self.light.as_ref().zip(ground.light.as_ref());
        let result = Self {
            grid: self.grid,
            tile_ranges,
            heights,
            range: ground.range,
            light: lights
                .map(|(old, light)| old.with_rows_renewed(&tiles, lines(light, times, code))),
            photo: ground.photo.clone(),
            holes: None,
        };
        (result, tiles)
    }
}

/// The lowest and the highest post of a tile of sound heights.
fn range_of(heights: &TiledRaster<f32>, tile: TileIndex) -> [f32; 2] {
    tile_range(heights.tile_posts(tile)).expect("what lies between finite heights is finite")
}

fn height(exact: f64) -> f32 {
    exact as f32
}

fn code(exact: f64) -> u8 {
    (exact + 0.5) as u8
}

/// Fills rows of a raster that has `times` cells along each side of each one of `coarse`, whose values
/// are bilinear between its posts.
fn lines<T: Copy + Send + Sync + Zeroable + Into<f64>>(
    coarse: &TiledRaster<T>,
    times: u32,
    rounded: fn(f64) -> T,
) -> impl Fn(u32, u32, &mut [T]) {
    const LENGTH: usize = TILE_CELLS as usize + 2;
    let shares: Vec<f64> = (0..times)
        .map(|part| f64::from(part) / f64::from(times))
        .collect();
    move |row, col, into| {
        let (first, last) = (col / times, (col + into.len() as u32 - 1) / times + 1);
        let mut posts = [[T::zeroed(); LENGTH]; 2];
        let [south, north] = posts
            .each_mut()
            .map(|row| &mut row[..=(last - first) as usize]);
        let at = i64::from(row / times);
        coarse.copy_row(i64::from(first), at, south);
        coarse.copy_row(i64::from(first), at + 1, north);
        let up = shares[(row % times) as usize];
        let mut along = south.iter().zip(&*north).map(|(&south, &north)| {
            let (south, north): (f64, f64) = (south.into(), north.into());
            south + (north - south) * up
        });
        let mut rest = into;
        let mut parts = &shares[(col % times) as usize..];
        let mut from = along.next();
        while let (Some(west), Some(east)) = (from, along.next()) {
            let (cell, beyond) = rest.split_at_mut(parts.len().min(rest.len()));
            for (to, part) in cell.iter_mut().zip(parts) {
                *to = rounded(west + (east - west) * part);
            }
            (rest, parts, from) = (beyond, &shares, Some(east));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Ground, Photo, TiledRaster};
    use glam::DVec2;

    fn hills(cols: u32, rows: u32) -> Ground {
        let height = |col: u32, row: u32| ((col * 37 + row * 91) % 53) as f32;
        Ground::from_fn(cols, rows, DVec2::new(6.0, 9.0), height).expect("a sound grid")
    }

    #[test]
    fn it_is_the_same_surface() {
        let ground = hills(120, 97);
        for times in [1, 2, 3, 5] {
            let refined = ground.refined(times);
            let (grid, fine) = (ground.grid(), refined.grid());
            assert_eq!([fine.cols, fine.rows], [119 * times + 1, 96 * times + 1]);
            assert!((fine.extent() - grid.extent()).abs().max_element() < 1e-9);
            assert_eq!(refined.range(), ground.range());
            for k in 0..3000 {
                let share = DVec2::new(f64::from(k) * 0.618_034, f64::from(k) * 0.414_214).fract();
                let at = share * grid.extent();
                let [a, b] = [&ground, &refined].map(|ground| ground.height_at(at.x, at.y));
                let (a, b) = (a.expect("on it"), b.expect("on it"));
                assert!((a - b).abs() < 1e-4, "{a} is {b} at {at}");
                let [a, b] = [&ground, &refined].map(|ground| ground.colour_at(at.x, at.y));
                for (a, b) in a.into_iter().zip(b) {
                    assert!(a.abs_diff(b) <= 2, "{a} is {b} at {at}");
                }
            }
        }
    }

    #[test]
    fn an_edit_is_followed_and_the_rest_shared() {
        let photo = Photo {
            pixels: TiledRaster::from_fn(900, 700, |col, row| [col as u8, row as u8, 0, 255]),
            origin: DVec2::ZERO,
            spacing: DVec2::new(6.0, 9.0),
        };
        for before in [hills(700, 530), hills(700, 530).with_photo(photo)] {
            let edited = before.edited(250..257, 300..310, |_, _, height| 0.5 * height);
            let (ground, changed) = edited.expect("finite heights");
            for times in [2, 3] {
                let old = before.refined(times);
                let (again, tiles) = old.refined_again(&ground, times, &changed);
                let anew = ground.refined(times);
                assert_eq!(again.range(), anew.range());
                assert_eq!(again.tile_ranges, anew.tile_ranges);
                let mut shared = 0;
                for tile in anew.heights().tile_indices() {
                    assert!(again.heights().tile_posts(tile) == anew.heights().tile_posts(tile));
                    let is_shared = again.heights().shares(old.heights(), tile);
                    assert_eq!(is_shared, !tiles.contains(&tile));
                    shared += u32::from(is_shared);
                    let lights = [&again, &anew].map(|ground| ground.light());
                    let [a, b] = lights.map(|light| light.map(|light| light.tile_posts(tile)));
                    assert!(a == b);
                }
                assert!(shared > 0);
            }
        }
    }
}
