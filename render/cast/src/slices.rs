//! Marching over terrain slices: vertical planes parallel to pixel rows, at even distances.

use crate::canvas::Canvas;
use crate::level_window::LevelWindow;
use crate::options::Options;
use crate::shade::sky;
use crate::slice_depth::{AtSlice, AtSurface, Depth, DepthRule, NoDepth, RowDepth};
use crate::slice_posts::{Bilinear, Nearest, SlicePosts};
use crate::tally::Tally;
use crate::{CastError, CasterOption};
use glam::{DVec2, DVec3};
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
    rays: Rays,
    size: [u32; 2],
    window: LevelWindow,
    sampling: Sampling,
    options: SliceOptions,
    /// Metres between slices.
    step: f64,
    /// The eye's height, and the lowest post's, in metres.
    eye_height: f64,
    base: f64,
    /// The eye's place, the last post's, and one metre, in posts.
    eye: DVec2,
    last: DVec2,
    per_metre: DVec2,
    sweeps: [Sweep; 2],
}

/// One march over the slices, away from the eye: forward, or behind it.
struct Sweep {
    /// Unit vector on the ground, in the world.
    ahead: DVec2,
    /// cos α towards `ahead`.
    cos: f64,
    /// The number of the first slice that can meet the terrain, counted from the eye's, and how
    /// many there are.
    first: f64,
    slices: usize,
    /// In the order of rising elevation.
    rows: Vec<Row>,
}

/// A pixel row: what its rays have in common.
struct Row {
    /// The row in the image, down from the top.
    j: u32,
    /// Metres upwards for each metre across slices.
    slope: f64,
    /// Window distances to the side for each metre across slices and each window distance that
    /// the column is off the normal's foot.
    spread: f64,
    /// Metres across slices at which a falling ray comes down to the highest post, and beyond
    /// which a rising one is above it.
    enter: f64,
    reach: f64,
    depth: RowDepth,
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
            let offset = self.window.column(column);
            for sweep in &self.sweeps {
                let mut march = March {
                    frame: self,
                    sweep,
                    posts,
                    canvas,
                    tally: &mut *tally,
                    column,
                    offset,
                    offset_squared: (offset * offset) as f32,
                };
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
    fn at(&self, n: usize, step: f64) -> f64 {
        (self.first + n as f64) * step
    }

    /// The slices that lie from `from` to `to` metres across them, as a half-open range.
    fn between(&self, from: f64, to: f64, step: f64) -> std::ops::Range<usize> {
        let end = ((to / step).floor() - self.first + 1.0) as usize;
        ((from / step).ceil() - self.first) as usize..end.min(self.slices)
    }
}

/// The metres from `origin` along `direction` between which a line is within the rectangle from
/// 0 to `last`; none where the first is more than the second.
fn clip(origin: DVec2, direction: DVec2, last: DVec2) -> [f64; 2] {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for axis in 0..2 {
        if direction[axis] == 0.0 {
            if !(0.0..=last[axis]).contains(&origin[axis]) {
                return [f64::INFINITY, f64::NEG_INFINITY];
            }
        } else {
            let a = -origin[axis] / direction[axis];
            let b = (last[axis] - origin[axis]) / direction[axis];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
    }
    [enter, leave]
}

/// One pixel column's march over one sweep's slices.
struct March<'a, P, T> {
    frame: &'a SliceFrame<'a>,
    sweep: &'a Sweep,
    posts: &'a P,
    canvas: &'a Canvas<'a>,
    tally: &'a mut T,
    column: u32,
    /// The column's offset from the normal's foot in window distances, and its square.
    offset: f64,
    offset_squared: f32,
}

impl<'p, P: SlicePosts<'p>, T: Tally> March<'_, P, T> {
    /// A sideways metre of the window's plane and a metre ahead, in posts.
    fn side_and_ahead(&self) -> [DVec2; 2] {
        let frame = self.frame;
        [
            frame.window.right * self.offset * frame.per_metre,
            self.sweep.ahead * frame.per_metre,
        ]
    }

