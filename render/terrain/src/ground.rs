//! The ground: heights and colours over one grid, as casters read them.

mod refined;

use crate::colour::{hypsometric, relief_light};
use crate::{NoMemory, Photo, Rgb, TileIndex, TiledRaster};
use glam::DVec2;
use rayon::prelude::*;
use std::ops::{Add, Mul, Sub};

/// A grid of posts in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Number of posts from west to east, at least 2.
    pub cols: u32,
    /// Number of posts from south to north, at least 2.
    pub rows: u32,
    /// Metres between posts, eastwards and northwards; above 0.
    pub spacing: DVec2,
}

impl Grid {
    /// Metres from the first to the last post, eastwards and northwards.
    #[must_use]
    pub fn extent(&self) -> DVec2 {
        DVec2::new(f64::from(self.cols - 1), f64::from(self.rows - 1)) * self.spacing
    }

    /// A cell as a length: the shorter of its sides, in metres.
    #[must_use]
    pub fn cell_length(&self) -> f64 {
        self.spacing.min_element()
    }

    /// Number of posts.
    #[must_use]
    pub fn posts(&self) -> u64 {
        u64::from(self.cols) * u64::from(self.rows)
    }
}

/// Why no ground can be made of a grid and heights.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum GroundError {
    /// A terrain needs at least one cell.
    #[error("a terrain needs at least 2 by 2 posts, and this one has {cols} by {rows}")]
    TooSmall {
        /// Posts from west to east.
        cols: u32,
        /// Posts from south to north.
        rows: u32,
    },
    /// Posts must lie apart.
    #[error("posts lie {0} by {1} m apart, but both must be finite and above 0")]
    BadSpacing(f64, f64),
    /// A height is NaN or infinite.
    #[error("a height is not a finite number (in tile column {}, row {})", .0.col, .0.row)]
    NotFinite(TileIndex),
    /// There is not the memory for all posts.
    #[error("{0}; take a smaller terrain, or a part of this one")]
    NoMemory(#[from] NoMemory),
}

/// The posts that had no height in the source and were filled in.
#[derive(Clone, Debug)]
pub struct Holes {
    cols: u32,
    bits: Vec<u64>,
    count: u64,
}

impl Holes {
    /// Collects the posts of a grid for which `is_hole(col, row)`; `None` where there is none.
    #[must_use]
    pub fn collect(cols: u32, rows: u32, is_hole: impl Fn(u32, u32) -> bool) -> Option<Self> {
        let mut holes = None;
        for row in 0..rows {
            for col in 0..cols {
                if is_hole(col, row) {
                    let holes: &mut Self = holes.get_or_insert_with(|| Self {
                        cols,
                        bits: vec![0; (u64::from(cols) * u64::from(rows)).div_ceil(64) as usize],
                        count: 0,
                    });
                    let index = holes.index(col, row);
                    holes.bits[index / 64] |= 1 << (index % 64);
                    holes.count += 1;
                }
            }
        }
        holes
    }

    fn index(&self, col: u32, row: u32) -> usize {
        row as usize * self.cols as usize + col as usize
    }

    /// Whether the post at (`col`, `row`), row 0 south, was a hole.
    #[must_use]
    pub fn contains(&self, col: u32, row: u32) -> bool {
        let index = self.index(col, row);
        self.bits[index / 64] >> (index % 64) & 1 == 1
    }

    /// The columns of a row's holes, from the west.
    pub(crate) fn in_row(&self, row: u32) -> impl Iterator<Item = u32> {
        let start = self.index(0, row);
        let end = start + self.cols as usize;
        (start / 64..end.div_ceil(64)).flat_map(move |word| {
            // The row's first and last words hold bits of its neighbours.
            let mut bits = self.bits[word];
            if word == start / 64 {
                bits &= u64::MAX << (start % 64);
            }
            if word == end / 64 {
                bits &= (1 << (end % 64)) - 1;
            }
            std::iter::from_fn(move || {
                let bit = (bits != 0).then(|| bits.trailing_zeros())?;
                bits &= bits - 1;
                Some((word * 64 + bit as usize - start) as u32)
            })
        })
    }

    /// How many posts were holes.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }
}

