//! Pre-texturing: one colour a column of voxels (Wan, Qu, Kaufman 1999, section 3).

use crate::{Ground, LinearLight, Photo, TileIndex, TiledRaster, reach};

/// The colour of each column of voxels: red, green, blue, sRGB-encoded, and 255.
///
/// It is the mean, in linear light, of the ground's colour over the column's footprint: half a
/// spacing around its post, within the terrain. Of a photograph each pixel counts by its share in
/// the bilinear picture over the footprint, so one finer than the posts does not alias. The part
/// of a footprint that the photograph leaves open is tinted relief.
#[must_use]
pub fn pre_texture(ground: &Ground) -> TiledRaster<[u8; 4]> {
    let footprints = Footprints::new(ground);
    let grid = ground.grid();
    TiledRaster::from_fn(grid.cols, grid.rows, |col, row| footprints.mean(col, row))
}

/// The colours of [`pre_texture`] after an edit: `old` are those of the ground `before`, and
/// `changed` all tiles whose heights, light or photograph differ. Equal to colours made anew;
/// tiles out of reach are shared with `old`.
///
/// Where the edit leaves the ground's range of heights, all tints change with it and all is made
/// anew.
#[must_use]
pub fn pre_texture_updated(
    old: &TiledRaster<[u8; 4]>,
    before: &Ground,
    ground: &Ground,
    changed: &[TileIndex],
) -> TiledRaster<[u8; 4]> {
    if before.grid() != ground.grid() {
        return pre_texture(ground);
    }
    renewed(old, &reached_tiles(before.range(), ground, changed), ground)
}

/// The tiles of columns that a change of the ground's `changed` tiles can recolour, when its
/// range was `range` before.
pub(crate) fn reached_tiles(
    range: [f32; 2],
    ground: &Ground,
    changed: &[TileIndex],
) -> Vec<TileIndex> {
    let grid = ground.grid();
    if range == ground.range() {
        reach::with_neighbours(changed, grid.cols, grid.rows)
    } else {
        reach::all(grid.cols, grid.rows)
    }
}

/// Colours with some tiles made anew from `ground`.
pub(crate) fn renewed(
    old: &TiledRaster<[u8; 4]>,
    tiles: &[TileIndex],
    ground: &Ground,
) -> TiledRaster<[u8; 4]> {
    let footprints = Footprints::new(ground);
    old.with_tiles_renewed(tiles, |col, row| footprints.mean(col, row))
}

/// The footprints of all columns.
struct Footprints<'a> {
    ground: &'a Ground,
    light: &'static LinearLight,
    photo: Option<(&'a Photo, [PixelWeights; 2])>,
}

impl<'a> Footprints<'a> {
    fn new(ground: &'a Ground) -> Self {
        let grid = ground.grid();
        let sound = |photo: &&Photo| {
            photo.spacing.is_finite()
                && photo.spacing.min_element() > 0.0
                && photo.origin.is_finite()
        };
        let photo = ground.photo().filter(sound).map(|photo| {
            let weights = |axis: usize, posts, pixels| {
                let (origin, spacing) = (photo.origin[axis], photo.spacing[axis]);
                PixelWeights::new(posts, pixels, |post| {
                    let [from, to] = footprint(post, posts, grid.spacing[axis]);
                    [(from - origin) / spacing, (to - origin) / spacing]
                })
            };
            let axes = [
                weights(0, grid.cols, photo.pixels.cols()),
                weights(1, grid.rows, photo.pixels.rows()),
            ];
            (photo, axes)
        });
        Self {
            ground,
            light: LinearLight::tables(),
            photo,
        }
    }

