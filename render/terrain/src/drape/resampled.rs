//! A photograph at posts that lie about as far apart as its pixels, but not on them.

use crate::{Ground, Photo, TILE_CELLS};
use glam::DVec2;

/// How many pixels count along an axis.
const TAPS: usize = 4;

/// How many pixels a tile's row may need: there is no more than 1 / [`super::FINER`] from post to post.
const LENGTH: usize = TILE_CELLS as usize * 3 / 2 + 2 * TAPS;

/// Catmull and Rom's weights of the pixels around a place that lies such a `share` of the way from the
/// second to the third.
fn weights(share: f32) -> [f32; TAPS] {
    let t = share;
    [
        0.5 * t * (t * (2.0 - t) - 1.0),
        0.5 * (t * t * (3.0 * t - 5.0) + 2.0),
        0.5 * t * (t * (4.0 - 3.0 * t) + 1.0),
        0.5 * t * t * (t - 1.0),
    ]
}

/// How far a place lies behind the pixel before it; there may be none.
fn fraction(at: f64) -> f32 {
    (at - at.floor()) as f32
}

/// Fills rows with a photograph's colours at the ground's posts, and with the ground's own where some of
/// the pixels around them are missing.
///
/// Colours that are linear between pixels, seen halfway between these, have lost all of the finest
/// detail and half of what is twice as coarse; a cubic through four pixels (Catmull and Rom 1974) keeps
/// most of that.
pub(super) fn resampled<'a>(
    ground: &'a Ground,
    photo: &'a Photo,
) -> impl Fn(u32, u32, &mut [[u8; 4]]) + Sync + 'a {
    let spacing = ground.grid().spacing;
    let size = [photo.pixels.cols(), photo.pixels.rows()].map(i64::from);
    move |row, col, into| {
        let place = |col: u32, row: u32| {
            let at = DVec2::new(f64::from(col), f64::from(row)) * spacing;
            (at, (at - photo.origin) / photo.spacing)
        };
        let (_, first) = place(col, row);
        let (west, south) = (first.x.floor() as i64 - 1, first.y.floor() as i64 - 1);
        let (_, last) = place(col + into.len() as u32 - 1, row);
        let count = (last.x.floor() as i64 + 2 - west + 1) as usize;
        let mut pixels = [[0_u8; 4]; LENGTH];
        let mut sums = [[0.0_f32; 4]; LENGTH];
        // The least coverage in each column.
        let mut covered = [u8::MAX; LENGTH];
        for (at, weight) in (south..).zip(weights(fraction(first.y))) {
            let pixels = &mut pixels[..count];
            photo.pixels.copy_row(west, at, pixels);
            for ((sum, covered), pixel) in sums.iter_mut().zip(&mut covered).zip(&*pixels) {
                for (sum, &code) in sum.iter_mut().zip(pixel) {
                    *sum += weight * f32::from(code);
                }
                *covered = (*covered).min(pixel[3]);
            }
        }
        for (col, to) in (col..).zip(into) {
            let (at, pixel) = place(col, row);
            let from = (pixel.x.floor() as i64 - 1 - west) as usize;
            let inside = (0..2).all(|axis| (-0.5..=size[axis] as f64 - 0.5).contains(&pixel[axis]));
            let around = from..from + TAPS;
            let [r, g, b] = if inside && covered[around.clone()].iter().all(|&least| least > 0) {
                let weights = weights(fraction(pixel.x));
                [0, 1, 2].map(|channel| {
                    let parts = sums[around.clone()].iter().zip(weights);
                    let sum: f32 = parts.map(|(sum, weight)| sum[channel] * weight).sum();
                    (sum + 0.5) as u8
                })
            } else {
                ground.colour_at(at.x, at.y)
            };
            *to = [r, g, b, 255];
        }
    }
}
