//! How an image is cast, pixel by pixel: what the pictures of `docs/planes.md` show.

use super::PlanesScene;
use super::rows::{Scratch, begins, looks};
use crate::canvas::Canvas;
use crate::lanes::Isa;
use crate::units::UnitCaster;
use crate::{Image, Scene};
use sandtable_view::View;
use std::sync::Arc;

/// How the default caster goes about an image: a number a pixel, row by row from the top.
pub struct Survey {
    /// The image.
    pub image: Image,
    /// Which sector each pixel is in.
    pub sectors: Vec<u32>,
    /// Over how many cells and blocks its ray was led.
    pub looks: Vec<u32>,
    /// How many steps back the ray lies from which its ray begins, 0 for none.
    pub begins: Vec<u32>,
}

impl Survey {
    /// Casts `view` of `scene` and takes note of it all. `None` where each pixel is cast alone.
    #[must_use]
    pub fn of(scene: &Arc<Scene>, view: &View) -> Option<Self> {
        let mut image = Image::default();
        image.reset(*view);
        if image.depth.is_empty() {
            return None;
        }
        let planes = PlanesScene::new(Isa::best(), None, Arc::clone(scene));
        let frame = planes.frame(view).ok()?;
        if frame.alone.is_some() {
            return None;
        }
        let none = vec![0; image.depth.len()];
        let [mut sectors, mut looked, mut began] = [none.clone(), none.clone(), none];
        let canvas = Canvas::new(&mut image);
        let mut scratch = Scratch::default();
        for (number, sector) in (0..).zip(&frame.sectors) {
            let pixels = (0..sector.steps).flat_map(|step| {
                let [from, to] = sector.lanes(step);
                (from..to).map(move |lane| sector.pixel(step, lane))
            });
            let pixels: Vec<_> = pixels
                .map(|[i, j]| (j * view.size[0] + i) as usize)
                .collect();
            for &pixel in &pixels {
                sectors[pixel] = number;
            }
            looks(&frame, sector, &mut scratch, &canvas, &mut looked);
            for (&pixel, steps) in pixels.iter().zip(begins(&frame, sector)) {
                began[pixel] = steps;
            }
        }
        Some(Self {
            image,
            sectors,
            looks: looked,
            begins: began,
        })
    }
}