    fn mean(&self, col: u32, row: u32) -> [u8; 4] {
        // Light and how much of the footprint it stands for.
        let mut sum = [0.0_f32; 4];
        if let Some((photo, [cols, rows])) = &self.photo {
            for (pixel_row, up) in rows.of(row) {
                let mut row_sum = [0.0_f32; 4];
                for (pixel_col, along) in cols.of(col) {
                    let [r, g, b, coverage] = photo.pixels.post(pixel_col, pixel_row);
                    if coverage > 0 {
                        self.add(&mut row_sum, [r, g, b], along);
                    }
                }
                for (sum, part) in sum.iter_mut().zip(row_sum) {
                    *sum += up * part;
                }
            }
        }
        // What rounding leaves open is none of it.
        let open = 1.0 - sum[3];
        if open > 1e-4 {
            let grid = self.ground.grid();
            let quarters = |post, posts, spacing| {
                let [from, to] = footprint(post, posts, spacing);
                [0.25, 0.75].map(|share| from + (to - from) * share)
            };
            for y in quarters(row, grid.rows, grid.spacing.y) {
                for x in quarters(col, grid.cols, grid.spacing.x) {
                    self.add(&mut sum, self.ground.tint_at(x, y), 0.25 * open);
                }
            }
        }
        let [r, g, b] = [0, 1, 2].map(|channel| self.light.encode(sum[channel] / sum[3]));
        [r, g, b, 255]
    }

    fn add(&self, sum: &mut [f32; 4], colour: [u8; 3], weight: f32) {
        for (sum, code) in sum.iter_mut().zip(colour) {
            *sum += weight * self.light.decode(code);
        }
        sum[3] += weight;
    }
}

/// Where the footprint of a post begins and ends along an axis of `posts` posts, metres.
fn footprint(post: u32, posts: u32, spacing: f64) -> [f64; 2] {
    let post = f64::from(post);
    [
        (post - 0.5).max(0.0),
        (post + 0.5).min(f64::from(posts - 1)),
    ]
    .map(|at| at * spacing)
}

/// How much each pixel of a photograph counts in each post's footprint, along one axis. The
/// weights of a footprint add up to the share of it that lies on the photograph.
struct PixelWeights {
    /// The first pixel and the first weight of each post, and one entry more.
    posts: Vec<(u32, usize)>,
    weights: Vec<f32>,
}

impl PixelWeights {
    /// `footprint` gives where a post's footprint begins and ends, in pixels from the centre of
    /// the first.
    fn new(posts: u32, pixels: u32, footprint: impl Fn(u32) -> [f64; 2]) -> Self {
        let last = f64::from(pixels - 1);
        let mut result = Self {
            posts: Vec::with_capacity(posts as usize + 1),
            weights: Vec::new(),
        };
        for post in 0..posts {
            let [from, to] = footprint(post);
            // The outer half pixel belongs to the photograph.
            let [begin, end] = [from, to].map(|at| at.clamp(-0.5, last + 0.5));
            let first = begin.floor().max(0.0);
            result.posts.push((first as u32, result.weights.len()));
            if begin >= end {
                continue;
            }
            let scale = (to - from).recip();
            for pixel in first as u32..=end.ceil().min(last) as u32 {
                let integral = |at: f64| {
                    let at = at - f64::from(pixel);
                    tent_integral(at, pixel == 0, pixel == pixels - 1)
                };
                let weight = (integral(end) - integral(begin)) * scale;
                result.weights.push(weight as f32);
            }
        }
        result.posts.push((0, result.weights.len()));
        result
    }

    /// The pixels in a post's footprint, with their weights.
    fn of(&self, post: u32) -> impl Iterator<Item = (u32, f32)> {
        let (first, from) = self.posts[post as usize];
        let (_, to) = self.posts[post as usize + 1];
        (first..).zip(self.weights[from..to].iter().copied())
    }
}

