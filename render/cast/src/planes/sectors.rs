//! How an image is shared out: parts in which coherence runs in one direction over image and
//! ground.

mod part;

use self::part::{Line, Part, Side, area, clipped, cut};
use glam::DVec3;
use sandtable_view::View;

/// A float to which those below 2^31 are added to be rounded to whole numbers.
pub(super) const WHOLE: f64 = 1.5 * (1_u64 << 52) as f64;

/// Steps of which it is found at once which pixels they have.
pub(super) const AHEAD: usize = 8;

/// A part of the image: pixels of a range of rows (or of columns), and in each of these a range.
///
/// Its pixels' vertical planes meet the image more or less along one of its axes, and the ground along
/// one of its axes ([`Bounds`] say how far aside they may run), and the sector's edges lie in vertical
/// planes: so what lies before a pixel lies in its sector, but for rounding.
#[derive(Clone, Debug)]
pub(super) struct Sector {
    /// The image's axis along which planes run: 0 where steps are columns, 1 where they are rows.
    pub(super) step_axis: usize,
    /// The first step's column or row, and +1 or −1 towards the next.
    pub(super) first_step: i32,
    pub(super) direction: i32,
    pub(super) steps: u32,
    /// The ground's axis along which rays advance more: 0 for x, 1 for y.
    pub(super) major: usize,
    /// The signs of rays' advance along the major and the minor axis.
    pub(super) signs: [i32; 2],
    sides: Vec<Side>,
    /// The image's extent across the steps.
    width: i32,
    /// About how long it takes: as that many pixels of ground near by.
    time: f64,
}

impl Sector {
    /// The image's column or row of step `k`.
    pub(super) fn image_step(&self, k: u32) -> u32 {
        (self.first_step + self.direction * k as i32) as u32
    }

    /// The image's column and row of a lane of step `k`.
    pub(super) fn pixel(&self, k: u32, lane: i32) -> [u32; 2] {
        let mut pixel = [self.image_step(k); 2];
        pixel[1 - self.step_axis] = lane as u32;
        pixel
    }

    fn has_pixels(&self) -> bool {
        // From the middle on, as sectors run out into points.
        let middle = self.steps / 2 / AHEAD as u32 * AHEAD as u32;
        let behind = (middle..self.steps).step_by(AHEAD);
        behind.chain((0..middle).step_by(AHEAD)).any(|k| {
            let ahead = self.lanes_from::<AHEAD>(k);
            let mut lanes = ahead.iter().take((self.steps - k) as usize);
            lanes.any(|[from, to]| from < to)
        })
    }

    /// The pixels of step `k`, from the first to behind the last, along the image's other axis.
    pub(super) fn lanes(&self, k: u32) -> [i32; 2] {
        let [lanes] = self.lanes_from(k);
        lanes
    }

    /// The pixels of `N` steps from the `k`-th on, whether there are so many or not: side by side,
    /// in floats and without branches.
    #[inline(always)]
    pub(super) fn lanes_from<const N: usize>(&self, k: u32) -> [[i32; 2]; N] {
        let width = f64::from(self.width);
        let mut steps = [0.0; N];
        for (n, step) in steps.iter_mut().enumerate() {
            *step = f64::from(self.first_step + self.direction * (k as i32 + n as i32));
        }
        let (mut from, mut to) = ([0.0; N], [width; N]);
        for side in &self.sides {
            let lane_axis = 1 - self.step_axis;
            let (at_origin, along) = (side.line.at_origin, side.line.along);
            let slope = along[lane_axis];
            let begins = (slope > 0.0) == side.positive;
            // On a side of a line along steps lies all of a step or nothing.
            let inverse = if slope == 0.0 { 0.0 } else { -1.0 / slope };
            for n in 0..N {
                let by_step = along[self.step_axis] * steps[n];
                // `Line::at`, to the last bit.
                let holds = |lane: f64| {
                    let by_lane = slope * lane;
                    let (first, then) = if lane_axis == 0 {
                        (by_lane, by_step)
                    } else {
                        (by_step, by_lane)
                    };
                    ((at_origin + first) + then >= 0.0) == side.positive
                };
                // About where the side changes; a pixel belongs to that side where its own value
                // is, whichever way it is asked for. That is next to there, as values are rounded
                // by far less than a pixel's change.
                let about = (at_origin + by_step) * inverse;
                let about = (about.max(0.0).min(width) - 0.5 + WHOLE) - WHOLE;
                let mut at = about - 1.0;
                for aside in [-1.0, 0.0, 1.0, 2.0] {
                    let is_before = holds(about + aside) != begins;
                    at += f64::from(u8::from(is_before));
                }
                let all = if holds(0.0) == begins { 0.0 } else { width };
                let at = if slope == 0.0 { all } else { at };
                let at = at.max(0.0).min(width);
                debug_assert!(at == 0.0 || holds(at - 1.0) != begins);
                debug_assert!(at == width || holds(at) == begins);
                if begins {
                    from[n] = at.max(from[n]);
                } else {
                    to[n] = at.min(to[n]);
                }
            }
        }
        std::array::from_fn(|n| [from[n] as i32, to[n].max(from[n]) as i32])
    }
}