    /// Looks the ground up along one line for all rays of the column.
    fn along_track<D: DepthRule>(&mut self) {
        let (frame, sweep) = (self.frame, self.sweep);
        let rows = &sweep.rows;
        let Some(mut row) = rows.first() else { return };
        let [side, ahead] = self.side_and_ahead();
        let (origin, direction) = if frame.sampling == Sampling::VerticalPlane {
            (frame.eye, ahead + side / sweep.cos)
        } else {
            let foot = (frame.eye_height - frame.base) * frame.window.sin;
            (frame.eye + side * foot, ahead + side * sweep.cos)
        };
        let [enter, leave] = clip(origin, direction, frame.last);
        let mut done = 0;
        for n in sweep.between(enter.max(row.enter), leave, frame.step) {
            let y = sweep.at(n, frame.step);
            if y > row.reach {
                break;
            }
            let place = origin + y * direction;
            let place = self.posts.place(place.x, place.y);
            self.tally.sample();
            let height = self.posts.height(place, self.tally);
            if frame.eye_height + row.slope * y > height {
                continue;
            }
            let colour = self.posts.colour(place);
            loop {
                self.paint::<D>(row, y, height, colour);
                done += 1;
                let Some(next) = rows.get(done) else { return };
                row = next;
                if frame.eye_height + row.slope * y > height {
                    break;
                }
            }
        }
        for row in &rows[done..] {
            self.paint_sky(row);
        }
    }

    /// Looks the ground up where the ray itself is.
    fn at_ray_height<D: DepthRule>(&mut self) {
        let (frame, sweep) = (self.frame, self.sweep);
        let Some(lowest) = sweep.rows.first() else {
            return;
        };
        let [side, ahead] = self.side_and_ahead();
        let eye_is_outside = frame.eye.clamp(DVec2::ZERO, frame.last) != frame.eye;
        let mut next = sweep.between(lowest.enter, 0.0, frame.step).start;
        let mut entered = None;
        let mut painted = None;
        for row in &sweep.rows {
            // The first slice at which the ray is over the terrain. The ray of the row before may
            // have come later, and has not looked at the slices until it did.
            let enter = if eye_is_outside {
                let direction = ahead + side * row.spread;
                let [enter, leave] = clip(frame.eye, direction, frame.last);
                let slices = sweep.between(enter, leave, frame.step);
                if slices.is_empty() {
                    sweep.slices
                } else {
                    slices.start
                }
            } else {
                0
            };
            let unseen = enter..entered.replace(enter).unwrap_or(enter);
            let mut hit = None;
            let ahead_of_seen = next.max(enter)..sweep.slices;
            next = ahead_of_seen.end;
            for n in unseen.chain(ahead_of_seen) {
                next = n;
                let y = sweep.at(n, frame.step);
                if y > row.reach {
                    break;
                }
                let z = frame.eye_height + row.slope * y;
                // Not below the base plane, unless the ray was there a slice ago.
                let before = z - row.slope * frame.step.min(y);
                let level = z.max(before.min(frame.base));
                let sideways = y * sweep.cos + (frame.eye_height - level) * frame.window.sin;
                let place = frame.eye + y * ahead + sideways * side;
                if level == z && !self.is_inside(place) {
                    break;
                }
                let place = self.posts.place(place.x, place.y);
                self.tally.sample();
                let height = self.posts.height(place, self.tally);
                if z <= height {
                    hit = Some((place, y, height));
                    break;
                }
            }
            let Some((place, y, height)) = hit else {
                self.paint_sky(row);
                continue;
            };
            let colour = match painted {
                Some((at, colour)) if at == place => colour,
                _ => self.posts.colour(place),
            };
            painted = Some((place, colour));
            self.paint::<D>(row, y, height, colour);
        }
    }

    /// Whether a place is on the terrain, give or take rounding.
    #[inline]
    fn is_inside(&self, place: DVec2) -> bool {
        const ROUNDING: f64 = 1e-6;
        let last = self.frame.last;
        place.x >= -ROUNDING
            && place.y >= -ROUNDING
            && place.x <= last.x + ROUNDING
            && place.y <= last.y + ROUNDING
    }

    /// Paints the pixel whose ray ends at the slice `y` metres away, of height `height` there.
    #[inline]
    fn paint<D: DepthRule>(&mut self, row: &Row, y: f64, height: f64, colour: [u8; 3]) {
        self.tally.ray();
        let frame = self.frame;
        let rise = height - frame.eye_height;
        let depth = D::depth(&row.depth, self.offset_squared, y, frame.step, rise);
        self.canvas.set([self.column, row.j], colour, depth);
    }

    #[inline]
    fn paint_sky(&mut self, row: &Row) {
        self.tally.ray();
        let pixel = [self.column, row.j];
        let direction: DVec3 = self.frame.rays.ray(self.column, row.j).direction;
        self.canvas.set(pixel, sky(direction), f32::INFINITY);
    }
}
