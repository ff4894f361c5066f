//! Holes in the heights, filled as a stretched membrane would: each hole post becomes the mean of
//! its neighbours.
//!
//! A pyramid of means gives each hole a first value from its surroundings (pull), coarse levels
//! are interpolated into finer ones (push), and a few sweeps on each level let the membrane
//! settle, so that small and large holes alike meet their rim without a step. Every value is a
//! mean of others, so none leaves the range of the heights around.

use crate::{Holes, TiledRaster};
use rayon::prelude::*;

/// Sweeps over the posts' holes; what these leave, coarser levels have removed.
const FINE_SWEEPS: usize = 6;
/// Sweeps over a coarser level's holes, which are fewer.
const COARSE_SWEEPS: usize = 24;

/// Heights whose holes can be filled one by one.
trait Membrane {
    fn size(&self) -> [u32; 2];
    fn post(&self, col: u32, row: u32) -> f32;
    fn set(&mut self, col: u32, row: u32, value: f32);
}

/// One level of means; NaN where nothing is known.
struct Level {
    size: [u32; 2],
    values: Vec<f32>,
}

impl Membrane for Level {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn post(&self, col: u32, row: u32) -> f32 {
        self.values[row as usize * self.size[0] as usize + col as usize]
    }

    fn set(&mut self, col: u32, row: u32, value: f32) {
        self.values[row as usize * self.size[0] as usize + col as usize] = value;
    }
}

impl Membrane for TiledRaster<f32> {
    fn size(&self) -> [u32; 2] {
        [self.cols(), self.rows()]
    }

    fn post(&self, col: u32, row: u32) -> f32 {
        TiledRaster::post(self, col, row)
    }

    fn set(&mut self, col: u32, row: u32, value: f32) {
        TiledRaster::set(self, col, row, value);
    }
}

/// Gives each hole a height that continues its surroundings. At least one post must be no hole.
pub(crate) fn fill_holes(heights: &mut TiledRaster<f32>, holes: &Holes) {
    let mut levels = vec![halved(heights)];
    while let Some(last) = levels.last()
        && last.values.len() > 1
        && last.values.par_iter().any(|value| value.is_nan())
    {
        levels.push(halved(last));
    }
    let mut coarser: Option<Level> = None;
    while let Some(mut level) = levels.pop() {
        if let Some(coarser) = &coarser {
            let [cols, rows] = level.size;
            if let Some(holes) =
                Holes::collect(cols, rows, |col, row| level.post(col, row).is_nan())
            {
                settle(&mut level, coarser, &holes, COARSE_SWEEPS);
            }
        }
        coarser = Some(level);
    }
    if let Some(coarser) = coarser {
        settle(heights, &coarser, holes, FINE_SWEEPS);
    }
}

/// A level of half the size: each value the mean of those of four that are known.
fn halved(fine: &(impl Membrane + Sync)) -> Level {
    let [fine_cols, fine_rows] = fine.size();
    let size = [fine_cols.div_ceil(2), fine_rows.div_ceil(2)];
    let mut values = vec![f32::NAN; size[0] as usize * size[1] as usize];
    values
        .par_chunks_mut(size[0] as usize)
        .enumerate()
        .for_each(|(row, values)| {
            let rows = 2 * row as u32..fine_rows.min(2 * row as u32 + 2);
            for (col, value) in values.iter_mut().enumerate() {
                let cols = 2 * col as u32..fine_cols.min(2 * col as u32 + 2);
                let four = rows
                    .clone()
                    .flat_map(|row| cols.clone().map(move |col| (col, row)));
                *value = mean(four.map(|(col, row)| fine.post(col, row)));
            }
        });
    Level { size, values }
}

/// Fills a level's holes from the next coarser level, then lets them settle.
fn settle(level: &mut impl Membrane, coarser: &Level, holes: &Holes, sweeps: usize) {
    let [cols, rows] = level.size();
    for row in 0..rows {
        for col in holes.in_row(row) {
            level.set(col, row, interpolated(coarser, col, row));
        }
    }
    for sweep in 0..sweeps {
        for step in 0..rows {
            // Every other sweep runs the other way, so that the rim's pull reaches both ways.
            let row = if sweep % 2 == 0 {
                step
            } else {
                rows - 1 - step
            };
            for col in holes.in_row(row) {
                let neighbours = [
                    (col > 0).then(|| (col - 1, row)),
                    (col + 1 < cols).then_some((col + 1, row)),
                    (row > 0).then(|| (col, row - 1)),
                    (row + 1 < rows).then_some((col, row + 1)),
                ];
                let near = neighbours.into_iter().flatten();
                let value = mean(near.map(|(col, row)| level.post(col, row)));
                level.set(col, row, value);
            }
        }
    }
}

