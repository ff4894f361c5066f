//! A ray's track over the grid: from grid line to grid line of its major axis, in fixed point.

use crate::intersect::GridRay;
use crate::tally::Tally;
use bytemuck::Zeroable;
use sandtable_terrain::{Pyramid, TiledRaster};

/// Heights and colours of a pyramid, at the level that suits the distance.
pub(crate) struct Sampler<'a> {
    pyramid: &'a Pyramid,
    /// For each level, the share of the way to the window from which on it is used.
    borders: Vec<f64>,
    blends: bool,
}

/// A point on a grid line: where the line is on the major axis, and how far along it in fixed
/// point, both in posts of the finest level.
#[derive(Clone, Copy)]
struct OnLine {
    /// Whether x is the major axis.
    x_major: bool,
    major: i64,
    minor: i64,
}

/// Bits behind the point.
const FRACTION: u32 = 32;
const ONE: f64 = (1u64 << FRACTION) as f64;

impl<'a> Sampler<'a> {
    /// Levels that begin at `finest_border` times 1, 2, 4, … of the way to the window: there their
    /// posts are as far apart as pixels. Before the first border there is nothing to blend.
    pub(crate) fn new(pyramid: &'a Pyramid, finest_border: f64, blends: bool) -> Self {
        let border = |level: usize| finest_border * 2f64.powi(level as i32);
        Self {
            pyramid,
            borders: (0..pyramid.levels()).map(border).collect(),
            blends,
        }
    }

    fn coarsest(&self) -> u32 {
        self.borders.len() as u32 - 1
    }

    /// The coarsest level for a share `t` of the way.
    fn level_at(&self, t: f64) -> u32 {
        let used = self.borders[1..].partition_point(|&border| border <= t);
        used as u32
    }

    /// How much of the next coarser level is in what is seen at `t` at `level`.
    #[inline]
    fn share_of_next(&self, level: u32, t: f64) -> f32 {
        if !self.blends || level == self.coarsest() {
            return 0.0;
        }
        let border = self.borders[level as usize];
        ((t - border) / border).clamp(0.0, 1.0) as f32
    }

    #[inline]
    fn height<T: Tally>(&self, at: OnLine, level: u32, t: f64, tally: &mut T) -> f32 {
        tally.sample();
        let height = |level: u32| {
            let raster = &self.pyramid.level(level as usize).heights;
            on_line(raster, at, level, |a, b, w| a + (b - a) * w)
        };
        let share = self.share_of_next(level, t);
        let own = height(level);
        if share > 0.0 {
            own + (height(level + 1) - own) * share
        } else {
            own
        }
    }

    #[inline]
    fn colour(&self, at: OnLine, level: u32, t: f64) -> [u8; 3] {
        let colour = |level: u32| {
            let raster = &self.pyramid.level(level as usize).colours;
            let mix = |a: [f32; 3], b: [f32; 3], w: f32| {
                std::array::from_fn(|k| a[k] + (b[k] - a[k]) * w)
            };
            on_line_of(
                raster,
                at,
                level,
                |[r, g, b, _]| [r, g, b].map(f32::from),
                mix,
            )
        };
        let share = self.share_of_next(level, t);
        let own: [f32; 3] = colour(level);
        let next = if share > 0.0 { colour(level + 1) } else { own };
        std::array::from_fn(|k| (own[k] + (next[k] - own[k]) * share + 0.5) as u8)
    }
}

/// A raster's value at a point on a grid line.
#[inline]
fn on_line<V: Copy + Send + Sync + Zeroable>(
    raster: &TiledRaster<V>,
    at: OnLine,
    level: u32,
    mix: impl Fn(V, V, f32) -> V,
) -> V {
    on_line_of(raster, at, level, |value| value, mix)
}

/// As [`on_line`], of what `read` makes of each post. A line of the finest level that lies between
/// two of `level` gets the mean of both.
#[inline]
fn on_line_of<V: Copy + Send + Sync + Zeroable, R: Copy>(
    raster: &TiledRaster<V>,
    at: OnLine,
    level: u32,
    read: impl Fn(V) -> R,
    mix: impl Fn(R, R, f32) -> R,
) -> R {
    let (majors, minors) = if at.x_major {
        (raster.cols(), raster.rows())
    } else {
        (raster.rows(), raster.cols())
    };
    let limit = i64::from(minors - 1) << (FRACTION + level);
    let minor = at.minor.clamp(0, limit);
    let index = ((minor >> (FRACTION + level)) as u32).min(minors - 2);
    let along = (minor - (i64::from(index) << (FRACTION + level))) as f32;
    let weight = along / (1u64 << (FRACTION + level)) as f32;
    let line = |major: u32| {
        let post = |minor: u32| {
            if at.x_major {
                read(raster.post(major, minor))
            } else {
                read(raster.post(minor, major))
            }
        };
        mix(post(index), post(index + 1), weight)
    };
    let major = ((at.major >> level) as u32).min(majors - 1);
    let own = line(major);
    let between = at.major & ((1 << level) - 1);
    if between == 0 || major + 1 == majors {
        own
    } else {
        let share = between as f32 / (1i64 << level) as f32;
        mix(own, line(major + 1), share)
    }
}

