//! How much of an image is right.

use anyhow::Result;
use sandtable_cast::{Brute, CastPool, Image, Scene};
use sandtable_view::{Screen, View};
use std::sync::Arc;

/// One in so many pixels is checked along each side. Odd, so that a thinned image's pixels have
/// the centres of whole ones.
const STEP: u32 = 5;

/// A pixel is right where its depth is within this of brute force's, in cells, and its colour is
/// within this of brute force's in each channel. Of skies only the depth counts.
const RIGHT_CELLS: f64 = 0.1;
const RIGHT_COLOUR: u8 = 32;

/// What brute force sees in some pixels of a view.
pub(super) struct Truth {
    image: Image,
    width: u32,
    cell: f64,
}

impl Truth {
    /// Casts the pixels of `view` that are checked, on all cores.
    pub(super) fn of(scene: &Arc<Scene>, view: &View) -> Result<Self> {
        Ok(Self {
            image: CastPool::new(0)?.picture(&Brute, scene, thinned(view))?,
            width: view.size[0],
            cell: scene.ground.grid().cell_length(),
        })
    }

    /// The share of the checked pixels that are right in an image of these depths and colours.
    pub(super) fn share_right(&self, depth: &[f32], colour: &[[u8; 4]]) -> f64 {
        let exact = &self.image;
        let pixels = (0..exact.height()).flat_map(|j| (0..exact.width()).map(move |i| (i, j)));
        let exact_pixels = exact.depth.iter().zip(exact.colour());
        let right = pixels.zip(exact_pixels).filter(|&((i, j), (&far, shade))| {
            let [i, j] = [i, j].map(|at| (STEP * at + STEP / 2) as usize);
            let at = j * self.width as usize + i;
            if far.is_infinite() {
                return depth[at] == far;
            }
            let near = |k: usize| colour[at][k].abs_diff(shade[k]) <= RIGHT_COLOUR;
            f64::from((depth[at] - far).abs()) <= RIGHT_CELLS * self.cell && (0..3).all(near)
        });
        right.count() as f64 / exact.depth.len() as f64
    }
}

/// The view of which pixel (i, j) has the ray of pixel (STEP i + STEP / 2, STEP j + STEP / 2).
fn thinned(view: &View) -> View {
    let size = view.size.map(|pixels| pixels / STEP);
    let share = |k: usize| f64::from(STEP * size[k]) / f64::from(view.size[k]);
    let Screen { upper_left, .. } = view.window;
    let lower_left = upper_left - share(1) * view.window.upwards();
    View {
        eye: view.eye,
        window: Screen {
            upper_left,
            lower_left,
            lower_right: lower_left + share(0) * view.window.across(),
        },
        size,
    }
}
