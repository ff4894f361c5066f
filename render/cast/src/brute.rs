//! Brute force: the judge of all other casters.

use crate::image::{Image, fill_strips};
use crate::intersect::GridFrame;
use crate::shade::shade;
use crate::{Caster, PreparedScene, Scene};
use sandtable_terrain::TileIndex;
use sandtable_view::View;
use std::sync::Arc;

/// Casts every pixel alone: each ray is walked cell by cell from where it enters the terrain's
/// bounds to its first meeting with the solid terrain, in f64. Known error: none.
#[derive(Clone, Copy, Debug)]
pub struct Brute;

impl Caster for Brute {
    fn name(&self) -> &'static str {
        "brute"
    }

    fn summary(&self) -> &'static str {
        "each pixel alone, first intersection with the solid terrain in f64: exact and slow"
    }

    fn prepare(&self, scene: Arc<Scene>) -> Arc<dyn PreparedScene> {
        Arc::new(BruteScene { scene })
    }
}

/// Brute force needs nothing but the ground.
struct BruteScene {
    scene: Arc<Scene>,
}

impl PreparedScene for BruteScene {
    fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn updated(&self, scene: Arc<Scene>, _changed: &[TileIndex]) -> Arc<dyn PreparedScene> {
        Brute.prepare(scene)
    }

    fn cast(&self, views: &[View], images: &mut [Image]) {
        let frame = GridFrame::new(&self.scene.ground);
        fill_strips(views, images, |strip| {
            let rays = strip.view.rays();
            for j in 0..strip.height() {
                for i in 0..strip.width() {
                    let ray = rays.ray(strip.first + i, j);
                    let hit = frame
                        .clip(&ray)
                        .and_then(|clipped| clipped.first_hit(clipped.enter));
                    shade(strip, [i, j], frame.ground(), &ray, hit);
                }
            }
        });
    }
}