/// For how much of a pixel of ground one of sky counts where parts are cut.
const SKY: f64 = 0.2;

/// How long a pixel of sky takes, where one of ground near by takes 1; and one of ground in a part that reaches the
/// horizon.
const SKY_TIME: f64 = 0.4;
const FAR_TIME: f64 = 2.0;

/// What sectors there may be.
pub(super) struct Bounds {
    /// About how many pixels a step has at most.
    pub(super) width: u32,
    /// About how many pixels of ground a sector has at most, or half as many again; each pixel of sky counts
    /// for [`SKY`] of one.
    pub(super) work: f64,
    /// About how far rays advance along the minor axis at most for each one of the major axis, in cells;
    /// and how many lanes aside a ray's predecessor lies in the step before. With 1, parts are cut along all
    /// diagonals.
    pub(super) most_slant: f64,
    /// Where the eye lies over the ground along both axes, in cells, and how many cells there are.
    pub(super) eye: [f64; 2],
    pub(super) cells: [i32; 2],
    /// How high the ground's highest place lies above the eye, in metres.
    pub(super) rise: f64,
}

impl Bounds {
    /// Whether rays that run one way along an axis begin before the ground does.
    fn is_beside(&self, axis: usize, sign: f64) -> bool {
        if sign > 0.0 {
            self.eye[axis] < 0.0
        } else {
            self.eye[axis] > f64::from(self.cells[axis])
        }
    }
}

/// What divides an image: its rays in units of cells, and its size.
pub(super) struct ImageRays {
    /// The direction through the centre of pixel (0, 0), and its change a column and a row.
    pub(super) first: DVec3,
    pub(super) steps: [DVec3; 2],
    pub(super) size: [u32; 2],
}

impl ImageRays {
    /// Those of a view, with a cell's sides as units.
    pub(super) fn new(view: &View, per_metre: DVec3) -> Self {
        let [first, right, below] = [[0, 0], [1, 0], [0, 1]].map(|[i, j]| view.ray(i, j));
        let first_direction = first.direction * per_metre;
        Self {
            first: first_direction,
            steps: [right, below].map(|ray| (ray.direction - first.direction) * per_metre),
            size: view.size,
        }
    }

    /// The line on which a combination of the direction's x and y vanishes.
    fn line(&self, x: f64, y: f64) -> Line {
        self.line_of(DVec3::new(x, y, 0.0))
    }

    /// The line on which a combination of the direction's components vanishes.
    fn line_of(&self, factors: DVec3) -> Line {
        let value = |v: DVec3| factors.dot(v);
        Line {
            at_origin: value(self.first),
            along: self.steps.map(value),
        }
    }

    /// The vanishing point of the vertical, homogeneous in pixels, so that a pixel's predecessor
    /// lies towards (x − i·w, y − j·w).
    pub(super) fn vertical(&self) -> [f64; 3] {
        let (u, v, d) = (self.steps[0], self.steps[1], self.first);
        let point = [
            v.x * d.y - v.y * d.x,
            d.x * u.y - d.y * u.x,
            u.x * v.y - u.y * v.x,
        ];
        // Where it is the nadir rays come from it, where it is the zenith they go to it.
        let down = u.z * point[0] + v.z * point[1] + d.z * point[2];
        let sign = if down > 0.0 { -1.0 } else { 1.0 };
        point.map(|x| sign * x)
    }

