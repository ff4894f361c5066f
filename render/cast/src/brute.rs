//! Brute force: the judge of all other casters.

use crate::canvas::Canvas;
use crate::intersect::{GridFrame, GridRay};
use crate::shade::shade;
use crate::tally::Tally;
use crate::units::UnitCaster;
use crate::{CastError, Caster, PreparedScene, Scene};
use sandtable_terrain::TileIndex;
use sandtable_view::View;
use std::sync::Arc;

/// Casts every pixel alone: each ray is walked cell by cell from where it enters the terrain's
/// bounds to its first meeting with the solid terrain, in f64. Known error: none.
#[derive(Clone, Copy, Debug)]
pub struct Brute;

impl Caster for Brute {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        Ok(Arc::new(BruteScene { scene }))
    }
}

/// Brute force needs nothing but the ground.
struct BruteScene {
    scene: Arc<Scene>,
}

/// One view, and the ground as its rays meet it.
struct Frame<'a> {
    grid: GridFrame<'a>,
    view: &'a View,
}

impl UnitCaster for BruteScene {
    type Frame<'a> = Frame<'a>;

    fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    fn updated(
        &self,
        scene: Arc<Scene>,
        _changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError> {
        Brute.prepare(scene)
    }

    fn frame<'a>(&'a self, view: &'a View) -> Result<Frame<'a>, CastError> {
        Ok(Frame {
            grid: GridFrame::new(&self.scene.ground),
            view,
        })
    }

    /// A unit is one row of pixels.
    fn units(frame: &Frame<'_>) -> usize {
        frame.view.size[1] as usize
    }

    fn cast_unit<T: Tally>(frame: &Frame<'_>, row: usize, canvas: &Canvas<'_>, tally: &mut T) {
        let first_hit = |ray: &GridRay<'_>, tally: &mut T| ray.first_hit(ray.enter, tally);
        cast_row(
            &frame.grid,
            frame.view,
            row as u32,
            canvas,
            tally,
            first_hit,
        );
    }
}

/// Casts each pixel of a row alone; `first_hit` finds where a ray that comes over the terrain meets it.
pub(crate) fn cast_row<T: Tally>(
    grid: &GridFrame<'_>,
    view: &View,
    row: u32,
    canvas: &Canvas<'_>,
    tally: &mut T,
    first_hit: impl Fn(&GridRay<'_>, &mut T) -> Option<f64>,
) {
    let rays = view.rays();
    for i in 0..view.size[0] {
        tally.ray();
        let ray = rays.ray(i, row);
        let hit = grid
            .clip(&ray)
            .and_then(|clipped| first_hit(&clipped, tally));
        shade(canvas, [i, row], grid.ground(), &ray, hit);
    }
}
