//! Ray coherence along image columns (papers' row W5).

use crate::image::{ColumnStrip, Image, fill_strips};
use crate::intersect::GridRay;
use crate::shade::sky;
use crate::{Caster, PreparedScene, Scene};
use sandtable_terrain::{Ground, TileIndex};
use sandtable_view::View;
use std::sync::Arc;

/// Casts each image column from its bottom up: a ray starts at the distance at which the ray below
/// it hit, and retraces where that start is already inside the terrain (Wan, Qu and Kaufman 1999).
///
/// Known error: a column's rays lie in one vertical plane only where the view has no roll and the
/// column passes through the vanishing point of the vertical; elsewhere a start may lie beyond a
/// nearer hill, which is then missed. Cell intersections themselves are exact.
#[derive(Clone, Copy, Debug)]
pub struct Coherent;

impl Caster for Coherent {
    fn name(&self) -> &'static str {
        "coherent"
    }

    fn summary(&self) -> &'static str {
        "each column from its bottom up, starting at the last hit, with retracing: for level views"
    }

    fn prepare(&self, scene: Arc<Scene>) -> Arc<dyn PreparedScene> {
        Arc::new(CoherentScene { scene })
    }
}

/// Coherence reads the ground as it is.
struct CoherentScene {
    scene: Arc<Scene>,
}

impl PreparedScene for CoherentScene {
    fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn updated(&self, scene: Arc<Scene>, _changed: &[TileIndex]) -> Arc<dyn PreparedScene> {
        Coherent.prepare(scene)
    }

    fn cast(&self, views: &[View], images: &mut [Image]) {
        let ground = &*self.scene.ground;
        fill_strips(views, images, |strip| {
            for i in 0..strip.width() {
                cast_column(ground, strip, i);
            }
        });
    }
}

/// Casts one image column, from the bottom up.
fn cast_column(ground: &Ground, strip: &mut ColumnStrip<'_>, i: u32) {
    let mut start_distance = 0.0;
    for j in (0..strip.height()).rev() {
        let ray = strip.view.ray(strip.first + i, j);
        let length = ray.direction.length();
        let hit = GridRay::new(ground, ray.origin, ray.direction)
            .and_then(|grid_ray| first_hit_from(&grid_ray, start_distance / length));
        match hit {
            Some(t) => {
                start_distance = t * length;
                let p = ray.origin + t * ray.direction;
                strip.set(i, j, ground.colour_at(p.x, p.y), start_distance as f32);
            }
            None => strip.set(i, j, sky(ray.direction), f32::INFINITY),
        }
    }
}

/// The first hit at or after `start`, or, where that is inside the terrain, the hit found by
/// retracing towards the eye.
fn first_hit_from(ray: &GridRay<'_>, start: f64) -> Option<f64> {
    let mut from = start.max(ray.enter);
    if from > ray.leave {
        return None;
    }
    // Half a cell back at first, then ever further, until the air is reached.
    let mut back = ray.half_cell();
    while from > ray.enter && ray.clearance(from) <= 0.0 {
        from = (from - back).max(ray.enter);
        back *= 1.5;
    }
    ray.first_hit(from)
}