    /// Whether planes run slantwise over the image somewhere, so that what lies before a pixel lies aside
    /// of its neighbours.
    pub(super) fn are_slanted(&self) -> bool {
        /// Pixels aside for each one along.
        const LITTLE: f64 = 0.15;
        let [px, py, pw] = self.vertical();
        let [w, h] = self.size.map(f64::from);
        [[0.0, 0.0], [w, 0.0], [0.0, h], [w, h]]
            .iter()
            .any(|[x, y]| {
                let [x, y] = [px - x * pw, py - y * pw].map(f64::abs);
                x.min(y) > LITTLE * x.max(y)
            })
    }

    /// The image's sectors. Those that take longest come first: threads that take them in turn are done at about
    /// the same time.
    pub(super) fn sectors(&self, bounds: &Bounds) -> Vec<Sector> {
        let [w, h] = self.size.map(f64::from);
        let whole = Part {
            corners: vec![[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]],
            sides: Vec::new(),
            signs: Vec::new(),
        };
        // Lines through the vanishing point: rays run one way along each of the ground's axes.
        let parts = cut(vec![whole], &[self.line(1.0, 0.0), self.line(0.0, 1.0)]);
        let parts = parts.into_iter().flat_map(|part| {
            let signs = [part.signs[0], part.signs[1]].map(|up| if up { 1 } else { -1 });
            let parts = self.by_steps(part, bounds).into_iter();
            parts.flat_map(move |(part, steps)| {
                let parts = self.by_major(part, signs, bounds).into_iter();
                parts.map(move |(part, major)| {
                    (part, steps, [signs[major], signs[1 - major]], major)
                })
            })
        });
        let point = self.vertical();
        let mut sectors = Vec::new();
        for (part, (step_axis, direction), signs, major) in parts {
            for part in self.strips(part, step_axis, point, bounds.width) {
                let above = self.above(major, signs[0], bounds);
                let sky = |corners: &[[f64; 2]]| area(&clipped(corners, |at| above.at(at)));
                let work = |corners: &[[f64; 2]]| area(corners) - (1.0 - SKY) * sky(corners);
                let pieces = part.pieces(step_axis, self.size[step_axis], bounds.work, work);
                for (piece, [low, high]) in pieces {
                    let sky = sky(&piece.corners);
                    let far = if sky > 0.0 { FAR_TIME } else { 1.0 };
                    sectors.push(Sector {
                        step_axis,
                        first_step: if direction > 0 { low } else { high },
                        direction,
                        steps: (high - low + 1) as u32,
                        major,
                        signs,
                        sides: piece.ordered_sides(),
                        time: far * (piece.size() - sky) + SKY_TIME * sky,
                        width: self.size[1 - step_axis] as i32,
                    });
                }
            }
        }
        // What is left between lines that almost meet has no pixels.
        sectors.retain(Sector::has_pixels);
        sectors.sort_by(|a, b| b.time.total_cmp(&a.time));
        sectors
    }

    /// The line above which rays that advance along the `major` axis pass over the highest place there may
    /// be halfway to the ground's end: most of them meet the sky.
    fn above(&self, major: usize, sign: i32, bounds: &Bounds) -> Line {
        let end = if sign > 0 {
            f64::from(bounds.cells[major])
        } else {
            0.0
        };
        let halfway = 0.5 * ((end - bounds.eye[major]) * f64::from(sign)).max(1.0);
        let mut factors = DVec3::Z;
        factors[major] = -f64::from(sign) * bounds.rise.max(0.0) / halfway;
        self.line_of(factors)
    }