/// The integral, up to `at` pixels from a pixel's centre, of its share in a linear blend. The
/// first and the last pixel are all of the blend beyond their centres.
fn tent_integral(at: f64, first: bool, last: bool) -> f64 {
    if (first && at < 0.0) || (last && at > 0.0) {
        0.5 + at
    } else if at < 0.0 {
        0.5 * (at.max(-1.0) + 1.0).powi(2)
    } else {
        1.0 - 0.5 * (1.0 - at.min(1.0)).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn flat(posts: u32) -> Ground {
        Ground::from_fn(posts, posts, DVec2::splat(8.0), |_, _| 0.0).unwrap()
    }

    fn photo(pixels: u32, spacing: f64, pixel: impl Fn(u32, u32) -> [u8; 4] + Sync) -> Photo {
        Photo {
            pixels: TiledRaster::from_fn(pixels, pixels, pixel),
            // Covers the posts of a terrain that begins at 0, to its edges.
            origin: DVec2::splat(0.5 * spacing),
            spacing: DVec2::splat(spacing),
        }
    }

    #[test]
    fn a_fine_checker_becomes_half_the_light_and_no_moire() {
        // 32 m of 0.5 m squares, black and white, under posts 8 m apart.
        let checker = photo(64, 0.5, |col, row| {
            let code = 255 * ((col + row) % 2) as u8;
            [code, code, 0, 255]
        });
        let colours = pre_texture(&flat(5).with_photo(checker));
        for row in 0..5 {
            for col in 0..5 {
                let [r, g, b, a] = colours.post(col, row);
                assert_eq!((r, b, a), (g, 0, 255));
                // Half of white's light is code 187.5; the outermost pixels count a little more.
                assert!((187..=188).contains(&r), "{r} at {col} {row}");
            }
        }
    }

    #[test]
    fn one_colour_stays_itself_at_any_resolution() {
        for (pixels, spacing) in [(2, 20.0), (5, 8.0), (13, 3.1), (400, 0.1)] {
            let one = photo(pixels, spacing, |_, _| [7, 130, 201, 255]);
            let colours = pre_texture(&flat(5).with_photo(one));
            for (col, row) in [(0, 0), (1, 1), (4, 0), (3, 4)] {
                assert_eq!(colours.post(col, row), [7, 130, 201, 255], "{pixels}");
            }
        }
    }

    #[test]
    fn weights_are_those_of_the_blended_picture() {
        // Pixels as far apart as posts and centred on them: the mean over half a spacing to both
        // sides of linear blends is ¾ of the pixel and ⅛ of its neighbours.
        let weights = PixelWeights::new(4, 4, |post| footprint(post, 4, 1.0));
        let of = |post| weights.of(post).collect::<Vec<_>>();
        assert_eq!(of(1), [(0, 0.125), (1, 0.75), (2, 0.125)]);
        assert_eq!(of(0), [(0, 0.75), (1, 0.25)]);
        assert_eq!(of(3), [(2, 0.25), (3, 0.75)]);
        // Half off the photograph, wholly off it.
        let off = PixelWeights::new(4, 2, |post| footprint(post, 4, 1.0));
        assert_eq!(off.of(1).map(|(_, weight)| weight).sum::<f32>(), 1.0);
        assert_eq!(off.of(2).map(|(_, weight)| weight).sum::<f32>(), 0.0);
    }

    #[test]
    fn open_parts_of_a_footprint_are_tinted() {
        let ground = flat(5);
        let tint = ground.tint_at(0.0, 0.0);
        let half = photo(5, 8.0, |col, _| {
            [255, 255, 255, if col < 2 { 255 } else { 0 }]
        });
        let colours = pre_texture(&ground.with_photo(half));
        assert_eq!(colours.post(0, 0), [255; 4]);
        assert_eq!(colours.post(4, 0)[..3], tint);
        // Post 2 is at 16 m, where pixel 2 begins: half of its footprint is open at most.
        let [r, ..] = colours.post(2, 2);
        assert!(r > tint[0] && r < 255, "{r}");
    }

    #[test]
    fn relief_without_a_photograph_is_near_its_colour_at_the_post() {
        let ground = Ground::from_fn(20, 20, DVec2::ONE, |col, row| (col + row) as f32).unwrap();
        let colours = pre_texture(&ground);
        for at in 1..19 {
            let there = ground.colour_at(f64::from(at), f64::from(at));
            let [r, g, b, a] = colours.post(at, at);
            assert_eq!(a, 255);
            for (mean, point) in [r, g, b].into_iter().zip(there) {
                assert!(mean.abs_diff(point) <= 2, "{mean} {point}");
            }
        }
    }
}
