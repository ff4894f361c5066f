//! The truth: what pixels show, not points in them.

use anyhow::Result;
use rayon::prelude::*;
use sandtable_cast::{CastPool, Image, PreparedScene};
use sandtable_terrain::LinearLight;
use sandtable_view::View;

/// Rays along each side of a pixel.
const RAYS: u32 = 8;

/// The mean light of 64 rays through each pixel of `view`, which stand in a square lattice, each in
/// the middle of its share of the pixel.
pub(super) fn truth(
    point: &dyn PreparedScene,
    view: &View,
    pool: &CastPool,
) -> Result<Vec<[u8; 4]>> {
    let [width, height] = view.size;
    let mut sums = vec![[0.0_f32; 3]; width as usize * height as usize];
    let mut images = [Image::default()];
    let light = LinearLight::tables();
    let right = view.window.across() / f64::from(width);
    let down = -view.window.upwards() / f64::from(height);
    let places = || (0..RAYS).map(|k| (f64::from(k) + 0.5) / f64::from(RAYS) - 0.5);
    for (y, x) in places().flat_map(|y| places().map(move |x| (y, x))) {
        let aside = x * right + y * down;
        let mut view = *view;
        view.window = view.window.map(|corner| corner + aside);
        pool.cast(point, &[view], &mut images)?;
        let colours = images[0].colour().par_iter();
        pool.run(|| {
            sums.par_iter_mut().zip(colours).for_each(|(sum, colour)| {
                for (sum, &code) in sum.iter_mut().zip(colour) {
                    *sum += light.decode(code);
                }
            });
        });
    }
    let share = 1.0 / (RAYS * RAYS) as f32;
    let encoded = sums.iter().map(|sum| {
        let [r, g, b] = sum.map(|sum| light.encode(sum * share));
        [r, g, b, 255]
    });
    Ok(encoded.collect())
}