    /// A part with the image's axis along which its steps run, and their direction: as it is, or cut.
    fn by_steps(&self, part: Part, bounds: &Bounds) -> Vec<(Part, (usize, i32))> {
        let [px, py, pw] = self.vertical();
        // Towards the predecessor along the image's axes.
        let toward = |along: [f64; 2]| Line {
            at_origin: along[0] * px + along[1] * py,
            along: along.map(|along| -along * pw),
        };
        // The area where it lies more lanes aside.
        let beyond = |step_axis: usize, aside: f64| -> f64 {
            let wedge = |sign: f64| {
                let sides = [-aside, aside].map(|by_step| {
                    let mut along = [sign; 2];
                    along[step_axis] = by_step;
                    toward(along)
                });
                let half = clipped(&part.corners, |corner| sides[0].at(corner));
                area(&clipped(&half, |corner| sides[1].at(corner)))
            };
            wedge(1.0) + wedge(-1.0)
        };
        // Rows first: columns need turning.
        for step_axis in [1, 0] {
            if bounds.most_slant > 1.0 && beyond(step_axis, bounds.most_slant) < part.rim() {
                let mut along = [0.0; 2];
                along[step_axis] = 1.0;
                let backwards = toward(along).at(part.middle()) > 0.0;
                return vec![(part, (step_axis, if backwards { -1 } else { 1 }))];
            }
        }
        let diagonals = [toward([1.0, -1.0]), toward([1.0, 1.0])];
        let parts = cut(vec![part], &diagonals).into_iter();
        parts
            .map(|part| {
                let [.., more_x, positive] = part.signs[..] else {
                    unreachable!("it was cut by two lines");
                };
                let step_axis = usize::from(more_x != positive);
                let backwards = if step_axis == 0 { more_x } else { positive };
                (part, (step_axis, if backwards { -1 } else { 1 }))
            })
            .collect()
    }

    /// A part whose rays run one way along both of the ground's axes, with its major axis: as it is, or
    /// cut into two.
    fn by_major(&self, part: Part, signs: [i32; 2], bounds: &Bounds) -> Vec<(Part, usize)> {
        let signs = signs.map(f64::from);
        // The area whose rays advance more.
        let beyond = |major: usize, advance: f64| {
            let mut by_axis = signs;
            by_axis[major] *= -advance;
            let line = self.line(by_axis[0], by_axis[1]);
            area(&clipped(&part.corners, |corner| line.at(corner)))
        };
        let major = usize::from(beyond(1, 1.0) < beyond(0, 1.0));
        if bounds.most_slant > 1.0
            && beyond(major, bounds.most_slant) < part.rim()
            && !bounds.is_beside(1 - major, signs[1 - major])
        {
            return vec![(part, major)];
        }
        let diagonals = [self.line(1.0, -1.0), self.line(1.0, 1.0)];
        let parts = cut(vec![part], &diagonals).into_iter();
        parts
            .map(|part| {
                let [.., east, both] = part.signs[..] else {
                    unreachable!("it was cut by two lines");
                };
                (part, usize::from(east != both))
            })
            .collect()
    }

