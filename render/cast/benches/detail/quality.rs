//! Images without and with level of detail, against the truth.

use super::footprint;
use super::psnr::Errors;
use super::truth::truth;
use crate::scenes::BenchScene;
use anyhow::Result;
use sandtable_cast::{CastPool, Image, PreparedScene};
use std::sync::Arc;

/// Prints for each view of `scene` the median footprint of a pixel in posts, and how near to the
/// truth the image is without and with level of detail.
pub(super) fn print(
    scene: &BenchScene,
    casters: [&Arc<dyn PreparedScene>; 2],
    pool: &CastPool,
) -> Result<()> {
    println!("\nQuality: PSNR in dB over the whole image, against 64 rays a pixel");
    println!(
        "{:<11} {:<7} {:>9} {:>9} {:>9} {:>7}  goal",
        "scene", "view", "footprint", "point", "detail", "gain"
    );
    for at in &scene.views {
        let truth = truth(&**casters[0], &at.view, pool)?;
        let mut images = [Image::default()];
        let mut footprint = None;
        let mut psnr = [0.0; 2];
        for (caster, psnr) in casters.into_iter().zip(&mut psnr) {
            pool.cast(&**caster, &[at.view], &mut images)?;
            if footprint.is_none() {
                footprint = footprint::median(&images[0], scene.scene.ground.grid());
            }
            let mut errors = Errors::default();
            errors.add(images[0].colour(), &truth);
            *psnr = errors.psnr();
        }
        let [point, detail] = psnr;
        let footprint = footprint.unwrap_or(0.0);
        println!(
            "{:<11} {:<7} {footprint:>9.2} {point:>9.2} {detail:>9.2} {:>7.2}  {}",
            scene.name,
            at.name,
            detail - point,
            if footprint > 1.0 { ">= 1" } else { ">= 0" }
        );
    }
    Ok(())
}
