//! Colours at halved and halved again resolution.

use crate::{LinearLight, SlabView, TILE_CELLS, TileIndex, TiledRaster, reach};

/// An image at all resolutions: level 0 is the image itself, and each further one has half the
/// pixels a side.
///
/// A pixel of a coarser level covers 2 × 2 pixels of the finer one: pixel i lies at finer pixel
/// 2 i + ½. Colours are blended in linear light, by a filter that keeps what the coarser level can
/// hold: along each axis the mean of the two pixels below, sharpened by [−1 18 −1] / 16 over
/// neighbouring means. The fourth byte is 255 where all four pixels have 255, else 0.
///
/// All levels lie in one piece of memory.
#[derive(Clone, Debug)]
pub struct Mipmap {
    levels: Vec<TiledRaster<[u8; 4]>>,
}

/// Pixels along the longer side of the coarsest level, at most.
const COARSEST: u32 = 16;

/// The size of the level of half the resolution, or `None` below the coarsest.
fn half([cols, rows]: [u32; 2]) -> Option<[u32; 2]> {
    (cols.max(rows) > COARSEST).then(|| [cols, rows].map(|side| side.div_ceil(2).max(2)))
}

/// Tiles of all coarser levels of an image.
pub(crate) fn coarser_tiles(cols: u32, rows: u32) -> usize {
    let tiles = |[cols, rows]: [u32; 2]| {
        let along = |side: u32| (side - 1).div_ceil(TILE_CELLS) as usize;
        along(cols) * along(rows)
    };
    std::iter::successors(half([cols, rows]), |&size| half(size))
        .map(tiles)
        .sum()
}

impl Mipmap {
    /// Builds all levels over `image`, tiles in parallel. Level 0 is the image, not a copy, unless
    /// its memory has no room for the others.
    #[must_use]
    pub fn new(image: &TiledRaster<[u8; 4]>) -> Self {
        Self::over(image.clone())
            .or_else(|| Self::over(image.moved()))
            .expect("a new raster has room for its levels")
    }

    fn over(image: TiledRaster<[u8; 4]>) -> Option<Self> {
        let mut levels = vec![image];
        while let Some(finer) = levels.last()
            && let Some([cols, rows]) = half([finer.cols(), finer.rows()])
        {
            let coarser = finer.laid_beside(cols, rows, means(finer))?;
            levels.push(coarser);
        }
        Some(Self { levels })
    }

    /// The levels after the tiles `changed` of the image have changed; the others' are shared with
    /// `self`.
    #[must_use]
    pub fn updated(&self, image: &TiledRaster<[u8; 4]>, changed: &[TileIndex]) -> Self {
        let mut levels = vec![image.clone()];
        let mut changed = changed.to_vec();
        for old in &self.levels[1..] {
            let finer = &levels[levels.len() - 1];
            changed = reach::coarser(&changed, old.cols(), old.rows());
            let coarser = old.with_rows_renewed(&changed, means(finer));
            if !coarser.is_beside(image) {
                return Self::new(image);
            }
            levels.push(coarser);
        }
        Self { levels }
    }

    /// The levels, the finest first.
    #[must_use]
    pub fn levels(&self) -> &[TiledRaster<[u8; 4]>] {
        &self.levels
    }

    /// The tiles of all levels, the finest level's first.
    #[must_use]
    pub fn view(&self) -> SlabView<'_, [u8; 4]> {
        TiledRaster::view_of(&self.levels)
    }
}