    /// A part cut along vertical planes into strips of about `width` pixels where it is widest.
    fn strips(&self, part: Part, step_axis: usize, point: [f64; 3], width: u32) -> Vec<Part> {
        let lane_axis = 1 - step_axis;
        let [from, to] = part.range(lane_axis);
        let count = ((to - from) / f64::from(width)).ceil().max(1.0) as u32;
        let mut parts = Vec::new();
        let mut rest = part;
        // Strips are cut at even distances along the middle step; each cut is a vertical plane.
        let [low, high] = rest.range(step_axis);
        for k in 1..count {
            let mut through = [0.0; 2];
            through[lane_axis] = from + (to - from) * f64::from(k) / f64::from(count);
            through[step_axis] = 0.5 * (low + high);
            let [x, y] = [0, 1].map(|axis| point[axis] - through[axis] * point[2]);
            // The cross product of a pixel's offset and the direction of the plane's line.
            let line = Line {
                at_origin: through[1] * x - through[0] * y,
                along: [y, -x],
            };
            let sides = [true, false].map(|positive| rest.on(Side { line, positive }));
            let mut ordered: Vec<_> = sides.into_iter().flatten().collect();
            if ordered.len() < 2 {
                continue;
            }
            // The lower side is done; the upper one is cut further.
            if ordered[0].range(lane_axis)[0] < ordered[1].range(lane_axis)[0] {
                ordered.swap(0, 1);
            }
            parts.push(ordered.remove(1));
            rest = ordered.remove(0);
        }
        parts.push(rest);
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::MOST_SLANT;
    use sandtable_view::{Attitude, Camera, Screen};
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    fn bounds(width: u32, work: f64, most_slant: f64) -> Bounds {
        Bounds {
            width,
            work,
            most_slant,
            eye: [3.0, 4.0],
            cells: [8; 2],
            rise: -1.0,
        }
    }

    fn views() -> Vec<View> {
        let mut views = Vec::new();
        // Odd sizes have a pixel right below the eye, and lines through pixels' centres.
        for size in [[41, 41], [40, 40], [64, 35], [35, 64]] {
            for pitch in [-FRAC_PI_2, -1.2, -0.5, 0.0, 0.4, FRAC_PI_2] {
                for (yaw, roll) in [(0.0, 0.0), (FRAC_PI_4, 0.0), (0.0, FRAC_PI_4), (1.1, 2.3)] {
                    let attitude = Attitude { yaw, pitch, roll };
                    let camera = Camera {
                        eye: DVec3::new(3.0, 4.0, 5.0),
                        attitude,
                        horizontal_fov: FRAC_PI_2,
                    };
                    views.push(camera.view(size));
                }
            }
            views.push(View {
                eye: DVec3::new(0.25, -0.5, 1.0),
                window: Screen::horizontal(2.0, 2.0),
                size,
            });
        }
        views
    }

    #[test]
    fn each_pixel_is_in_one_sector() {
        let stretched = DVec3::new(0.5, 1.0, 1.0);
        for (per_metre, width, most) in [
            (DVec3::ONE, 512, 1.0),
            (stretched, 7, 1.0),
            (stretched, 512, MOST_SLANT),
        ] {
            for view in views() {
                let [w, h] = view.size;
                let mut owners = vec![0; (w * h) as usize];
                for sector in ImageRays::new(&view, per_metre).sectors(&bounds(width, 200.0, most))
                {
                    for k in 0..sector.steps {
                        let [from, to] = sector.lanes(k);
                        for lane in from..to {
                            let [i, j] = sector.pixel(k, lane);
                            owners[(j * w + i) as usize] += 1;
                        }
                    }
                }
                let wrong = owners.iter().position(|&owners| owners != 1);
                assert_eq!(wrong, None, "{view:?} in strips of {width}");
            }
        }
    }

    #[test]
    fn those_that_take_long_come_first_and_none_is_too_large() {
        for mut view in views() {
            view.size = view.size.map(|side| 10 * side);
            let image = ImageRays::new(&view, DVec3::ONE);
            let sectors = image.sectors(&bounds(150, 1e4, 1.0));
            let pixels = |sector: &Sector| {
                let lanes = (0..sector.steps).map(|k| (k, sector.lanes(k)));
                let pixels =
                    lanes.flat_map(|(k, [from, to])| (from..to).map(move |lane| (k, lane)));
                let mut counts = [0.0; 2];
                for (k, lane) in pixels {
                    let [i, j] = sector.pixel(k, lane);
                    counts[usize::from(view.ray(i, j).direction.z > 0.0)] += 1.0;
                }
                counts
            };
            assert!(sectors.is_sorted_by(|a, b| a.time >= b.time));
            // Corners lie up to a pixel outside.
            let around = 2.0 * f64::from(view.size[0] + view.size[1]);
            for sector in &sectors {
                let [ground, sky] = pixels(sector);
                assert!(ground + sky > 0.0);
                assert!(ground + SKY * sky < 15_000.0 + around, "{ground} {sky}");
                let about = [1.0, FAR_TIME].map(|far| far * ground + SKY_TIME * sky);
                let is_near = about.map(|about| (sector.time - about).abs() < FAR_TIME * around);
                // A part may touch the horizon where it has no pixel of sky.
                let is_told = if sky > 0.0 {
                    is_near[1]
                } else {
                    is_near[0] || is_near[1]
                };
                assert!(is_told, "{} for {ground} and {sky}", sector.time);
            }
        }
    }

    #[test]
    fn sky_is_little_work() {
        let camera = Camera {
            eye: DVec3::new(3.0, 4.0, 5.0),
            attitude: Attitude::default(),
            horizontal_fov: 1.2,
        };
        let view = camera.view([640, 360]);
        let last_rows = |rise: f64| {
            let bounds = Bounds {
                rise,
                ..bounds(1600, 2e4, MOST_SLANT)
            };
            let mut rows: Vec<_> = ImageRays::new(&view, DVec3::ONE)
                .sectors(&bounds)
                .iter()
                .filter(|sector| sector.signs[1] > 0)
                .map(|sector| sector.first_step)
                .collect();
            rows.sort_unstable();
            rows
        };
        // Half of the image is ground, and the sky's half a fifth of the work.
        for (rise, expected) in [
            (-1.0, vec![215, 287, 359]),
            (1e9, vec![59, 119, 179, 239, 299, 359]),
        ] {
            let found = last_rows(rise);
            let differ = found.iter().zip(&expected).any(|(a, b)| a.abs_diff(*b) > 1);
            assert!(found.len() == expected.len() && !differ, "{found:?}");
        }
    }

    #[test]
    fn narrow_parts_go_with_their_neighbours() {
        let view = |yaw, pitch, roll| {
            let camera = Camera {
                eye: DVec3::new(3.0, 4.0, 5.0),
                attitude: Attitude { yaw, pitch, roll },
                horizontal_fov: 1.2,
            };
            camera.view([640, 360])
        };
        let straight_down = [0.1, 0.35, 0.6, 0.7].map(|yaw| (view(yaw, -FRAC_PI_2, 0.0), 12, 8));
        let rolled = (view(0.3, -0.3, FRAC_PI_4), 4, 2);
        for (view, alone, together) in straight_down.into_iter().chain([rolled]) {
            let count = |bounds: &Bounds| ImageRays::new(&view, DVec3::ONE).sectors(bounds).len();
            let counts = [1.0, MOST_SLANT].map(|most| count(&bounds(1600, 1e9, most)));
            assert_eq!(counts, [alone, together], "{view:?}");
        }
        // Not where rays come over the ground from aside.
        let view = view(0.1, -FRAC_PI_2, 0.0);
        let beside = Bounds {
            eye: [-1.0, -1.0],
            ..bounds(1600, 1e9, MOST_SLANT)
        };
        assert_eq!(ImageRays::new(&view, DVec3::ONE).sectors(&beside).len(), 10);
    }

    #[test]
    fn rays_of_a_sector_run_its_way() {
        for (view, most) in views()
            .into_iter()
            .flat_map(|view| [(view, 1.0), (view, MOST_SLANT)])
        {
            // Large enough that a pixel's width along all borders is little.
            let view = View {
                size: view.size.map(|side| 6 * side),
                ..view
            };
            let image = ImageRays::new(&view, DVec3::ONE);
            let [px, py, pw] = image.vertical();
            let mut beyond = 0;
            for sector in image.sectors(&bounds(512, 200.0, most)) {
                for k in 0..sector.steps {
                    let [from, to] = sector.lanes(k);
                    for lane in from..to {
                        let mut pixel = [f64::from(sector.image_step(k)); 2];
                        pixel[1 - sector.step_axis] = f64::from(lane);
                        let d = image.first + pixel[0] * image.steps[0] + pixel[1] * image.steps[1];
                        let toward = [px - pixel[0] * pw, py - pixel[1] * pw];
                        let back = -f64::from(sector.direction) * toward[sector.step_axis];
                        let aside = toward[1 - sector.step_axis].abs();
                        let along = [d.x, d.y];
                        let major = along[sector.major] * f64::from(sector.signs[0]);
                        let minor = along[1 - sector.major] * f64::from(sector.signs[1]);
                        assert!(minor >= -1e-9, "{view:?}");
                        let is_near = aside <= most * back + 1e-9 && minor <= most * major + 1e-9;
                        beyond += u32::from(!is_near);
                    }
                }
            }
            let [width, height] = view.size;
            let few = if most > 1.0 { 2 * (width + height) } else { 0 };
            assert!(beyond <= few, "{beyond} in {view:?}");
        }
    }
}
