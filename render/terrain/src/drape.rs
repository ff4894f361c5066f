//! The ground's colours, a pixel a post, at halved and halved again resolution.

mod kernel;
mod resampled;

use self::kernel::Kernel;
use self::resampled::resampled;
use crate::halving::coarser_size;
use crate::{
    Ground, LinearLight, Photo, TILE_CELLS, TileIndex, TiledRaster, pre_texture,
    pre_texture_updated, reach,
};
use glam::DVec2;

/// The colours of the ground's posts, at all resolutions of its
/// [`HeightPyramid`](crate::HeightPyramid): whoever has found a cell's heights has found its
/// colours.
///
/// Level 0 has the ground's own colours at its posts: of a photograph that is finer than they are,
/// the means around them, and of one whose pixels lie about as far apart or up to three times, but beside them,
/// those between which what is linear comes nearest to the photograph. A post of each further level is the mean
/// of the finer ones around it by
/// [−1 2 6 2 −1] / 8 along each axis, as its height is, in linear light; beyond the border the
/// outermost colour repeats. Colours are red, green, blue, sRGB-encoded, and 255.
#[derive(Clone, Debug)]
pub struct Drape {
    levels: Vec<TiledRaster<[u8; 4]>>,
}

/// As how many posts wide a photograph's pixels count as finer than these.
const FINER: f64 = 0.75;

/// As how many posts wide they count as coarser: then what is linear between them is almost so between posts.
const COARSER: f64 = 3.0;

