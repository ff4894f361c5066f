//! Inclined windows over terrain slices (papers' rows G1 and G2).

use crate::level_window::LevelWindow;
use crate::options::Options;
use crate::slice_depth::Depth;
use crate::slice_scene::{SliceCaster, SliceScene};
use crate::slices::{POSTS, STEP, Sampling, SliceFrame, SliceOptions};
use crate::{CastError, Caster, CasterOption, PreparedScene, Scene};
use sandtable_terrain::Ground;
use sandtable_view::View;
use std::sync::Arc;

/// Casts windows inclined about their level rows, down to a horizontal table top, column by column
/// over terrain slices parallel to the rows (Guedes, Gattass and Carvalho 1997). Where a window
/// shows ground behind the eye, its rows there march backwards.
///
/// A column lies in a plane that is not vertical, so where on a slice a ray looks depends on
/// height. Three degrees of care are casters of their own.
///
/// Known error, of all: a ray is found to be under the ground at the first slice where it is, so up
/// to one step too far along the ground, and never looks back: a hill that only a higher ray of its
/// column meets before that slice is missed. Rays that run almost along the slices, beside the
/// point straight below the eye, step coarsely.
/// - `inclined-naive` takes each column for a vertical plane through the eye: the picture is bent,
///   the more so the farther from the middle column and the more inclined.
/// - `inclined` looks where the column's plane cuts the base plane (the lowest height of the
///   ground): exact there; higher ground is shifted sideways as far as the plane leans over. All
///   vertical lines are seen as lines along pixel columns.
/// - `inclined-corrected` looks at the ray's height, anew for every painted pixel: no error besides
///   those above. A steep ray falls far from slice to slice, so it is looked up no lower than the
///   ground was found last (in the paper: than the base plane), which keeps its place near where
///   it met the ground.
#[derive(Clone, Copy, Debug)]
pub struct Inclined {
    name: &'static str,
    sampling: Sampling,
    options: SliceOptions,
}

pub(crate) static OPTIONS: [CasterOption; 3] = [
    POSTS,
    CasterOption {
        name: "depth",
        meaning: "on: where the ray meets the height found (the default); slice: at the slice \
                  itself, as floating-horizon has it; off: +∞ in every pixel, hits included",
    },
    STEP,
];

/// The lean in degrees beyond which columns are too far from vertical to be taken for it.
const NAIVE_LIMIT: f64 = 80.0;

impl Inclined {
    /// `inclined-naive`.
    pub(crate) fn naive(options: &Options<'_>) -> Result<Self, CastError> {
        Self::with("inclined-naive", Sampling::VerticalPlane, options)
    }

    /// `inclined`.
    pub(crate) fn on_base_plane(options: &Options<'_>) -> Result<Self, CastError> {
        Self::with("inclined", Sampling::OnBasePlane, options)
    }

    /// `inclined-corrected`.
    pub(crate) fn corrected(options: &Options<'_>) -> Result<Self, CastError> {
        Self::with("inclined-corrected", Sampling::AtRayHeight, options)
    }

    fn with(
        name: &'static str,
        sampling: Sampling,
        options: &Options<'_>,
    ) -> Result<Self, CastError> {
        let depths = [
            ("on", Depth::Surface),
            ("slice", Depth::Slice),
            ("off", Depth::Off),
        ];
        Ok(Self {
            name,
            sampling,
            options: SliceOptions::read(options, &depths)?,
        })
    }

    /// Why `inclined-naive` cannot cast through `window`, if it cannot.
    fn refusal(&self, window: &LevelWindow, rows: u32) -> Option<String> {
        let lean = window.lean_degrees();
        let looks_back = |&j: &u32| window.forward_and_up(j)[0] <= 0.0;
        if self.sampling != Sampling::VerticalPlane {
            None
        } else if lean.abs() > NAIVE_LIMIT {
            Some(format!(
                "the window leans by {lean:.1}° from the vertical, and its columns can be taken \
                 for vertical up to {NAIVE_LIMIT}° only: use inclined-corrected"
            ))
        } else {
            let back = (0..rows).filter(looks_back).count();
            (back > 0).then(|| {
                format!(
                    "{back} of its {rows} pixel rows look behind the eye, where columns cannot be \
                     taken for vertical: use inclined-corrected"
                )
            })
        }
    }
}

impl Caster for Inclined {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        Ok(SliceScene::of(*self, scene))
    }
}

impl SliceCaster for Inclined {
    fn frame<'a>(&self, ground: &'a Ground, view: &View) -> Result<SliceFrame<'a>, CastError> {
        let Self {
            name,
            sampling,
            options,
        } = *self;
        let window = LevelWindow::new(name, view)?;
        if let Some(reason) = self.refusal(&window, view.size[1]) {
            let caster = name;
            return Err(CastError::View { caster, reason });
        }
        Ok(SliceFrame::new(ground, view, window, sampling, options))
    }
}
