//! The floor under every caster: colouring alone.

use super::rows::{Scratch, reaches, recolour_sector};
use super::{Frame, PlanesScene, SCRATCH, Sector};
use crate::canvas::Canvas;
use crate::lanes::{Isa, Kernel, Lanes};
use crate::units::UnitCaster;
use crate::{Image, Scene, Scheme};
use std::sync::Arc;

/// An image whose hits are known: what remains are the default caster's own passes that set up
/// directions, locate and blend colours, and write pixels.
///
/// Its time is what a caster would need if finding hits cost nothing.
pub struct ShadeFloor {
    planes: PlanesScene,
    image: Image,
    /// For each sector, how far its rays reach.
    reaches: Vec<Vec<f32>>,
}

impl ShadeFloor {
    /// Takes the hits from a finished image of `scene`. `None` where the default caster casts each
    /// pixel alone (from an eye in the ground, or very far away), so that it has no such passes, and
    /// where there are no pixels.
    #[must_use]
    pub fn new(scene: &Arc<Scene>, image: &Image) -> Option<Self> {
        if image.depth.is_empty() {
            return None;
        }
        let planes = PlanesScene::new(Isa::best(), None, Arc::clone(scene));
        let frame = planes.frame(&image.view).ok()?;
        if frame.alone.is_some() {
            return None;
        }
        let sectors = frame.sectors.iter();
        let reaches = sectors
            .map(|sector| reaches(&frame, sector, image))
            .collect();
        drop(frame);
        let mut coloured = Image::default();
        coloured.reset(image.view);
        Some(Self {
            planes,
            image: coloured,
            reaches,
        })
    }

    /// Colours every pixel and tells its depth, on the current thread pool.
    pub fn shade(&mut self) {
        let view = self.image.view;
        // A view that was taken once is taken again.
        let Ok(frame) = self.planes.frame(&view) else {
            return;
        };
        let canvas = Canvas::new(&mut self.image);
        Scheme::default().run(frame.sectors.len(), |unit| {
            SCRATCH.with_borrow_mut(|scratch| {
                frame.isa.run(RecolourSector {
                    frame: &frame,
                    sector: &frame.sectors[unit],
                    reaches: &self.reaches[unit],
                    scratch,
                    canvas: &canvas,
                });
            });
        });
    }

    /// What [`shade`](Self::shade) has made: the image whose hits were taken, but for rounding.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.image
    }
}

struct RecolourSector<'a> {
    frame: &'a Frame<'a>,
    sector: &'a Sector,
    reaches: &'a [f32],
    scratch: &'a mut Scratch,
    canvas: &'a Canvas<'a>,
}

impl Kernel for RecolourSector<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        recolour_sector(
            lanes,
            self.frame,
            self.sector,
            self.reaches,
            self.scratch,
            self.canvas,
        );
    }
}
