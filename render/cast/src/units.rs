//! Casting unit by unit: what all casters share.

use crate::canvas::Canvas;
use crate::tally::{Tally, Uncounted, Work};
use crate::{CastError, Image, PreparedScene, Scene, Scheme};
use rayon::prelude::*;
use sandtable_terrain::TileIndex;
use sandtable_view::View;
use std::sync::Arc;

/// A prepared scene that casts each image in units: sets of pixels that do not overlap, cover the
/// image, and do not depend on one another.
///
/// From this come images on any number of threads under any [`Scheme`], and counts of the work.
pub(crate) trait UnitCaster: Send + Sync + 'static {
    /// What all units of one view share.
    type Frame<'a>: Sync
    where
        Self: 'a;

    /// As [`PreparedScene::scene`].
    fn scene(&self) -> &Arc<Scene>;

    /// As [`PreparedScene::updated`].
    fn updated(
        &self,
        scene: Arc<Scene>,
        changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError>;

    /// Sets up a view that has pixels.
    fn frame<'a>(&'a self, view: &'a View) -> Result<Self::Frame<'a>, CastError>;

    /// The number of units in a frame.
    fn units(frame: &Self::Frame<'_>) -> usize;

    /// Casts one unit, setting each of its pixels.
    fn cast_unit<T: Tally>(
        frame: &Self::Frame<'_>,
        unit: usize,
        canvas: &Canvas<'_>,
        tally: &mut T,
    );
}

impl<C: UnitCaster> PreparedScene for C {
    fn scene(&self) -> &Arc<Scene> {
        UnitCaster::scene(self)
    }

    fn updated(
        &self,
        scene: Arc<Scene>,
        changed: &[TileIndex],
    ) -> Result<Arc<dyn PreparedScene>, CastError> {
        UnitCaster::updated(self, scene, changed)
    }

    fn cast(&self, views: &[View], images: &mut [Image], scheme: Scheme) -> Result<(), CastError> {
        assert_eq!(views.len(), images.len(), "one image a view");
        let frames = frames(self, views)?;
        for (image, view) in images.iter_mut().zip(views) {
            image.try_reset(*view)?;
        }
        let canvases: Vec<_> = images.iter_mut().map(Canvas::new).collect();
        // The job's units are those of its views, one view after the other.
        let mut ends = Vec::with_capacity(frames.len());
        let mut units = 0;
        for frame in &frames {
            units += frame.as_ref().map_or(0, C::units);
            ends.push(units);
        }
        scheme.run(units, |unit| {
            let at = ends.partition_point(|&end| end <= unit);
            let begin = if at == 0 { 0 } else { ends[at - 1] };
            if let Some(frame) = &frames[at] {
                C::cast_unit(frame, unit - begin, &canvases[at], &mut Uncounted);
            }
        });
        Ok(())
    }

    fn work(&self, view: &View) -> Result<Work, CastError> {
        let mut image = Image::default();
        image.try_reset(*view)?;
        let canvas = Canvas::new(&mut image);
        let Some(frame) = &frames(self, std::slice::from_ref(view))?[0] else {
            return Ok(Work::default());
        };
        let count = |unit| {
            let mut work = Work::default();
            C::cast_unit(frame, unit, &canvas, &mut work);
            work
        };
        Ok((0..C::units(frame)).into_par_iter().map(count).sum())
    }
}

/// Each view's frame, or `None` for one without pixels.
fn frames<'a, C: UnitCaster>(
    caster: &'a C,
    views: &'a [View],
) -> Result<Vec<Option<C::Frame<'a>>>, CastError> {
    let frame = |view: &'a View| {
        let [width, height] = view.size;
        (width > 0 && height > 0)
            .then(|| caster.frame(view))
            .transpose()
    };
    views.iter().map(frame).collect()
}
