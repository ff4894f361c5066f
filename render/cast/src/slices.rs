//! A view cut into terrain slices: vertical planes parallel to pixel rows, at even distances.

use crate::canvas::Canvas;
use crate::level_window::LevelWindow;
use crate::options::Options;
use crate::slice_depth::{AtSlice, AtSurface, Depth, DepthRule, NoDepth, RowDepth};
use crate::slice_march::March;
use crate::slice_posts::{Bilinear, Nearest, SlicePosts};
use crate::tally::Tally;
use crate::{CastError, CasterOption};
use glam::DVec2;
use sandtable_terrain::Ground;
use sandtable_view::{Rays, View};

/// How many columns one unit casts: their pixels of one row fill a line of the cache.
const BLOCK_WIDTH: u32 = 16;

/// The share of the window's distance that every ray is taken to go forward at least, so that a
/// ray straight down has a slope.
const LEAST_FORWARD: f64 = 1e-9;

pub(crate) const POSTS: CasterOption = CasterOption {
    name: "posts",
    meaning: "nearest: flat-topped columns of one colour, as in the paper (the default); bilinear: \
              the surface between posts",
};
pub(crate) const STEP: CasterOption = CasterOption {
    name: "step",
    meaning: "distance between terrain slices in cells, from 0.1 to 8; the default is 1",
};

#[derive(Clone, Copy, Debug)]
pub(crate) enum Posts {
    Nearest,
    Bilinear,
}

/// What can be set about slices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SliceOptions {
    posts: Posts,
    depth: Depth,
    /// Distance between slices in cells.
    step: f64,
}

impl SliceOptions {
    /// Those given, where `depths` are the words for the option `depth`, the default first.
    pub(crate) fn read(options: &Options<'_>, depths: &[(&str, Depth)]) -> Result<Self, CastError> {
        let posts = [("nearest", Posts::Nearest), ("bilinear", Posts::Bilinear)];
        Ok(Self {
            posts: options.choice("posts", &posts)?,
            depth: options.choice("depth", depths)?,
            step: options.number("step", 0.1..=8.0)?.unwrap_or(1.0),
        })
    }
}

/// Where on a slice a ray looks the ground up, from the plane of its pixel column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sampling {
    /// The column is taken for a vertical plane through the eye.
    VerticalPlane,
    /// Where the column's plane cuts the base plane.
    OnBasePlane,
    /// Where the column's plane has the ray's height.
    AtRayHeight,
}

/// One view, cut into slices.
pub(crate) struct SliceFrame<'a> {
    ground: &'a Ground,
    pub(crate) rays: Rays,
    size: [u32; 2],
    pub(crate) window: LevelWindow,
    pub(crate) sampling: Sampling,
    options: SliceOptions,
    /// Metres between slices.
    pub(crate) step: f64,
    /// The eye's height, and the lowest post's, in metres.
    pub(crate) eye_height: f64,
    pub(crate) base: f64,
    /// The eye's place, the last post's, and one metre, in posts.
    pub(crate) eye: DVec2,
    pub(crate) last: DVec2,
    pub(crate) per_metre: DVec2,
    sweeps: [Sweep; 2],
}

/// One march over the slices, away from the eye: forward, or behind it.
pub(crate) struct Sweep {
    /// Unit vector on the ground, in the world.
    pub(crate) ahead: DVec2,
    /// cos α towards `ahead`.
    pub(crate) cos: f64,
    /// The number of the first slice that can meet the terrain, counted from the eye's, and how
    /// many there are.
    first: f64,
    pub(crate) slices: usize,
    /// In the order of rising elevation.
    pub(crate) rows: Vec<Row>,
}

/// A pixel row: what its rays have in common.
pub(crate) struct Row {
    /// The row in the image, down from the top.
    pub(crate) j: u32,
    /// Metres upwards for each metre across slices.
    pub(crate) slope: f64,
    /// Window distances to the side for each metre across slices and each window distance that
    /// the column is off the normal's foot.
    pub(crate) spread: f64,
    /// Metres across slices at which a falling ray comes down to the highest post, and beyond
    /// which a rising one is above it.
    pub(crate) enter: f64,
    pub(crate) reach: f64,
    pub(crate) depth: RowDepth,
}

