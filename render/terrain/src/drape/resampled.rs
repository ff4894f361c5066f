//! A photograph at the ground's posts.

use super::kernel::{Kernel, TAPS};
use crate::{Ground, Photo, TILE_CELLS};
use glam::DVec2;

/// How many pixels a tile's row may need: there is no more than 1 / [`super::FINER`] from post to post.
const LENGTH: usize = TILE_CELLS as usize * 3 / 2 + 2 * TAPS;

/// How many of the pixels that count lie before the one before a place.
const BEFORE: i64 = TAPS as i64 / 2 - 1;

/// Fills rows with a photograph's colours at the ground's posts, and with the ground's own where some of
/// the pixels around them are missing.
pub(super) fn resampled<'a>(
    ground: &'a Ground,
    photo: &'a Photo,
    [across, along]: [Kernel; 2],
) -> impl Fn(u32, u32, &mut [[u8; 4]]) + Sync + 'a {
    let spacing = ground.grid().spacing;
    let last = [photo.pixels.cols(), photo.pixels.rows()].map(|pixels| f64::from(pixels) - 0.5);
    move |row, col, into| {
        let place = |col: u32| {
            let at = DVec2::new(f64::from(col), f64::from(row)) * spacing;
            (at, (at - photo.origin) / photo.spacing)
        };
        // Far beside the photograph no pixel is asked for.
        let [first, end] = [col, col + into.len() as u32 - 1].map(|col| place(col).1);
        let west = first.x.floor().max(-1.0).min(last[0]) as i64 - BEFORE;
        let east = end.x.floor().max(-1.0).min(last[0]) as i64 + BEFORE + 1;
        let is_inside_row = (-0.5..=last[1]).contains(&first.y);
        let rows = if is_inside_row {
            *along.weights(first.y)
        } else {
            [0.0; TAPS]
        };
        let south = first.y.floor().max(-1.0).min(last[1]) as i64 - BEFORE;
        let count = (east - west + 1) as usize;
        let mut pixels = [[0_u8; 4]; LENGTH];
        let mut sums = [[0.0_f32; 4]; LENGTH];
        // The least coverage in each column.
        let mut covered = [u8::MAX; LENGTH];
        for (at, weight) in (south..).zip(rows) {
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
        for (col, to) in (col..).zip(into) {
            let (at, pixel) = place(col);
            let is_inside = is_inside_row && (-0.5..=last[0]).contains(&pixel.x);
            let of_photo = is_inside.then(|| {
                let from = (pixel.x.floor() as i64 - BEFORE - west) as usize;
                let weights = across.weights(pixel.x);
                let (sums, covered) = (&sums[from..][..TAPS], &covered[from..][..TAPS]);
                let is_missing = |(&weight, &least): (&f32, &u8)| weight != 0.0 && least == 0;
                let mut colour = [0.5; 3];
                for (sum, weight) in sums.iter().zip(weights) {
                    for (channel, sum) in colour.iter_mut().zip(sum) {
                        *channel += sum * weight;
                    }
                }
                let is_whole = !weights.iter().zip(covered).any(is_missing);
                is_whole.then(|| colour.map(|channel| channel as u8))
            });
            let [r, g, b] = of_photo
                .flatten()
                .unwrap_or_else(|| ground.colour_at(at.x, at.y));
            *to = [r, g, b, 255];
        }
    }
}