/// An immutable snapshot of the ground: solid terrain with a colour for each place.
///
/// Tiles are shared, so that a clone or an edited snapshot copies only what differs.
#[derive(Clone, Debug)]
pub struct Ground {
    grid: Grid,
    heights: TiledRaster<f32>,
    /// Lowest and highest height of each tile, in tile order.
    tile_ranges: Vec<[f32; 2]>,
    range: [f32; 2],
    /// Shaded relief; none where a photo covers all ground.
    light: Option<TiledRaster<u8>>,
    photo: Option<Photo>,
    holes: Option<Holes>,
}

impl Ground {
    /// Builds the ground from heights in metres, lit as shaded relief.
    ///
    /// # Errors
    /// [`GroundError`] where the grid has no cell, its spacing is no length, a height is not
    /// finite, or there is not the memory for it.
    pub fn new(heights: TiledRaster<f32>, spacing: DVec2) -> Result<Self, GroundError> {
        let grid = Grid {
            cols: heights.cols(),
            rows: heights.rows(),
            spacing,
        };
        if grid.cols < 2 || grid.rows < 2 {
            return Err(GroundError::TooSmall {
                cols: grid.cols,
                rows: grid.rows,
            });
        }
        if !(spacing.is_finite() && spacing.min_element() > 0.0) {
            return Err(GroundError::BadSpacing(spacing.x, spacing.y));
        }
        let indices: Vec<_> = heights.tile_indices().collect();
        let tile_ranges = indices
            .par_iter()
            .map(|&index| {
                tile_range(heights.tile_posts(index)).ok_or(GroundError::NotFinite(index))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let range = span(&tile_ranges);
        Ok(Self {
            light: Some(try_relief(&heights, spacing)?),
            grid,
            heights,
            tile_ranges,
            range,
            photo: None,
            holes: None,
        })
    }

    /// Builds the ground from a function of column and row (row 0 south) that gives metres.
    ///
    /// # Errors
    /// As [`Ground::new`].
    pub fn from_fn(
        cols: u32,
        rows: u32,
        spacing: DVec2,
        height: impl Fn(u32, u32) -> f32 + Sync,
    ) -> Result<Self, GroundError> {
        if cols < 2 || rows < 2 {
            return Err(GroundError::TooSmall { cols, rows });
        }
        Self::new(TiledRaster::try_from_fn(cols, rows, height)?, spacing)
    }

    /// The ground with a photograph over it, in place of any that it has. Where that covers all of it, the
    /// shaded relief is dropped, which nobody sees any more.
    #[must_use]
    pub fn with_photo(mut self, photo: Photo) -> Self {
        if photo.covers(self.grid.extent()) {
            self.light = None;
        } else if self.light.is_none() {
            self.light = Some(relief(&self.heights, self.grid.spacing));
        }
        self.photo = Some(photo);
        self
    }

    /// The ground with a record of which posts were filled in.
    #[must_use]
    pub fn with_holes(mut self, holes: Option<Holes>) -> Self {
        self.holes = holes;
        self
    }

    /// The grid of posts.
    #[must_use]
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// The heights in metres.
    #[must_use]
    pub fn heights(&self) -> &TiledRaster<f32> {
        &self.heights
    }

    /// Shaded relief at each post: 128 leaves a tint as it is, and 255 is almost twice as bright.
    /// `None` where a photograph covers all ground.
    #[must_use]
    pub fn light(&self) -> Option<&TiledRaster<u8>> {
        self.light.as_ref()
    }

    /// Lowest and highest height in metres.
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// The photograph, if there is one.
    #[must_use]
    pub fn photo(&self) -> Option<&Photo> {
        self.photo.as_ref()
    }

    /// The posts that were filled in, if any.
    #[must_use]
    pub fn holes(&self) -> Option<&Holes> {
        self.holes.as_ref()
    }

    /// The surface's height at world `(x, y)`, bilinear, or `None` off the terrain.
    #[must_use]
    pub fn height_at(&self, x: f64, y: f64) -> Option<f64> {
        let extent = self.grid.extent();
        let inside = (0.0..=extent.x).contains(&x) && (0.0..=extent.y).contains(&y);
        inside.then(|| {
            let (cell, place) = self
                .heights
                .locate(x / self.grid.spacing.x, y / self.grid.spacing.y);
            bilinear(self.heights.cell(cell[0], cell[1]).map(f64::from), place)
        })
    }

    /// The ground's colour at world `(x, y)`: the photograph's, or where it has none the
    /// hypsometric tint in shaded relief. Points off the terrain get the nearest border's.
    #[inline]
    #[must_use]
    pub fn colour_at(&self, x: f64, y: f64) -> Rgb {
        if let Some(colour) = self.photo.as_ref().and_then(|photo| photo.colour_at(x, y)) {
            return colour;
        }
        self.tint_at(x, y)
    }

    /// The hypsometric tint in shaded relief at world `(x, y)`, photograph or not.
    #[inline]
    pub(crate) fn tint_at(&self, x: f64, y: f64) -> Rgb {
        let (cell, [u, v]) = self
            .heights
            .locate(x / self.grid.spacing.x, y / self.grid.spacing.y);
        let place = [u as f32, v as f32];
        let height = bilinear(self.heights.cell(cell[0], cell[1]), place);
        let [col, row] = cell;
        let light = match &self.light {
            Some(light) => light.cell(col, row),
            None => [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[east, north]| {
                light_at(&self.heights, self.grid.spacing, col + east, row + north)
            }),
        };
        let light = bilinear(light.map(f32::from), place);
        let [low, high] = self.range;
        let share = if high > low {
            (height - low) / (high - low)
        } else {
            0.0
        };
        hypsometric(share, light / 256.0)
    }

    /// Bytes held by heights, light, photograph and the record of holes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.heights.bytes()
            + self.light.as_ref().map_or(0, TiledRaster::bytes)
            + self.photo.as_ref().map_or(0, |photo| photo.pixels.bytes())
            + self
                .holes
                .as_ref()
                .map_or(0, |holes| size_of_val(&*holes.bits))
    }

    /// A snapshot with the heights of `cols` by `rows` (half-open post ranges) replaced, and the
    /// tiles whose heights or colours changed. The height range that tints refer to is kept
    /// unless the edit leaves it.
    ///
    /// # Errors
    /// [`GroundError::NotFinite`] where the edit gives no finite height.
    pub fn edited(
        &self,
        cols: std::ops::Range<u32>,
        rows: std::ops::Range<u32>,
        height: impl Fn(u32, u32, f32) -> f32,
    ) -> Result<(Self, Vec<TileIndex>), GroundError> {
        let mut result = self.clone();
        (result.heights, _) = self.heights.edited(cols.clone(), rows.clone(), height);
        // A post's light depends on its neighbours, so one post more on each side is lit anew.
        let lit = |range: &std::ops::Range<u32>| {
            range.start.saturating_sub(1)..range.end.saturating_add(1)
        };
        let (cols, rows) = (lit(&cols), lit(&rows));
        let changed = self.heights.tiles_of(&cols, &rows);
        result.light = self.light.as_ref().map(|light| {
            let relit = |col, row, _| light_at(&result.heights, self.grid.spacing, col, row);
            light.edited(cols, rows, relit).0
        });
        for (slot, index) in self.heights.tile_indices().enumerate() {
            if changed.contains(&index) {
                result.tile_ranges[slot] = tile_range(result.heights.tile_posts(index))
                    .ok_or(GroundError::NotFinite(index))?;
            }
        }
        let [low, high] = span(&result.tile_ranges);
        result.range = [self.range[0].min(low), self.range[1].max(high)];
        Ok((result, changed))
    }
}

/// Lowest and highest of a tile's posts, or `None` where one is not finite.
fn tile_range(posts: &[f32]) -> Option<[f32; 2]> {
    posts.iter().try_fold(
        [f32::INFINITY, f32::NEG_INFINITY],
        |[low, high], &height| {
            height
                .is_finite()
                .then(|| [low.min(height), high.max(height)])
        },
    )
}

fn span(ranges: &[[f32; 2]]) -> [f32; 2] {
    ranges
        .iter()
        .fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], range| {
            [low.min(range[0]), high.max(range[1])]
        })
}

