//! A photograph at the ground's posts.

use crate::{Ground, Photo, TILE_CELLS};
use glam::DVec2;

/// How many pixels count along an axis.
const TAPS: usize = 4;

/// How many pixels a tile's row may need: there is no more than 1 / [`super::FINER`] from post to post.
const LENGTH: usize = TILE_CELLS as usize * 3 / 2 + 2 * TAPS;

/// How much the pixels around a place count that lies such a part of the way from the second to the third.
pub(super) type Weights = fn(f32) -> [f32; TAPS];

/// Those of the photograph itself, which is linear between pixels.
pub(super) fn linear(part: f32) -> [f32; TAPS] {
    [0.0, 1.0 - part, part, 0.0]
}

/// Catmull and Rom's (1974).
///
/// Where posts lie about as far apart as pixels, but halfway between them, colours that are linear have lost
/// all of the finest detail and a third of what is twice as coarse; a cubic keeps more of that.
pub(super) fn cubic(part: f32) -> [f32; TAPS] {
    let t = part;
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
pub(super) fn resampled<'a>(
    ground: &'a Ground,
    photo: &'a Photo,
    weights: Weights,
) -> impl Fn(u32, u32, &mut [[u8; 4]]) + Sync + 'a {
    let spacing = ground.grid().spacing;
    let last = [photo.pixels.cols(), photo.pixels.rows()].map(|pixels| f64::from(pixels) - 0.5);
    move |row, col, into| {
        let place = |col: u32, row: u32| {
            let at = DVec2::new(f64::from(col), f64::from(row)) * spacing;
            (at, (at - photo.origin) / photo.spacing)
        };
        let [first, end] = [col, col + into.len() as u32 - 1].map(|col| place(col, row).1);
        let (west, south) = (first.x.floor() as i64 - 1, first.y.floor() as i64 - 1);
        let count = (end.x.floor() as i64 + 2 - west + 1) as usize;
        let mut pixels = [[0_u8; 4]; LENGTH];
        let mut sums = [[0.0_f32; 4]; LENGTH];
        // The least coverage in each column.
        let mut covered = [u8::MAX; LENGTH];
        for (at, weight) in (south..).zip(weights(fraction(first.y))) {
            if weight == 0.0 {
                continue;
            }
            let pixels = &mut pixels[..count];
            photo.pixels.copy_row(west, at, pixels);
            for ((sum, covered), pixel) in sums.iter_mut().zip(&mut covered).zip(&*pixels) {
                for (sum, &code) in sum.iter_mut().zip(pixel) {
                    *sum += weight * f32::from(code);
                }
                *covered = (*covered).min(pixel[3]);
            }
        }
        let is_inside_row = (-0.5..=last[1]).contains(&first.y);
        for (col, to) in (col..).zip(into) {
            let (at, pixel) = place(col, row);
            let from = pixel.x.floor();
            let weights = weights((pixel.x - from) as f32);
            let around = (from as i64 - 1 - west) as usize..;
            let (sums, covered) = (&sums[around.clone()][..TAPS], &covered[around][..TAPS]);
            let is_missing = |(&weight, &least): (&f32, &u8)| weight != 0.0 && least == 0;
            let is_inside = is_inside_row && (-0.5..=last[0]).contains(&pixel.x);
            let [r, g, b] = if is_inside && !weights.iter().zip(covered).any(is_missing) {
                let mut colour = [0.5; 3];
                for (sum, weight) in sums.iter().zip(weights) {
                    for (channel, sum) in colour.iter_mut().zip(sum) {
                        *channel += sum * weight;
                    }
                }
                colour.map(|channel| channel as u8)
            } else {
                ground.colour_at(at.x, at.y)
            };
            *to = [r, g, b, 255];
        }
    }
}
