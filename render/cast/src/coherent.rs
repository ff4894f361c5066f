//! Ray coherence along image columns (papers' row W5).

use crate::canvas::Canvas;
use crate::intersect::{GridFrame, GridRay};
use crate::shade::shade;
use crate::tally::Tally;
use crate::units::UnitCaster;
use crate::{CastError, Caster, PreparedScene, Scene};
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
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        Ok(Arc::new(CoherentScene { scene }))
    }
}

/// Coherence reads the ground as it is.
struct CoherentScene {
    scene: Arc<Scene>,
}

/// How many columns one unit casts: narrow enough to balance, wide enough that few starts lie at
/// its sides, where one of the three neighbours is missing.
const STRIP_WIDTH: u32 = 64;

/// One view: its rays, and the ground as they meet it.
struct Frame<'a> {
    grid: GridFrame<'a>,
    rays: Rays,
    size: [u32; 2],
    marches: [Range<u32>; 2],
}

impl UnitCaster for CoherentScene {
    type Frame<'a> = Frame<'a>;

    fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn updated(
        &self,
        scene: Arc<Scene>,
        _changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError> {
        Coherent.prepare(scene)
    }

    fn frame<'a>(&'a self, view: &'a View) -> Result<Frame<'a>, CastError> {
        Ok(Frame {
            grid: GridFrame::new(&self.scene.ground),
            rays: view.rays(),
            size: view.size,
            marches: marches(view),
        })
    }

    /// A unit is a strip of columns.
    fn units(frame: &Frame<'_>) -> usize {
        frame.size[0].div_ceil(STRIP_WIDTH) as usize
    }

    /// Casts a strip row by row, away from the point straight below the eye.
    fn cast_unit<T: Tally>(frame: &Frame<'_>, unit: usize, canvas: &Canvas<'_>, tally: &mut T) {
        let first = unit as u32 * STRIP_WIDTH;
        let columns = first..frame.size[0].min(first + STRIP_WIDTH);
        for rows in frame.marches.clone() {
            let upwards = rows.start < rows.end;
            let steps = rows.start.abs_diff(rows.end);
            // How far along the ground each ray of the row before came: to its hit, or to where it
            // left the terrain. Beyond the strip's sides stands infinity, which leaves the choice
            // to the others.
            let mut reach = [0.0; STRIP_WIDTH as usize + 2];
            let width = columns.len();
            reach[0] = f64::INFINITY;
            reach[width + 1] = f64::INFINITY;
            for step in 0..steps {
                let j = if upwards {
                    rows.start + step
                } else {
                    rows.start - 1 - step
                };
                let reach = &mut reach[..width + 2];
                cast_row(frame, canvas, columns.clone(), j, reach, tally);
            }
        }
    }
}

/// Casts one row of a strip, each ray from the nearest reach of the three pixels before it.
fn cast_row<T: Tally>(
    frame: &Frame<'_>,
    canvas: &Canvas<'_>,
    columns: Range<u32>,
    j: u32,
    reach: &mut [f64],
    tally: &mut T,
) {
    let mut left = reach[0];
    for (i, at) in columns.zip(1..) {
        tally.ray();
        let nearest = left.min(reach[at]).min(reach[at + 1]);
        left = reach[at];
        let ray = frame.rays.ray(i, j);
        let along_ground = ray.direction.truncate().length();
        let mut hit = None;
        if let Some(grid_ray) = frame.grid.clip(&ray) {
            if along_ground > 0.0 {
                hit = first_hit_from(&grid_ray, nearest / along_ground, tally);
                reach[at] = hit.unwrap_or(grid_ray.leave) * along_ground;
            } else {
                hit = grid_ray.first_hit(grid_ray.enter, tally);
                reach[at] = 0.0;
            }
        }
        shade(canvas, [i, j], frame.grid.ground(), &ray, hit);
    }
}

/// The rows in the order in which coherence runs: from the nadir's row outwards, or towards the
/// zenith's. A range that runs backwards stands for rows `end..start`, last first.
pub(crate) fn marches(view: &View) -> [Range<u32>; 2] {
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
fn first_hit_from<T: Tally>(ray: &GridRay<'_>, start: f64, tally: &mut T) -> Option<f64> {
    let mut from = start.max(ray.enter);
    if from > ray.leave {
        return None;
    }
    let hit = ray.first_hit(from, tally);
    if hit != Some(from) || from <= ray.enter {
        return hit;
    }
    // The start itself is inside: half a cell back at first, then ever further, until the air is
    // reached.
    let mut back = ray.half_cell();
    loop {
        from = (from - back).max(ray.enter);
        if from <= ray.enter || ray.clearance(from) > 0.0 {
            return ray.first_hit(from, tally);
        }
        back *= 1.5;
    }
}
