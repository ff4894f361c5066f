//! Quality against time, over the options of level of detail.

use super::psnr::Errors;
use super::truth::truth;
use super::{DETAIL, eyes};
use crate::scenes::BenchScene;
use crate::turns::{cast, prepared, timed};
use anyhow::Result;
use sandtable_cast::{CastPool, Image, PreparedScene};
use sandtable_view::View;
use std::sync::Arc;

/// Values of the option `cell`.
const CELLS: [f64; 7] = [0.7, 1.0, 1.2, 1.5, 2.0, 2.8, 4.0];

/// What one frame in 60 Hz may take, in ms.
pub(super) const FRAME: f64 = 16.6;

/// One scene's line.
pub(super) struct Curve {
    pub(super) scene: String,
    pub(super) points: Vec<Point>,
}

/// What one value of `cell` gives.
pub(super) struct Point {
    pub(super) cell: f64,
    /// For the pair, by way of the default options' time.
    pub(super) ms: f64,
    pub(super) psnr: f64,
}

/// One setting, measured.
struct Measured {
    /// The value of `cell`; none without level of detail.
    cell: Option<f64>,
    psnr: f64,
    /// The median, the least, and the least of the default options that took turns with it.
    ms: f64,
    least: f64,
    usual: f64,
}

/// Finds and prints what both eyes at a table gain and take, as cells grow.
///
/// Each setting takes turns with the default one, as not all fit in memory at once. What the
/// machine does otherwise differs from setting to setting, so times are compared by way of the
/// default's.
pub(super) fn print(
    scene: &BenchScene,
    [point, detail]: [&Arc<dyn PreparedScene>; 2],
    pool: &CastPool,
    rounds: usize,
) -> Result<Option<Curve>> {
    let Some(eyes) = eyes(scene) else {
        return Ok(None);
    };
    let truths = [
        truth(&**point, &eyes[0], pool)?,
        truth(&**point, &eyes[1], pool)?,
    ];
    let measured = |cell, caster: &Arc<dyn PreparedScene>| -> Result<Measured> {
        let entries = vec![
            cast(pool, detail, eyes.to_vec()),
            cast(pool, caster, eyes.to_vec()),
        ];
        let times = timed(rounds, entries)?;
        Ok(Measured {
            cell,
            psnr: psnr(caster, eyes, &truths, pool)?,
            ms: times[1][rounds / 2],
            least: times[1][0],
            usual: times[0][0],
        })
    };
    let mut all = vec![measured(None, point)?];
    for cell in CELLS {
        let caster = prepared(scene, pool, &format!("{DETAIL}&cell={cell}"))?;
        all.push(measured(Some(cell), &caster)?);
    }
    let usual = all.iter().map(|it| it.usual).fold(f64::INFINITY, f64::min);
    println!(
        "\nCurve: PSNR in dB of both eyes at the table, and their ms on {} threads: median of \
         {rounds} turns, the least, its ratio to the default options' least in the same turns, and \
         that ratio times their least of all, {usual:.2}",
        pool.threads()
    );
    println!(
        "{:<11} {:>5} {:>7} {:>9} {:>9} {:>7} {:>9}  <= {FRAME} ms",
        "scene", "cell", "dB", "ms", "least", "ratio", "level ms"
    );
    let mut points = Vec::new();
    for it in &all {
        let ratio = it.least / it.usual;
        let ms = ratio * usual;
        let cell = it.cell.map_or("off".to_owned(), |cell| cell.to_string());
        println!(
            "{:<11} {cell:>5} {:>7.2} {:>9.2} {:>9.2} {ratio:>7.2} {ms:>9.2}  {}",
            scene.name,
            it.psnr,
            it.ms,
            it.least,
            if ms <= FRAME { "yes" } else { "" }
        );
        if let Some(cell) = it.cell {
            let psnr = it.psnr;
            points.push(Point { cell, ms, psnr });
        }
    }
    Ok(Some(Curve {
        scene: scene.name.clone(),
        points,
    }))
}

/// The PSNR of both eyes' images as one.
fn psnr(
    caster: &Arc<dyn PreparedScene>,
    eyes: [View; 2],
    truths: &[Vec<[u8; 4]>; 2],
    pool: &CastPool,
) -> Result<f64> {
    let mut images = [Image::default(), Image::default()];
    pool.cast(&**caster, &eyes, &mut images)?;
    let mut errors = Errors::default();
    for (image, truth) in images.iter().zip(truths) {
        errors.add(image.colour(), truth);
    }
    Ok(errors.psnr())
}