/// Where a ray has come to.
#[derive(Clone, Copy)]
pub(crate) struct Foothold {
    /// Whether x is the major axis, the direction along it, and the grid line.
    line: [i64; 3],
    level: u32,
    /// How far that is on the map, in posts.
    ground: f64,
}

/// A ray on its way over the grid.
pub(crate) struct GridTrack<'a> {
    ray: &'a GridRay<'a>,
    x_major: bool,
    /// 1 or −1 along the major axis.
    sign: i64,
    /// Share of the way to the window from one grid line of the finest level to the next.
    per_line: f64,
    /// Along the minor axis from line to line, in fixed point.
    slope: i64,
    /// The present grid line and place on it.
    at: OnLine,
    level: u32,
    /// Share of the way to the window at which the track is.
    way: f64,
    /// Metres by which a parallel ray is higher.
    lift: f64,
}

impl<'a> GridTrack<'a> {
    /// The track of a ray that has been clipped to the terrain. It has no place yet.
    pub(crate) fn new(ray: &'a GridRay<'a>) -> Self {
        let (dx, dy) = (ray.direction.x, ray.direction.y);
        let x_major = dx.abs() > dy.abs();
        let (major, minor) = if x_major { (dx, dy) } else { (dy, dx) };
        let slope = if major == 0.0 {
            0.0
        } else {
            minor / major.abs()
        };
        Self {
            ray,
            x_major,
            sign: if major < 0.0 { -1 } else { 1 },
            // A ray straight down crosses no line: it takes one step to wherever it goes.
            per_line: 1.0 / major.abs().max(f64::MIN_POSITIVE),
            slope: (slope * ONE) as i64,
            at: OnLine {
                x_major,
                major: 0,
                minor: 0,
            },
            level: 0,
            way: 0.0,
            lift: 0.0,
        }
    }

    /// How far it has come, as a share of the way to the window.
    pub(crate) fn way(&self) -> f64 {
        self.way
    }

    /// Makes it a parallel ray that is `rise` metres higher for each way to the window, seen from
    /// where it is now.
    pub(crate) fn lift(&mut self, rise: f64) {
        self.lift = rise * self.way;
    }

    /// Goes back as long as it is in the terrain, to the first line of it that a line in the air
    /// precedes: where rays of one column are not above each other, the foothold lies too far.
    pub(crate) fn retrace<T: Tally>(&mut self, sampler: &Sampler<'_>, tally: &mut T) {
        let mut here = (self.at, self.way);
        while self.is_inside(sampler, tally) {
            here = (self.at, self.way);
            let step = 1i64 << self.level;
            let line = self.at.major - self.sign * step;
            let last = self.ray.last_post()[usize::from(!self.x_major)] as i64;
            let way = self.way - self.per_line * step as f64;
            if way < self.ray.enter || !(0..=last).contains(&line) {
                break;
            }
            self.at.major = line;
            self.at.minor = self.at.minor.saturating_sub(self.slope * step);
            self.way = way;
        }
        (self.at, self.way) = here;
    }

    /// Whether the ray is in the terrain where it is.
    #[inline]
    fn is_inside<T: Tally>(&self, sampler: &Sampler<'_>, tally: &mut T) -> bool {
        let height = sampler.height(self.at, self.level, self.way, tally);
        let z = self.ray.origin.z + self.way * self.ray.direction.z + self.lift;
        z <= f64::from(height) && self.way + self.per_line >= self.ray.enter
    }

    /// Where it is, for the ray above to climb from.
    pub(crate) fn foothold(&self) -> Foothold {
        Foothold {
            line: [i64::from(self.x_major), self.sign, self.at.major],
            level: self.level,
            ground: self.way * self.ground_length(),
        }
    }

    /// The length of the way to the window on the map, in posts.
    fn ground_length(&self) -> f64 {
        self.ray.direction.truncate().length()
    }

    /// Puts it over the ground that the ray before has reached: on the same grid line, or, where
    /// the major axis is another, as far on the map.
    pub(crate) fn climb_from(&mut self, foothold: Foothold, sampler: &Sampler<'_>) {
        let [x_major, sign, line] = foothold.line;
        if [x_major, sign] == [i64::from(self.x_major), self.sign] {
            self.level = foothold.level;
            self.put_on(line);
        } else {
            let ground = self.ground_length().max(f64::MIN_POSITIVE);
            self.start_at(foothold.ground / ground, sampler);
        }
    }