impl<'a> SliceFrame<'a> {
    pub(crate) fn new(
        ground: &'a Ground,
        view: &View,
        window: LevelWindow,
        sampling: Sampling,
        options: SliceOptions,
    ) -> Self {
        let grid = ground.grid();
        let [base, highest] = ground.range().map(f64::from);
        let per_metre = 1.0 / grid.spacing;
        let step = options.step * grid.cell_length();
        let eye = view.eye.truncate();
        let sweep = |sign: f64| {
            let rows = rows(&window, sign, view.size[1], view.eye.z, highest);
            let ahead = sign * window.forward;
            let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
            let [near, far] = corners
                .map(|corner| (DVec2::from(corner) * grid.extent() - eye).dot(ahead) / step)
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[near, far], &at| {
                    [near.min(at), far.max(at)]
                });
            let first = near.ceil().max(0.0);
            Sweep {
                ahead,
                cos: sign * window.cos,
                first,
                slices: (far.floor() - first + 1.0) as usize,
                rows,
            }
        };
        Self {
            ground,
            rays: view.rays(),
            size: view.size,
            sweeps: [sweep(1.0), sweep(-1.0)],
            window,
            sampling,
            options,
            step,
            eye_height: view.eye.z,
            base,
            eye: eye * per_metre,
            last: DVec2::new(f64::from(grid.cols - 1), f64::from(grid.rows - 1)),
            per_metre,
        }
    }

    /// The number of units: blocks of columns.
    pub(crate) fn units(&self) -> usize {
        self.size[0].div_ceil(BLOCK_WIDTH) as usize
    }

    /// Casts one block of columns, setting each of its pixels.
    pub(crate) fn cast_unit<T: Tally>(&self, unit: usize, canvas: &Canvas<'_>, tally: &mut T) {
        match self.options.posts {
            Posts::Nearest => self.cast_with(&Nearest::new(self.ground), unit, canvas, tally),
            Posts::Bilinear => self.cast_with(&Bilinear::new(self.ground), unit, canvas, tally),
        }
    }

    fn cast_with<'p, P: SlicePosts<'p>, T: Tally>(
        &self,
        posts: &P,
        unit: usize,
        canvas: &Canvas<'_>,
        tally: &mut T,
    ) {
        match self.options.depth {
            Depth::Slice => self.cast_block::<AtSlice, P, T>(posts, unit, canvas, tally),
            Depth::Surface => self.cast_block::<AtSurface, P, T>(posts, unit, canvas, tally),
            Depth::Off => self.cast_block::<NoDepth, P, T>(posts, unit, canvas, tally),
        }
    }

    fn cast_block<'p, D: DepthRule, P: SlicePosts<'p>, T: Tally>(
        &self,
        posts: &P,
        unit: usize,
        canvas: &Canvas<'_>,
        tally: &mut T,
    ) {
        let first = unit as u32 * BLOCK_WIDTH;
        for column in first..self.size[0].min(first + BLOCK_WIDTH) {
            for sweep in &self.sweeps {
                let mut march = March::new(self, sweep, posts, canvas, &mut *tally, column);
                if self.sampling == Sampling::AtRayHeight {
                    march.at_ray_height::<D>();
                } else {
                    march.along_track::<D>();
                }
            }
        }
    }
}

/// The rows that look to the side `sign` of the eye's slice, in the order of rising elevation.
fn rows(window: &LevelWindow, sign: f64, height: u32, eye: f64, highest: f64) -> Vec<Row> {
    let least = LEAST_FORWARD * window.distance;
    let mut rows: Vec<_> = (0..height)
        .filter_map(|j| {
            let [forward, up] = window.forward_and_up(j);
            // Rays straight down or up are taken to go forward.
            let is_forward = forward >= -least;
            (is_forward == (sign > 0.0)).then(|| {
                let across = forward.abs().max(least);
                let slope = up / across;
                let to_highest = (highest - eye) / slope;
                let (enter, reach) = if slope < 0.0 {
                    (to_highest.max(0.0), f64::INFINITY)
                } else if slope == 0.0 {
                    (0.0, if eye > highest { -1.0 } else { f64::INFINITY })
                } else {
                    (0.0, to_highest)
                };
                Row {
                    j,
                    slope,
                    spread: window.distance / across,
                    enter,
                    reach,
                    depth: RowDepth::new(window, j, across, slope),
                }
            })
        })
        .collect();
    rows.sort_by(|a, b| a.slope.total_cmp(&b.slope));
    rows
}

impl Sweep {
    /// Metres across slices of the `n`th slice that can meet the terrain.
    #[inline]
    pub(crate) fn at(&self, n: usize, step: f64) -> f64 {
        (self.first + n as f64) * step
    }

    /// The slices that lie from `from` to `to` metres across them, as a half-open range.
    pub(crate) fn between(&self, from: f64, to: f64, step: f64) -> std::ops::Range<usize> {
        let end = ((to / step).floor() - self.first + 1.0) as usize;
        ((from / step).ceil() - self.first) as usize..end.min(self.slices)
    }
}
