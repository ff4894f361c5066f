//! Ray coherence along image columns (papers' row W5).

use crate::image::{ColumnStrip, Image, STRIP_WIDTH, fill_strips};
use crate::intersect::{GridFrame, GridRay};
use crate::shade::shade;
use crate::{Caster, PreparedScene, Scene};
use glam::DVec3;
use sandtable_terrain::TileIndex;
use sandtable_view::{Rays, View};
use std::ops::Range;
use std::sync::Arc;

/// Casts rows away from the point straight below the eye (in a level view: each column from its
/// bottom up). A ray starts above the nearest place that the three pixels before it reached, and
/// retraces where that start is already inside the terrain (after Wan, Qu and Kaufman 1999, whose
/// ray starts at the distance of the one pixel below it).
///
/// Known error: columns lie in vertical planes only where they pass through the vanishing point of
/// the vertical. Elsewhere a start may lie beyond a nearer hill, which is then missed: rarely in
/// level views, often in rolled ones. The meeting of a ray with a cell is exact.
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
        let frame = GridFrame::new(&self.scene.ground);
        fill_strips(views, images, |strip| cast_strip(&frame, strip));
    }
}

/// Casts a strip row by row, away from the point straight below the eye.
fn cast_strip(frame: &GridFrame<'_>, strip: &mut ColumnStrip<'_>) {
    let rays = strip.view.rays();
    for rows in marches(&strip.view) {
        let upwards = rows.start < rows.end;
        let steps = rows.start.abs_diff(rows.end);
        // How far along the ground each ray of the row before came: to its hit, or to where it
        // left the terrain. Beyond the strip's sides stands infinity, which leaves the choice to
        // the others.
        let mut reach = [0.0; STRIP_WIDTH as usize + 2];
        let width = strip.width() as usize;
        reach[0] = f64::INFINITY;
        reach[width + 1] = f64::INFINITY;
        for step in 0..steps {
            let j = if upwards {
                rows.start + step
            } else {
                rows.start - 1 - step
            };
            cast_row(frame, strip, &rays, j, &mut reach[..width + 2]);
        }
    }
}

/// Casts one row of a strip, each ray from the nearest reach of the three pixels before it.
fn cast_row(
    frame: &GridFrame<'_>,
    strip: &mut ColumnStrip<'_>,
    rays: &Rays,
    j: u32,
    reach: &mut [f64],
) {
    let mut left = reach[0];
    for i in 0..strip.width() {
        let at = i as usize + 1;
        let nearest = left.min(reach[at]).min(reach[at + 1]);
        left = reach[at];
        let ray = rays.ray(strip.first + i, j);
        let along_ground = ray.direction.truncate().length();
        let mut hit = None;
        if let Some(grid_ray) = frame.clip(&ray) {
            if along_ground > 0.0 {
                hit = first_hit_from(&grid_ray, nearest / along_ground);
                reach[at] = hit.unwrap_or(grid_ray.leave) * along_ground;
            } else {
                hit = grid_ray.first_hit(grid_ray.enter);
                reach[at] = 0.0;
            }
        }
        shade(strip, [i, j], frame.ground(), &ray, hit);
    }
}

/// The rows in the order in which coherence runs: from the nadir's row outwards, or towards the
/// zenith's. A range that runs backwards stands for rows `end..start`, last first.
fn marches(view: &View) -> [Range<u32>; 2] {
    let height = view.size[1];
    let row_of = |point| {
        let pixel = view.pixel_of(point)?;
        Some(pixel.y.clamp(0.0, f64::from(height)) as u32)
    };
    if let Some(nadir) = row_of(view.eye - DVec3::Z) {
        [nadir..0, nadir..height]
    } else if let Some(zenith) = row_of(view.eye + DVec3::Z) {
        [0..zenith, height..zenith]
    } else if view.window.upwards().z >= 0.0 {
        [height..0, 0..0]
    } else {
        [0..height, 0..0]
    }
}

/// The first hit at or after `start`, or, where that is inside the terrain, the hit found by
/// retracing towards the eye.
#[inline]
fn first_hit_from(ray: &GridRay<'_>, start: f64) -> Option<f64> {
    let mut from = start.max(ray.enter);
    if from > ray.leave {
        return None;
    }
    let hit = ray.first_hit(from);
    if hit != Some(from) || from <= ray.enter {
        return hit;
    }
    // The start itself is inside: half a cell back at first, then ever further, until the air is
    // reached.
    let mut back = ray.half_cell();
    loop {
        from = (from - back).max(ray.enter);
        if from <= ray.enter || ray.clearance(from) > 0.0 {
            return ray.first_hit(from);
        }
        back *= 1.5;
    }
}
