//! One view of the prepared ground.

use super::alone::Alone;
use super::detail::DetailFrame;
use super::field::Tiles;
use super::roofs::{Roof, Roofs};
use super::sectors::{ImageRays, Sector};
use super::steepness::{Steepness, SteepnessSeen};
use crate::lanes::Isa;
use glam::DVec3;
use sandtable_terrain::{Ground, TiledRaster};
use sandtable_view::View;

/// Posts that stay in a core's own caches with their colours.
const SMALL: i32 = 1 << 18;

/// The ground at one resolution.
pub(super) struct Level<'a> {
    pub(super) heights: Tiles<'a, f32>,
    pub(super) roofs: Tiles<'a, Roof>,
    /// A colour a post, where detail is chosen.
    pub(super) colours: Option<Tiles<'a, [u8; 4]>>,
    /// Cells along x and y.
    pub(super) cells: [i32; 2],
    /// How steep it is at most along x and y: metres for each of its cells.
    pub(super) steepest: [f32; 2],
    /// How much more one side of a cell rises than the other, at most: metres.
    pub(super) twist: f32,
    pub(super) steepness: &'a Steepness,
}

impl<'a> Level<'a> {
    pub(super) fn new(
        heights: &'a TiledRaster<f32>,
        roofs: &'a Roofs,
        steepness: &'a Steepness,
    ) -> Self {
        Self {
            steepest: steepness.steepest(),
            twist: steepness.twist(),
            steepness,
            heights: Tiles::new(
                heights.view(),
                heights.tiles_across(),
                heights.tile_stride(),
            ),
            roofs: Tiles::new(roofs.view(), heights.tiles_across(), 0),
            colours: None,
            cells: [heights.cols() as i32 - 1, heights.rows() as i32 - 1],
        }
    }

    /// The same with a colour a post.
    pub(super) fn with_colours(mut self, colours: &'a TiledRaster<[u8; 4]>) -> Self {
        self.colours = Some(Tiles::new(
            colours.view(),
            colours.tiles_across(),
            colours.tile_stride(),
        ));
        self
    }

    /// Whether it is too large, with its colours, for a core's own caches.
    pub(super) fn is_large(&self) -> bool {
        let [across, along] = self.cells;
        across.saturating_mul(along) > SMALL
    }
}

/// What all sectors of one view share.
pub(super) struct Frame<'a> {
    pub(super) isa: Isa,
    /// The resolution of `ground` and, where it is coarsened, those that are halved again and again.
    pub(super) levels: Vec<Level<'a>>,
    pub(super) detail: Option<DetailFrame<'a>>,
    /// Whether detail is chosen and pixels are so wide that ground is taken at other resolutions than its
    /// own somewhere. Else rays go exactly the ways that they go without detail.
    pub(super) coarsens: bool,
    /// The ground over whose cells rays go: where it is coarsened and has a finer photo, it is refined.
    pub(super) ground: &'a Ground,
    pub(super) view: &'a View,
    pub(super) rays: ImageRays,
    pub(super) sectors: Vec<Sector>,
    /// The eye in cells of `ground` along x and y from the south-west post, and in metres of height.
    pub(super) eye: DVec3,
    pub(super) highest: f32,
    /// How steep the ground is around each pixel, where that is known.
    pub(super) steepness: Option<SteepnessSeen>,
    /// Metres by which heights, rounded a few times, may be wrong.
    pub(super) rounding: f32,
    /// Where the kernels are not made for the eye's place: each pixel is cast alone.
    pub(super) alone: Option<Alone<'a>>,
    /// How fast the ground is taken to rise towards rays: metres a cell.
    pub(super) ground_rise: f32,
}
