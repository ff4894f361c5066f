//! What a view ought to show: exact rays, many to a pixel.

use super::trial::{Trial, prepared};
use anyhow::Result;
use image::RgbaImage;
use sandtable_cast::{CastPool, Scene};
use sandtable_terrain::LinearLight;
use sandtable_view::{Screen, View};
use std::sync::Arc;

/// Rays along each side of a pixel.
pub(super) const SIDE: u32 = 8;

/// Rows cast at once, so that the fine image takes little memory.
const BAND: u32 = 32;

/// A view's colours, each the mean of [`SIDE`]² exact rays in linear light.
pub(super) struct Truth {
    size: [u32; 2],
    pixels: Vec<[u8; 3]>,
}

impl Truth {
    /// Casts `view`, which has to be level: there the default caster is exact.
    pub(super) fn cast(pool: &CastPool, scene: &Arc<Scene>, view: &View) -> Result<Self> {
        let exact = prepared(pool, scene, "coherent")?;
        let light = LinearLight::tables();
        let [width, height] = view.size;
        let mut pixels = Vec::with_capacity((width * height) as usize);
        for top in (0..height).step_by(BAND as usize) {
            let rows = BAND.min(height - top);
            let fine = Trial::new(&exact, pool, band(view, top, rows)).images()?;
            let fine = fine[0].colour();
            let stride = (width * SIDE) as usize;
            for (row, column) in (0..rows).flat_map(|row| (0..width).map(move |i| (row, i))) {
                let mut sum = [0.0; 3];
                for y in 0..SIDE {
                    let first = (row * SIDE + y) as usize * stride + (column * SIDE) as usize;
                    for ray in &fine[first..first + SIDE as usize] {
                        sum = std::array::from_fn(|k| sum[k] + light.decode(ray[k]));
                    }
                }
                let rays = (SIDE * SIDE) as f32;
                pixels.push(sum.map(|sum: f32| light.encode(sum / rays)));
            }
        }
        let size = view.size;
        Ok(Self { size, pixels })
    }

    /// The peak signal-to-noise ratio of an image of the same view, over all colour channels.
    pub(super) fn psnr_db(&self, image: &RgbaImage) -> f64 {
        let pairs = image.pixels().zip(&self.pixels);
        let squares = pairs.flat_map(|(found, wanted)| {
            (0..3).map(|k| f64::from(found.0[k].abs_diff(wanted[k])).powi(2))
        });
        let mean = squares.sum::<f64>() / (3 * self.pixels.len()) as f64;
        10.0 * (255.0_f64.powi(2) / mean).log10()
    }

    pub(super) fn image(&self) -> RgbaImage {
        let [width, height] = self.size;
        RgbaImage::from_fn(width, height, |i, j| {
            let [r, g, b] = self.pixels[(j * width + i) as usize];
            image::Rgba([r, g, b, 255])
        })
    }
}

/// `rows` rows of `view` from row `top` on, [`SIDE`] times as fine.
fn band(view: &View, top: u32, rows: u32) -> View {
    let [width, height] = view.size;
    let window = view.window;
    let downwards = (window.lower_left - window.upper_left) / f64::from(height);
    let shift = downwards * f64::from(top);
    let size = downwards * f64::from(rows);
    let across = window.lower_right - window.lower_left;
    let upper_left = window.upper_left + shift;
    View {
        eye: view.eye,
        window: Screen {
            upper_left,
            lower_left: upper_left + size,
            lower_right: upper_left + size + across,
        },
        size: [width * SIDE, rows * SIDE],
    }
}