/// What the finest level is made of.
enum Finest<'a> {
    /// The photograph's pixels: one lies at each post.
    Pixels(&'a TiledRaster<[u8; 4]>),
    /// Means around the posts.
    Means,
    /// What kernels along both axes make of the photograph's pixels.
    Between(&'a Photo, [Kernel; 2]),
    /// The tints at the posts.
    Tints,
}

impl<'a> Finest<'a> {
    fn of(ground: &'a Ground) -> Self {
        let grid = ground.grid();
        let is_finer = |photo: &Photo| (photo.spacing / grid.spacing).min_element() < FINER;
        let kernels = |photo: &Photo| {
            (photo.spacing / grid.spacing).to_array().map(|spacing| {
                if spacing < COARSER {
                    Kernel::nearest(1.0 / spacing)
                } else {
                    Kernel::linear()
                }
            })
        };
        let is_on_posts = |photo: &Photo| {
            photo.origin == DVec2::ZERO
                && photo.spacing == grid.spacing
                && [photo.pixels.cols(), photo.pixels.rows()] == [grid.cols, grid.rows]
        };
        match ground.photo() {
            Some(photo) if is_on_posts(photo) && ground.light().is_none() => {
                Self::Pixels(&photo.pixels)
            }
            Some(photo) if is_finer(photo) => Self::Means,
            Some(photo) => Self::Between(photo, kernels(photo)),
            None => Self::Tints,
        }
    }
}

/// The ground's tints at its posts.
fn tints(ground: &Ground) -> impl Fn(u32, u32) -> [u8; 4] + Sync {
    let spacing = ground.grid().spacing;
    move |col, row| {
        let at = DVec2::new(f64::from(col), f64::from(row)) * spacing;
        let [r, g, b] = ground.tint_at(at.x, at.y);
        [r, g, b, 255]
    }
}

impl Drape {
    /// Builds all levels, tiles in parallel. Where the photograph has its pixels at the posts and
    /// covers all ground, level 0 shares its memory.
    #[must_use]
    pub fn new(ground: &Ground) -> Self {
        let grid = ground.grid();
        let finest = match Finest::of(ground) {
            Finest::Pixels(pixels) => pixels.clone(),
            Finest::Means => pre_texture(ground),
            Finest::Between(photo, kernels) => {
                TiledRaster::from_rows(grid.cols, grid.rows, resampled(ground, photo, kernels))
            }
            Finest::Tints => TiledRaster::from_fn(grid.cols, grid.rows, tints(ground)),
        };
        let mut levels = vec![finest];
        while let Some(finer) = levels.last()
            && let Some([cols, rows]) = coarser_size([finer.cols(), finer.rows()])
        {
            let coarser = TiledRaster::from_rows(cols, rows, sharp_means(finer));
            levels.push(coarser);
        }
        Self { levels }
    }

    /// The levels after an edit of `before` that made `ground` of it, in the tiles `changed`, and
    /// left the range of heights as it was. Tiles out of its reach are shared with `self`.
    #[must_use]
    pub fn updated(&self, before: &Ground, ground: &Ground, changed: &[TileIndex]) -> Self {
        // Where a photograph covers all ground, no colour comes from heights.
        let photos = before.photo().zip(ground.photo());
        if before.light().is_none()
            && ground.light().is_none()
            && photos.is_some_and(|(before, photo)| before.is_same(photo))
        {
            return self.clone();
        }
        let old = &self.levels[0];
        let finest = match Finest::of(ground) {
            Finest::Pixels(pixels) => pixels.clone(),
            Finest::Means => pre_texture_updated(old, before, ground, changed),
            Finest::Between(photo, kernels) => {
                old.with_rows_renewed(changed, resampled(ground, photo, kernels))
            }
            Finest::Tints => old.with_tiles_renewed(changed, tints(ground)),
        };
        let mut reached = reach::with_neighbours(changed, finest.cols(), finest.rows());
        let mut levels = vec![finest];
        for old in &self.levels[1..] {
            let finer = &levels[levels.len() - 1];
            reached = reach::coarser(&reached, old.cols(), old.rows());
            levels.push(old.with_rows_renewed(&reached, sharp_means(finer)));
        }
        Self { levels }
    }

    /// The levels, the finest first.
    #[must_use]
    pub fn levels(&self) -> &[TiledRaster<[u8; 4]>] {
        &self.levels
    }
}

/// Fills rows of the coarser level.
fn sharp_means(finer: &TiledRaster<[u8; 4]>) -> impl Fn(u32, u32, &mut [[u8; 4]]) {
    const LENGTH: usize = 2 * TILE_CELLS as usize + 5;
    const WEIGHTS: [f32; 5] = [-0.125, 0.25, 0.75, 0.25, -0.125];
    move |row, col, into| {
        let light = LinearLight::tables();
        let mut sums = [[0.0_f32; 3]; LENGTH];
        let mut pixels = [[0_u8; 4]; LENGTH];
        let count = 2 * into.len() + 3;
        for (row, weight) in (2 * i64::from(row) - 2..).zip(WEIGHTS) {
            let pixels = &mut pixels[..count];
            finer.copy_row(2 * i64::from(col) - 2, row, pixels);
            for (sum, pixel) in sums.iter_mut().zip(&*pixels) {
                for (sum, &code) in sum.iter_mut().zip(pixel) {
                    *sum += weight * light.decode(code);
                }
            }
        }
        for (to, around) in into.iter_mut().zip(sums[..count].windows(5).step_by(2)) {
            let [r, g, b] = [0, 1, 2].map(|channel| {
                let parts = around.iter().zip(WEIGHTS);
                light.encode(parts.map(|(sum, weight)| weight * sum[channel]).sum())
            });
            *to = [r, g, b, 255];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HeightPyramid;

    fn hills(cols: u32, rows: u32) -> Ground {
        let height = |col: u32, row: u32| 30.0 * (0.1 * f64::from(col + 2 * row)).sin();
        Ground::from_fn(cols, rows, DVec2::new(2.0, 3.0), |col, row| {
            height(col, row) as f32
        })
        .expect("a sound grid")
    }

    fn photo(spacing: DVec2, [cols, rows]: [u32; 2]) -> Photo {
        let pixel = |x: u32, y: u32| [(x * 37 % 251) as u8, (y * 91 % 241) as u8, 90, 255];
        Photo {
            pixels: TiledRaster::from_fn(cols, rows, pixel),
            origin: DVec2::ZERO,
            spacing,
        }
    }

    #[test]
    fn levels_are_the_heights_and_colours_the_grounds() {
        let tinted = hills(301, 270);
        let coarse = photo(DVec2::new(8.0, 12.0), [50, 50]);
        for ground in [tinted.clone(), tinted.clone().with_photo(coarse)] {
            let drape = Drape::new(&ground);
            let heights = HeightPyramid::new(ground.heights(), ground.range());
            assert_eq!(drape.levels().len(), heights.levels().len());
            for (colours, heights) in drape.levels().iter().zip(heights.levels()) {
                assert_eq!(
                    [colours.cols(), colours.rows()],
                    [heights.cols(), heights.rows()]
                );
            }
            for (col, row) in [(0, 0), (300, 269), (150, 256), (256, 30)] {
                let [r, g, b] = ground.colour_at(2.0 * f64::from(col), 3.0 * f64::from(row));
                assert_eq!(drape.levels()[0].post(col, row), [r, g, b, 255]);
            }
        }
        let on_posts = photo(tinted.grid().spacing, [301, 270]);
        let ground = tinted.with_photo(on_posts);
        let pixels = &ground.photo().expect("its photo").pixels;
        assert!(Drape::new(&ground).levels()[0].is_same(pixels));
    }

    #[test]
    fn what_is_finer_than_posts_does_not_alias() {
        let fine = Photo {
            pixels: TiledRaster::from_fn(1200, 1620, |x, y| {
                let code = if (x + y) % 2 == 0 { 255 } else { 0 };
                [code, code, code, 255]
            }),
            origin: DVec2::ZERO,
            spacing: DVec2::splat(0.5),
        };
        let drape = Drape::new(&hills(300, 270).with_photo(fine));
        // Half the light.
        for level in &drape.levels()[..3] {
            let [r, ..] = level.post(level.cols() / 2, level.rows() / 2);
            assert!((186..=190).contains(&r), "{r}");
        }
    }

    #[test]
    fn what_lies_between_posts_keeps_its_contrast() {
        // Stripes of two pixels, which stand half a pixel beside the posts, and do not cover all ground.
        let stripes = Photo {
            pixels: TiledRaster::from_fn(290, 280, |x, _| {
                let code = if x % 4 < 2 { 200 } else { 100 };
                [code, 77, code, 255]
            }),
            origin: DVec2::new(1.0, 1.5),
            spacing: DVec2::new(2.0, 3.0),
        };
        let ground = hills(300, 270).with_photo(stripes);
        let drape = Drape::new(&ground);
        let finest = &drape.levels()[0];
        for (col, expected) in [(101, 219), (102, 150), (103, 81), (104, 150)] {
            let [r, g, b, a] = finest.post(col, 60);
            assert_eq!([g, b, a], [77, r, 255]);
            assert_eq!(r, expected, "at {col}");
        }
        let [r, g, b] = ground.tint_at(2.0 * 295.0, 3.0 * 60.0);
        assert_eq!(finest.post(295, 60), [r, g, b, 255]);
    }

    #[test]
    fn beside_a_photo_there_are_tints_however_far_away_it_lies() {
        let tinted = hills(300, 270);
        let tints = Drape::new(&tinted);
        for at in [-1000.0, 1000.0, -1e300, f64::NEG_INFINITY, f64::NAN] {
            for origin in [DVec2::new(at, 0.0), DVec2::new(0.0, at), DVec2::splat(at)] {
                let photo = photo(DVec2::new(2.0, 3.0), [300, 270]);
                let drape = Drape::new(&tinted.clone().with_photo(Photo { origin, ..photo }));
                for (col, row) in [(0, 0), (299, 0), (0, 269), (299, 269)] {
                    let [a, b] = [&drape, &tints].map(|drape| drape.levels()[0].post(col, row));
                    assert_eq!(a, b, "{col}, {row} beside a photo at {origin}");
                }
            }
        }
    }

    #[test]
    fn an_edit_is_followed_and_the_rest_shared() {
        let tinted = hills(1300, 600);
        let fine = photo(DVec2::ONE, [1000, 900]);
        let between = Photo {
            origin: DVec2::new(1.0, 1.0),
            ..photo(DVec2::new(2.0, 3.0), [1000, 290])
        };
        for before in [
            tinted.clone(),
            tinted.clone().with_photo(fine),
            tinted.with_photo(between),
        ] {
            let edited = before.edited(250..260, 300..310, |_, _, height| 0.5 * height);
            let (ground, changed) = edited.expect("finite heights");
            assert_eq!(before.range(), ground.range());
            let old = Drape::new(&before);
            let updated = old.updated(&before, &ground, &changed);
            let anew = Drape::new(&ground);
            for (a, b) in updated.levels().iter().zip(anew.levels()) {
                for tile in a.tile_indices() {
                    assert!(a.tile_posts(tile) == b.tile_posts(tile));
                }
            }
            let far = TileIndex { col: 4, row: 0 };
            assert!(updated.levels()[0].shares(&old.levels()[0], far));
        }
    }
}