/// Fills rows of the coarser level.
fn means(finer: &TiledRaster<[u8; 4]>) -> impl Fn(u32, u32, &mut [[u8; 4]]) {
    const LENGTH: usize = 2 * TILE_CELLS as usize + 6;
    // The mean of two and the sharpening of means in one.
    const WEIGHTS: [f32; 6] = [
        -1.0 / 32.0,
        -1.0 / 32.0,
        18.0 / 32.0,
        18.0 / 32.0,
        -1.0 / 32.0,
        -1.0 / 32.0,
    ];
    move |row, col, into| {
        let light = LinearLight::tables();
        let mut sums = [[0.0_f32; 3]; LENGTH];
        let mut rows = [[[0_u8; 4]; LENGTH]; 6];
        let count = 2 * into.len() + 4;
        let first = 2 * i64::from(row) - 2;
        for ((row, pixels), weight) in (first..).zip(&mut rows).zip(WEIGHTS) {
            let pixels = &mut pixels[..count];
            finer.copy_row(2 * i64::from(col) - 2, row, pixels);
            for (sum, pixel) in sums.iter_mut().zip(&*pixels) {
                for (sum, &code) in sum.iter_mut().zip(pixel) {
                    *sum += weight * light.decode(code);
                }
            }
        }
        for (k, to) in into.iter_mut().enumerate() {
            let covered = |pixels: &[[u8; 4]; LENGTH], columns: std::ops::Range<usize>| {
                pixels[columns].iter().all(|pixel| pixel[3] == 255)
            };
            let at = 2 * k;
            let mut colour = [0.0_f32; 3];
            if rows.iter().all(|pixels| covered(pixels, at..at + 6)) {
                for (sum, weight) in sums[at..at + 6].iter().zip(WEIGHTS) {
                    for (to, part) in colour.iter_mut().zip(sum) {
                        *to += weight * part;
                    }
                }
            } else {
                // Beside what the image leaves open there is nothing to sharpen.
                for pixel in rows[2..4].iter().flat_map(|pixels| &pixels[at + 2..at + 4]) {
                    for (to, &code) in colour.iter_mut().zip(pixel) {
                        *to += 0.25 * light.decode(code);
                    }
                }
            }
            let whole = rows[2..4]
                .iter()
                .all(|pixels| covered(pixels, at + 2..at + 4));
            let [r, g, b] = colour.map(|light_of| light.encode(light_of));
            *to = [r, g, b, if whole { 255 } else { 0 }];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(col: u32, row: u32) -> [u8; 4] {
        let mut n = (col * 7919 + row * 104_729) ^ 0x5bd1;
        n = (n ^ (n >> 7)).wrapping_mul(0x9e37_79b9);
        let [r, g, b, _] = n.to_le_bytes();
        [r, g, b, 255]
    }

    #[test]
    fn a_colour_stays_itself_and_levels_halve() {
        let mipmap = Mipmap::new(&TiledRaster::from_fn(700, 301, |_, _| [7, 130, 255, 255]));
        let sizes: Vec<_> = mipmap
            .levels()
            .iter()
            .map(|l| [l.cols(), l.rows()])
            .collect();
        assert_eq!(sizes[..3], [[700, 301], [350, 151], [175, 76]]);
        assert_eq!(sizes.last(), Some(&[11, 5]));
        assert_eq!(coarser_tiles(700, 301), 2 + 5);
        for level in mipmap.levels() {
            let (x, y) = (level.cols() - 1, level.rows() - 1);
            assert_eq!(level.post(x, y), [7, 130, 255, 255]);
        }
        assert_eq!(mipmap.view().bases().len(), 6 + 7);
    }

    #[test]
    fn what_is_open_stays_open() {
        let image = TiledRaster::from_fn(64, 64, |col, row| {
            if (col, row) == (20, 21) {
                [0; 4]
            } else {
                [90, 90, 90, 255]
            }
        });
        let mipmap = Mipmap::new(&image);
        for (level, x, y) in [(1, 10, 10), (2, 5, 5)] {
            assert_eq!(mipmap.levels()[level].post(x, y)[3], 0);
            assert_eq!(mipmap.levels()[level].post(x + 1, y), [90, 90, 90, 255]);
        }
    }

    #[test]
    fn waves_that_a_level_cannot_hold_fade_and_others_stay() {
        let wave = |period: u32| {
            let image = TiledRaster::from_fn(512, 64, |col, _| {
                let share =
                    (std::f64::consts::TAU * (f64::from(col) + 0.5) / f64::from(period)).sin();
                let level = LinearLight::tables().encode(0.4 + 0.3 * share as f32);
                [level, level, level, 255]
            });
            let mipmap = Mipmap::new(&image);
            let coarse = &mipmap.levels()[1];
            let light = |x| LinearLight::tables().decode(coarse.post(x, 16)[0]);
            let range = (40..200).fold([1.0_f32, 0.0], |[low, high], x| {
                [low.min(light(x)), high.max(light(x))]
            });
            (range[1] - range[0]) / 0.6
        };
        assert!(
            wave(32) > 0.97 && wave(16) > 0.93,
            "{} {}",
            wave(32),
            wave(16)
        );
        assert!(wave(2) < 0.05, "{}", wave(2));
    }

    #[test]
    fn an_edit_is_followed_and_the_rest_shared() {
        let image = TiledRaster::from_fn(1400, 600, noise);
        let before = Mipmap::new(&image);
        assert!(before.levels()[1].is_beside(&image));
        let (edited, changed) =
            image.edited(250..270, 255..258, |_, _, [r, g, b, _]| [b, r, g, 255]);
        let after = before.updated(&edited, &changed);
        let anew = Mipmap::new(&edited);
        for (a, b) in after.levels().iter().zip(anew.levels()) {
            for tile in a.tile_indices() {
                assert_eq!(a.tile_posts(tile), b.tile_posts(tile));
            }
        }
        let far = TileIndex { col: 2, row: 0 };
        assert!(after.levels()[1].shares(&before.levels()[1], far));
    }
}
