//! Fractal mountains of any size, as rough as mountains get: a hybrid multifractal with ridges.
//!
//! Octaves of noise from three waves across the terrain down to waves of two or three cells, each
//! weighted by what the coarser ones have left: valleys are smooth, ridges are rough.

use super::noise::noise;
use super::photo::with_photo;
use anyhow::Result;
use glam::DVec2;
use rayon::prelude::*;
use sandtable_terrain::Ground;

/// Waves of the broadest octave across the terrain.
const BROADEST: f64 = 3.0;
/// The shortest wave of the finest octave, in cells.
const FINEST_CELLS: f64 = 2.0;
/// From one octave's height to the next one's, which is half as long.
const GAIN: f32 = 0.47;
/// How much of an octave's signal is ridges: of the broadest three, and of the others.
const RIDGES: [f32; 2] = [0.55, 0.45];
/// Octave by octave the next one's weight is the signal times this, 1 at most.
const ROUGHNESS: f32 = 1.6;
/// Where in the noise the mountains lie. Other places are as rough in themselves, but have another
/// span of heights to fill the relief with; this one has middling slopes.
const FIRST_SHIFT: u32 = 6;
/// From the lowest to the highest post, as a share of the terrain's side.
const RELIEF: f64 = 0.12;
/// Heights are whole multiples of this share of the relief, so that 16 bits hold them exactly.
const STEPS: f32 = 65_535.0;

/// The ground of `side` by `side` posts, a metre apart, under its photograph.
pub(super) fn ground(side: u32) -> Result<Ground> {
    let heights = heights(side);
    let height = |col: u32, row: u32| heights[row as usize * side as usize + col as usize];
    Ok(with_photo(Ground::from_fn(side, side, DVec2::ONE, height)?))
}

/// Heights in cells, row by row from the south: from 0 up to the relief.
fn heights(side: u32) -> Vec<f32> {
    let cells = f64::from(side - 1);
    let octaves = (f64::from(side) / BROADEST / FINEST_CELLS).log2().floor() as u32 + 1;
    let mut heights = vec![0.0; side as usize * side as usize];
    heights
        .par_chunks_mut(side as usize)
        .enumerate()
        .for_each(|(row, heights)| {
            let y = row as f64 / cells;
            for (col, height) in heights.iter_mut().enumerate() {
                *height = mountains(col as f64 / cells, y, octaves);
            }
        });
    let low = heights
        .par_iter()
        .copied()
        .reduce(|| f32::INFINITY, f32::min);
    let high = heights
        .par_iter()
        .copied()
        .reduce(|| f32::NEG_INFINITY, f32::max);
    let step = (RELIEF * cells) as f32 / STEPS;
    heights
        .par_iter_mut()
        .for_each(|height| *height = ((*height - low) / (high - low) * STEPS).round() * step);
    heights
}

/// The height, in no unit, at a place as shares of the terrain's side.
fn mountains(x: f64, y: f64, octaves: u32) -> f32 {
    let (mut frequency, mut height, mut sum, mut weight) = (BROADEST, 1.0, 0.0, 1.0);
    for octave in 0..octaves {
        // Octaves are shifted against each other, so that their lattices do not meet.
        let shift = f64::from(FIRST_SHIFT + octave);
        let n = noise(
            x * frequency + 13.37 * shift,
            y * frequency + 7.91 * shift,
            octave,
        );
        let ridge = (1.0 - (1.4 * n).abs()).powi(2);
        let ridges = RIDGES[usize::from(octave >= 3)];
        let signal = ridges * ridge + (1.0 - ridges) * (n + 0.5);
        sum += weight * height * signal;
        weight = (weight * signal * ROUGHNESS).min(1.0);
        frequency *= 2.0;
        height *= GAIN;
    }
    sum
}
