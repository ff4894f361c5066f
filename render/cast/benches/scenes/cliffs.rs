//! Grounds with cliffs all over, between which there is no steepest slope to rely on.

use super::noise::{hash, noise};
use super::photo::with_photo;
use anyhow::Result;
use glam::DVec2;
use sandtable_terrain::Ground;

/// Which cliffs.
#[derive(Clone, Copy)]
pub(super) enum Cliffs {
    /// One post in a hundred is a spike of 30 m over gentle ground.
    Spikes,
    /// Mountains that are cut by gorges of 150 m.
    Gorges,
    /// Trees of 12 to 28 m over hills, with clearings.
    Wood,
    /// Flat blocks of up to 40 m, wall to wall, and lanes between some.
    Boxes,
}

impl Cliffs {
    /// What scenes are called, without their size.
    pub(super) const ALL: [(&str, Self); 4] = [
        ("spikes", Self::Spikes),
        ("gorges", Self::Gorges),
        ("wood", Self::Wood),
        ("boxes", Self::Boxes),
    ];

    /// The ground of `side` by `side` posts, a metre apart, under its photograph.
    pub(super) fn ground(self, side: u32) -> Result<Ground> {
        let height = |col: u32, row: u32| match self {
            Self::Spikes => spikes(col, row),
            Self::Gorges => gorges(col, row),
            Self::Wood => 0.4 * mountains(col, row) + wood(col, row),
            Self::Boxes => boxes(col, row),
        };
        Ok(with_photo(Ground::from_fn(side, side, DVec2::ONE, height)?))
    }
}

/// From 0 to 1, a number of a lattice point's own.
fn share(x: u32, y: u32, seed: u32) -> f32 {
    (hash(x as i32, y as i32, seed) >> 8) as f32 / (1 << 24) as f32
}

/// Octaves of noise, the broadest `wave` posts long and up to about `height` metres over and below 0.
fn hills(col: u32, row: u32, wave: f64, height: f32, octaves: u32) -> f32 {
    let [x, y] = [col, row].map(|at| f64::from(at) / wave);
    (0..octaves)
        .map(|octave| {
            let times = f64::from(1 << octave);
            height / times as f32 * noise(x * times, y * times, octave)
        })
        .sum()
}

fn mountains(col: u32, row: u32) -> f32 {
    hills(col, row, 340.0, 180.0, 8)
}

fn spikes(col: u32, row: u32) -> f32 {
    if share(col, row, 4) > 0.99 {
        30.0
    } else {
        hills(col, row, 30.0, 3.0, 3)
    }
}

fn gorges(col: u32, row: u32) -> f32 {
    let height = mountains(col, row);
    if height.abs() < 12.0 {
        height - 150.0
    } else {
        height
    }
}

/// The height of the highest crown over a post; trees stand on a grid, each somewhere in its square.
fn wood(col: u32, row: u32) -> f32 {
    const SQUARE: u32 = 6;
    let [x, y] = [col, row].map(|at| f64::from(at) / 90.0);
    if noise(x, y, 77) > 0.12 {
        return 0.0;
    }
    // One more square before the first, so that none is numbered below 0.
    let [x, y] = [col, row].map(|at| at + SQUARE);
    let mut top = 0.0_f32;
    for square_x in x / SQUARE - 1..=x / SQUARE + 1 {
        for square_y in y / SQUARE - 1..=y / SQUARE + 1 {
            let of_its_own = |seed: u32| share(square_x, square_y, seed);
            if of_its_own(7) > 0.8 {
                continue;
            }
            let aside = |at: u32, square: u32, seed: u32| {
                at as f32 - SQUARE as f32 * (square as f32 + of_its_own(seed))
            };
            let [x, y] = [aside(x, square_x, 8), aside(y, square_y, 9)];
            let radius = 2.0 + 2.5 * of_its_own(10);
            let part = (x * x + y * y) / (radius * radius);
            if part < 1.0 {
                top = top.max((12.0 + 16.0 * of_its_own(11)) * (1.0 - 0.6 * part));
            }
        }
    }
    top
}

fn boxes(col: u32, row: u32) -> f32 {
    (60.0 * share(col / 9, row / 7, 4) - 20.0).max(0.0)
}