    /// Puts it on the grid line at or before a share `t` of the way, at the level for there.
    fn start_at(&mut self, t: f64, sampler: &Sampler<'_>) {
        let t = t.clamp(self.ray.enter, self.ray.leave);
        self.level = sampler.level_at(t);
        let axis = usize::from(!self.x_major);
        // A line reached but for rounding is reached.
        let major = self.ray.place(t)[axis] + 1e-6 * self.sign as f64;
        let last = self.ray.last_post()[axis] as i64;
        let mut line = if self.sign > 0 {
            (major.floor() as i64) >> self.level << self.level
        } else {
            -(-(major.ceil() as i64) >> self.level << self.level)
        };
        if line > last {
            // The last line of a coarse level may lie beyond the border.
            (line, self.level) = (last, 0);
        }
        self.put_on(line.max(0));
    }

    /// Puts it on a grid line.
    fn put_on(&mut self, line: i64) {
        let axis = usize::from(!self.x_major);
        let from_eye = (line as f64 - self.ray.origin[axis]) * self.sign as f64;
        self.at.major = line;
        self.way = (from_eye * self.per_line).clamp(0.0, f64::MAX);
        let minor = self.ray.place(self.way)[1 - axis];
        self.at.minor = (minor * ONE) as i64;
    }

    /// Puts it on the last grid line before which it has surely met nothing: top-down through the
    /// pyramid's upper bounds (papers' row C3).
    pub(crate) fn start_top_down<T: Tally>(&mut self, sampler: &Sampler<'_>, tally: &mut T) {
        let t = self.first_contact(sampler, tally);
        self.start_at(t, sampler);
    }

    /// From where on the ray may meet the terrain.
    fn first_contact<T: Tally>(&self, sampler: &Sampler<'_>, tally: &mut T) -> f64 {
        let ray = self.ray;
        let coarsest = sampler.coarsest();
        let mut level = coarsest;
        let mut t = ray.enter;
        loop {
            tally.cell();
            let bounds = &sampler.pyramid.level(level as usize).bounds;
            // A little further on, so that a border belongs to the cell behind it.
            let inside = t + 1e-9 * (1.0 + t.abs());
            let place = ray.place(inside);
            let size = f64::from(1u32 << level);
            let counts = [bounds.cols(), bounds.rows()];
            let cell: [u32; 2] =
                std::array::from_fn(|k| ((place[k] / size) as u32).min(counts[k] - 1));
            let mut exit = ray.leave;
            for (axis, cell) in cell.into_iter().enumerate() {
                let direction = ray.direction[axis];
                if direction != 0.0 {
                    let line = f64::from(cell + u32::from(direction > 0.0)) * size;
                    exit = exit.min(((line - ray.origin[axis]) / direction).max(inside));
                }
            }
            let lowest = if ray.direction.z < 0.0 { exit } else { t };
            let z = ray.origin.z + lowest * ray.direction.z;
            let [_, highest] = bounds.get(cell[0], cell[1]);
            if z > f64::from(highest) {
                if exit >= ray.leave {
                    return ray.leave;
                }
                t = exit;
                level = (level + 1).min(coarsest);
            } else if level <= sampler.level_at(t) {
                return t;
            } else {
                level -= 1;
            }
        }
    }

    /// Goes on until the ray is in the terrain, and gives the colour there; `None` where it leaves.
    pub(crate) fn first_hit<T: Tally>(
        &mut self,
        sampler: &Sampler<'_>,
        tally: &mut T,
    ) -> Option<[u8; 3]> {
        let Self { ray, .. } = *self;
        let major_axis = usize::from(!self.x_major);
        let last = ray.last_post()[major_axis] as i64;
        loop {
            if self.is_inside(sampler, tally) {
                return Some(sampler.colour(self.at, self.level, self.way));
            }
            // The step doubles at an even line, and what is left of the grid behind the last
            // coarse line is walked finely.
            while self.level < sampler.coarsest()
                && self.way >= sampler.borders[self.level as usize + 1]
                && self.at.major & ((2 << self.level) - 1) == 0
            {
                self.level += 1;
            }
            let mut step = 1i64 << self.level;
            let is_beyond = |step: i64| {
                let next = self.at.major + self.sign * step;
                !(0..=last).contains(&next)
                    || self.way + self.per_line * step as f64 > ray.leave + self.per_line
            };
            if is_beyond(step) {
                (step, self.level) = (1, 0);
                if is_beyond(step) {
                    self.way = ray.leave;
                    return None;
                }
            }
            self.at.major += self.sign * step;
            self.at.minor = self.at.minor.saturating_add(self.slope * step);
            self.way += self.per_line * step as f64;
        }
    }
}