/// A fine post's value, bilinear between the coarser level's cells, whose centres lie half a post
/// off.
fn interpolated(coarser: &Level, col: u32, row: u32) -> f32 {
    let along = |at: u32, size: u32| {
        let own = at / 2;
        let other = if at.is_multiple_of(2) {
            own.saturating_sub(1)
        } else {
            (own + 1).min(size - 1)
        };
        [own, other]
    };
    let [own_col, other_col] = along(col, coarser.size[0]);
    let [own_row, other_row] = along(row, coarser.size[1]);
    let blend = |own: f32, other: f32| own + 0.25 * (other - own);
    blend(
        blend(
            coarser.post(own_col, own_row),
            coarser.post(other_col, own_row),
        ),
        blend(
            coarser.post(own_col, other_row),
            coarser.post(other_col, other_row),
        ),
    )
}

/// The mean of the values that are known, NaN if none is; never outside their range.
fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (mut sum, mut count) = (0.0_f32, 0.0_f32);
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    for value in values.filter(|value| !value.is_nan()) {
        sum += value;
        count += 1.0;
        (low, high) = (low.min(value), high.max(value));
    }
    if count == 0.0 {
        f32::NAN
    } else {
        (sum / count).clamp(low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A raster with NaN where `hole`, filled, and its holes.
    fn filled(
        cols: u32,
        rows: u32,
        height: impl Fn(u32, u32) -> f32 + Sync,
        hole: impl Fn(u32, u32) -> bool + Sync,
    ) -> (TiledRaster<f32>, Holes) {
        let mut raster = TiledRaster::from_fn(cols, rows, |col, row| {
            if hole(col, row) {
                f32::NAN
            } else {
                height(col, row)
            }
        });
        let holes = Holes::collect(cols, rows, hole).unwrap();
        fill_holes(&mut raster, &holes);
        (raster, holes)
    }

    #[test]
    fn a_hole_in_a_plane_is_filled_with_the_plane() {
        let plane = |col: u32, row: u32| 100.0 + 0.5 * col as f32 - 0.25 * row as f32;
        let disc = |col: u32, row: u32| (col as f32 - 250.0).hypot(row as f32 - 260.0) < 40.0;
        let (raster, _) = filled(520, 500, plane, disc);
        for row in 0..500 {
            for col in 0..520 {
                let off = raster.post(col, row) - plane(col, row);
                assert!(
                    off.abs() < if disc(col, row) { 0.8 } else { 1e-6 },
                    "{off} at {col}, {row}"
                );
            }
        }
    }

    #[test]
    fn filled_heights_stay_in_range_and_meet_the_rim_smoothly() {
        let hills = |col: u32, row: u32| {
            500.0 + 80.0 * (col as f32 * 0.05).sin() + 60.0 * (row as f32 * 0.04).cos()
        };
        // A slanted rim along two sides, as a quadrangle turned against its grid has, and a void.
        let hole = |col: u32, row: u32| {
            col + row / 4 < 60
                || row + col / 5 > 340
                || (col as i32 - 150).abs() + (row as i32 - 150).abs() < 45
        };
        let (raster, holes) = filled(300, 320, hills, hole);
        let mut steepest = 0.0_f32;
        for row in 0..320 {
            for col in 0..300 {
                let height = raster.post(col, row);
                assert!(
                    (360.0..=640.0).contains(&height),
                    "{height} at {col}, {row}"
                );
                if col > 0 && (holes.contains(col, row) || holes.contains(col - 1, row)) {
                    steepest = steepest.max((height - raster.post(col - 1, row)).abs());
                }
            }
        }
        // The hills themselves rise by up to 4 a post.
        assert!(steepest < 6.0, "a step of {steepest} m");
    }

    #[test]
    fn any_number_of_threads_fills_alike() {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                filled(
                    700,
                    300,
                    |col, row| ((col * 31 + row * 17) % 97) as f32,
                    |col, row| (col / 60 + row / 50) % 3 == 0,
                )
                .0
            })
        };
        let (one, three) = (run(1), run(3));
        for tile in one.tile_indices() {
            assert_eq!(one.tile_posts(tile), three.tile_posts(tile));
        }
    }

    #[test]
    fn a_single_known_post_fills_everything() {
        let (raster, _) = filled(9, 7, |_, _| 42.0, |col, row| (col, row) != (8, 0));
        assert!((0..7).all(|row| (0..9).all(|col| raster.post(col, row) == 42.0)));
    }
}