/// The shaded relief of all posts.
fn relief(heights: &TiledRaster<f32>, spacing: DVec2) -> TiledRaster<u8> {
    try_relief(heights, spacing).unwrap_or_else(|refused| panic!("{refused}"))
}

/// As [`relief`], with an error where there is not the memory for it.
fn try_relief(heights: &TiledRaster<f32>, spacing: DVec2) -> Result<TiledRaster<u8>, NoMemory> {
    TiledRaster::try_from_fn(heights.cols(), heights.rows(), |col, row| {
        light_at(heights, spacing, col, row)
    })
}

/// Shaded relief at a post, from central differences (one-sided at the border).
fn light_at(heights: &TiledRaster<f32>, spacing: DVec2, col: u32, row: u32) -> u8 {
    let (west, east) = (col.saturating_sub(1), (col + 1).min(heights.cols() - 1));
    let (south, north) = (row.saturating_sub(1), (row + 1).min(heights.rows() - 1));
    let slope_east = (heights.post(east, row) - heights.post(west, row))
        / ((east - west) as f32 * spacing.x as f32);
    let slope_north = (heights.post(col, north) - heights.post(col, south))
        / ((north - south) as f32 * spacing.y as f32);
    relief_light(slope_east, slope_north)
}

/// Blends a cell's posts (south-west, south-east, north-west, north-east) at a place in [0, 1]².
#[inline]
fn bilinear<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>>(
    [sw, se, nw, ne]: [T; 4],
    [u, v]: [T; 2],
) -> T {
    let south = sw + (se - sw) * u;
    let north = nw + (ne - nw) * u;
    south + (north - south) * v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rows_holes_are_those_collected() {
        for cols in [1, 63, 64, 65, 200] {
            let is_hole = |col: u32, row: u32| (col * 7 + row * 3).is_multiple_of(5);
            let holes = Holes::collect(cols, 9, is_hole).unwrap();
            for row in 0..9 {
                let expected: Vec<_> = (0..cols).filter(|&col| is_hole(col, row)).collect();
                assert_eq!(holes.in_row(row).collect::<Vec<_>>(), expected);
            }
        }
    }

    #[test]
    fn heights_are_bilinear_and_end_at_the_border() {
        let ground =
            Ground::from_fn(3, 3, DVec2::new(10.0, 20.0), |col, row| (col * row) as f32).unwrap();
        assert_eq!(ground.height_at(15.0, 30.0), Some(1.5 * 1.5));
        assert_eq!(ground.height_at(20.0, 40.0), Some(4.0));
        assert_eq!(ground.height_at(20.1, 0.0), None);
        assert_eq!(ground.range(), [0.0, 4.0]);
    }

    #[test]
    fn a_smaller_photo_in_place_of_a_larger_one_leaves_tints_beside_it() {
        let tinted = Ground::from_fn(9, 9, DVec2::ONE, |col, row| (col * row) as f32).unwrap();
        let photo = |pixels: u32| Photo {
            pixels: TiledRaster::from_fn(pixels, pixels, |_, _| [1, 2, 3, 255]),
            origin: DVec2::ZERO,
            spacing: DVec2::ONE,
        };
        let ground = tinted.clone().with_photo(photo(9));
        assert!(ground.light().is_none());
        let ground = ground.with_photo(photo(5));
        assert_eq!(ground.colour_at(3.0, 3.0), [1, 2, 3]);
        assert_eq!(ground.colour_at(7.0, 6.0), tinted.colour_at(7.0, 6.0));
        let [a, b] = [&ground, &tinted].map(|ground| ground.light().unwrap());
        assert_eq!(a.post(8, 7), b.post(8, 7));
    }

    #[test]
    fn degenerate_grounds_are_refused() {
        let one =
            |cols, rows, spacing| Ground::from_fn(cols, rows, spacing, |_, _| 0.0).map(|_| ());
        assert_eq!(
            one(1, 5, DVec2::ONE),
            Err(GroundError::TooSmall { cols: 1, rows: 5 })
        );
        assert!(matches!(
            one(2, 2, DVec2::ZERO),
            Err(GroundError::BadSpacing(..))
        ));
        let nan = Ground::from_fn(2, 2, DVec2::ONE, |_, _| f32::NAN);
        assert!(matches!(nan, Err(GroundError::NotFinite(_))));
    }

    #[test]
    fn an_edited_ground_equals_one_built_anew() {
        let before = |col: u32, row: u32| ((col * 7 + row * 13) % 50) as f32;
        let after = |col: u32, row: u32| {
            if (250..262).contains(&col) && (100..103).contains(&row) {
                20.0
            } else {
                before(col, row)
            }
        };
        let (edited, changed) = Ground::from_fn(400, 300, DVec2::ONE, before)
            .unwrap()
            .edited(250..262, 100..103, |_, _, _| 20.0)
            .unwrap();
        let fresh = Ground::from_fn(400, 300, DVec2::ONE, after).unwrap();
        assert_eq!(changed.len(), 2);
        for row in 0..300 {
            for col in 0..400 {
                assert_eq!(edited.heights.post(col, row), fresh.heights.post(col, row));
                let [edited, fresh] = [&edited, &fresh].map(|ground| ground.light().unwrap());
                assert_eq!(edited.post(col, row), fresh.post(col, row));
            }
        }
    }
}
