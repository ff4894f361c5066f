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

/// Values of the options `cell` and `blur`.
const CELLS: [f64; 7] = [1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0];
const BLURS: [f64; 2] = [1.0, 1.25];

/// What one frame in 60 Hz may take, in ms.
pub(super) const FRAME: f64 = 16.6;

/// One scene's line for one value of `blur`.
pub(super) struct Curve {
    pub(super) scene: String,
    pub(super) blur: f64,
    pub(super) points: Vec<Point>,
}

/// What one value of `cell` gives.
pub(super) struct Point {
    pub(super) cell: f64,
    /// The median of the pair.
    pub(super) ms: f64,
    pub(super) psnr: f64,
}

/// Finds and prints what both eyes at a table gain and take, as options are turned.
///
/// Each setting takes turns with the default one, as not all fit in memory at once.
pub(super) fn print(
    scene: &BenchScene,
    [point, detail]: [&Arc<dyn PreparedScene>; 2],
    pool: &CastPool,
    rounds: usize,
) -> Result<Vec<Curve>> {
    let Some(eyes) = eyes(scene) else {
        return Ok(Vec::new());
    };
    let truths = [
        truth(&**point, &eyes[0], pool)?,
        truth(&**point, &eyes[1], pool)?,
    ];
    println!(
        "\nCurve: PSNR in dB of both eyes at the table, and their ms on {} threads: median of \
         {rounds} turns, the least, and the median to that of the default options",
        pool.threads()
    );
    println!(
        "{:<11} {:>5} {:>5} {:>7} {:>9} {:>9} {:>7}  <= {FRAME} ms",
        "scene", "cell", "blur", "dB", "ms", "least", "ratio"
    );
    let measured = |caster: &Arc<dyn PreparedScene>| -> Result<([f64; 3], f64)> {
        let entries = vec![
            cast(pool, detail, eyes.to_vec()),
            cast(pool, caster, eyes.to_vec()),
        ];
        let times = timed(rounds, entries)?;
        let [usual, ms] = [0, 1].map(|entry| times[entry][rounds / 2]);
        Ok((
            [ms, times[1][0], ms / usual],
            psnr(caster, eyes, &truths, pool)?,
        ))
    };
    let line = |cell: &str, blur: &str, psnr: f64, [ms, least, ratio]: [f64; 3]| {
        println!(
            "{:<11} {cell:>5} {blur:>5} {psnr:>7.2} {ms:>9.2} {least:>9.2} {ratio:>7.2}  {}",
            scene.name,
            if ms <= FRAME { "yes" } else { "" }
        );
    };
    let (times, db) = measured(point)?;
    line("off", "", db, times);
    let mut curves = Vec::new();
    for blur in BLURS {
        let mut points = Vec::new();
        for cell in CELLS {
            let caster = prepared(scene, pool, &format!("{DETAIL}&cell={cell}&blur={blur}"))?;
            let (times, psnr) = measured(&caster)?;
            line(&cell.to_string(), &blur.to_string(), psnr, times);
            points.push(Point {
                cell,
                ms: times[0],
                psnr,
            });
        }
        curves.push(Curve {
            scene: scene.name.clone(),
            blur,
            points,
        });
    }
    Ok(curves)
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
