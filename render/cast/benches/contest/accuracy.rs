//! How much of an image is right.

use anyhow::Result;
use sandtable_cast::{Brute, CastPool, Image, Scene};
use sandtable_view::{Screen, View};
use std::sync::Arc;

/// One in so many pixels is checked along each side. Odd, so that a thinned image's pixels have
/// the centres of whole ones.
const STEP: u32 = 5;

/// A pixel is right where its depth is within this of brute force's, in cells.
const RIGHT_CELLS: f64 = 0.1;

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

    /// The share of the checked pixels that are right in an image with these depths.
    pub(super) fn share_right(&self, depth: &[f32]) -> f64 {
        let [width, height] = self.image.view.size;
        let pixels = (0..height).flat_map(|j| (0..width).map(move |i| (i, j)));
        let of_whole = |i: u32, j: u32| {
            let centre = |at: u32| (STEP * at + STEP / 2) as usize;
            depth[centre(j) * self.width as usize + centre(i)]
        };
        let right = pixels.zip(&self.image.depth).filter(|&((i, j), &exact)| {
            let found = of_whole(i, j);
            found == exact || f64::from((found - exact).abs()) <= RIGHT_CELLS * self.cell
        });
        right.count() as f64 / self.image.depth.len() as f64
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
