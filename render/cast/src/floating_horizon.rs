//! The floating horizon over slices parallel to the screen (papers' rows Z1 and Z2).

use crate::level_window::LevelWindow;
use crate::options::Options;
use crate::slice_depth::Depth;
use crate::slice_scene::{SliceCaster, SliceScene};
use crate::slices::{POSTS, STEP, Sampling, SliceFrame, SliceOptions};
use crate::{CastError, Caster, CasterOption, PreparedScene, Scene};
use sandtable_terrain::Ground;
use sandtable_view::View;
use std::sync::Arc;

/// Casts upright windows column by column from the bottom row up, over terrain slices parallel to
/// the screen (Szenberg, Gattass and Carvalho 1997): what lies behind a slice cannot hide what has
/// been painted, so a column looks at each slice once. The step along column k is scaled by
/// 1/cos θₖ, so that all columns share one table of slopes and the projection is exactly planar.
///
/// Depth comes from the slice's distance. [`depth_buffer_table`](crate::depth_buffer_table) gives
/// the value that each slice has in a depth buffer.
///
/// Known error: a ray is found to be under the ground at the first slice where it is, so up to one
/// step too far away, and what is thinner than a step may be missed; with `posts=nearest` a place
/// is up to half a cell off in each direction besides.
#[derive(Clone, Copy, Debug)]
pub struct FloatingHorizon {
    options: SliceOptions,
}

const NAME: &str = "floating-horizon";

pub(crate) static OPTIONS: [CasterOption; 3] = [
    POSTS,
    CasterOption {
        name: "depth",
        meaning: "on: the slice's, along the ray (the default); off: +∞ in every pixel, hits \
                  included",
    },
    STEP,
];

impl FloatingHorizon {
    pub(crate) fn from_options(options: &Options<'_>) -> Result<Self, CastError> {
        let depths = [("on", Depth::Slice), ("off", Depth::Off)];
        let options = SliceOptions::read(options, &depths)?;
        Ok(Self { options })
    }
}

impl Caster for FloatingHorizon {
    fn prepare(&self, scene: Arc<Scene>) -> Result<Arc<dyn PreparedScene>, CastError> {
        Ok(SliceScene::of(*self, scene))
    }
}

impl SliceCaster for FloatingHorizon {
    fn frame<'a>(&self, ground: &'a Ground, view: &View) -> Result<SliceFrame<'a>, CastError> {
        let window = LevelWindow::new(NAME, view)?;
        if !window.is_upright() {
            return Err(CastError::View {
                caster: NAME,
                reason: format!(
                    "the window leans by {:.1}° from the vertical: use inclined-corrected",
                    window.lean_degrees()
                ),
            });
        }
        // Columns are vertical planes here, so that the base plane's track is every height's.
        let sampling = Sampling::OnBasePlane;
        Ok(SliceFrame::new(
            ground,
            view,
            window,
            sampling,
            self.options,
        ))
    }
}
