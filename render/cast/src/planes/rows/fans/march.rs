//! Sixteen planes at a time: the ground's profiles, line of posts by line, and what of them is seen
//! over the horizon of all lines before.

use super::super::March;
use super::super::scratch::{MARGIN, MEMORY, Scratch};
use super::fan::Fan;
use crate::lanes::{LANES, Lanes};
use crate::planes::profile::{Crossing, PASSED, PlaneGroup, ceiling, twice, upper_bytes};

/// One number a plane.
type Each = [f32; LANES];

/// How many pixels wide apart two hits may lie along the ground that are taken for one piece of it.
pub(super) const SAME: f32 = 5.0;

/// How many cells of the finest level a pixel may cover before the next one is taken; of the others
/// it is two. Where pixels are hardly wider than posts, these are nearer to the truth than anything
/// that is made of them.
const FINEST: f32 = 2.6;

/// In how many parts light is added up to a pixel's: the sum of 8 bits times all of them has 16.
const PARTS: f32 = 256.0;

/// Planes' rays: those between pixels, of which the first is the lower border of the first pixel in
/// which their plane is seen; and where they begin and end.
struct Rays {
    /// Directions as affine functions of the border's number: metres up, and cells along the major
    /// axis.
    up: [Each; 2],
    major: [Each; 2],
    /// From one border to the next their slope (up for each 1 of the major axis) grows by 1 / (this
    /// · one's major · the other's), times [`PARTS`].
    parts: Each,
    /// The slope up to which the ground has been seen, or is not to be looked at.
    horizon: Each,
    /// As [`PlaneGroup`] has it.
    advance: Each,
    /// The t at which planes come over the ground and leave it.
    enter: Each,
    leave: Each,
    /// In how many steps planes are seen, and where among what is seen the first one goes.
    steps: Each,
    place: [i32; LANES],
    /// Which of the planes may meet ground, and from which t on.
    live: u16,
    start: f32,
}

impl Rays {
    /// The t from which on all planes are over the ground, and the one up to which they are.
    fn over_ground(&self) -> [f32; 2] {
        [
            self.enter.iter().copied().fold(0.0, f32::max),
            self.leave.iter().copied().fold(f32::INFINITY, f32::min),
        ]
    }
}

impl<L: Lanes> March<'_, L> {
    /// The rays of sixteen planes.
    fn plane_rays(&self, fan: &Fan, first: usize, scratch: &Scratch) -> Rays {
        let steep = self.steep();
        let [[major_begin, major_end], [minor_begin, minor_end]] = self.bounds;
        let top = self.fields[0].highest - self.fields[0].eye_height;
        let mut rays = Rays {
            up: [[0.0; LANES]; 2],
            major: [[0.0; LANES]; 2],
            parts: [0.0; LANES],
            horizon: [0.0; LANES],
            advance: [0.0; LANES],
            enter: [0.0; LANES],
            leave: [0.0; LANES],
            steps: [0.0; LANES],
            place: [0; LANES],
            live: 0,
            start: f32::INFINITY,
        };
        for k in 0..LANES {
            let plane = first + k;
            let [begin, end] = fan.seen(plane);
            let is_seen = begin < end;
            let (begin, end) = if is_seen {
                (begin, end)
            } else {
                (fan.from, fan.to)
            };
            let lane = fan.lane(begin, plane);
            let d = self.directions.at_place(begin, lane);
            let step = self.directions.step - fan.back(plane) * self.directions.lane;
            let far = d + f64::from(end - begin) * step;
            let advance = (far.y.max(0.0) / far.x.max(steep)).min(1.0) as f32;
            let border = d - 0.5 * step;
            rays.up[0][k] = border.z as f32;
            rays.up[1][k] = step.z as f32;
            rays.major[0][k] = border.x as f32;
            rays.major[1][k] = step.x as f32;
            rays.parts[k] = (f64::from(PARTS) / (step.z * d.x - d.z * step.x)) as f32;
            let before = d - step;
            let horizon = before.z / before.x.max(steep);
            rays.horizon[k] = horizon as f32;
            rays.advance[k] = advance;
            let mut start = major_begin.max(0.0);
            if minor_begin > 0.0 {
                start = start.max(minor_begin / advance);
            }
            let leave = major_end.min(minor_end / advance);
            rays.enter[k] = start;
            rays.leave[k] = leave;
            if !is_seen {
                continue;
            }
            rays.steps[k] = (end - begin) as f32;
            rays.place[k] = ((begin - fan.from) as usize * fan.room() + plane) as i32;
            if top < 0.0 {
                if horizon >= 0.0 {
                    continue;
                }
                start = start.max(top / horizon as f32);
            }
            if begin == fan.from && begin > 0 {
                match self.seen_before(begin - 1, lane + fan.back(plane), scratch) {
                    Some(t) if t < 0.0 => continue,
                    Some(t) => start = start.max(t),
                    None => {}
                }
            }
            if start < leave {
                rays.live |= 1 << k;
                rays.start = rays.start.min(start);
            }
        }
        rays
    }

    /// How far the rays around a place in the step before a fan reach, at least: all that are
    /// higher see nothing nearer. Less than 0 where they meet nothing.
    fn seen_before(&self, step: u32, lane: f64, scratch: &Scratch) -> Option<f32> {
        let [from, to] = scratch.lanes[step as usize % MEMORY];
        if from >= to {
            return None;
        }
        let lane = lane.floor() as i32;
        let reached = [lane, lane + 1].map(|lane| {
            let lane = lane.clamp(from, to - 1) as usize;
            scratch.reached[self.slot(step) + MARGIN + lane]
        });
        let [least, most] = [reached[0].min(reached[1]), reached[0].max(reached[1])];
        Some(if least < 0.0 { most } else { least })
    }

    /// Finds what sixteen planes see, the first of which is plane `first`.
    ///
    /// A pixel's colour is the mean of its plane's between the pixel's borders: of what of each piece
    /// of the profile rises over the horizon, in proportion to how much.
    #[inline(always)]
    pub(super) fn march(&self, fan: &Fan, first: usize, scratch: &Scratch, seen: &mut [[i32; 2]]) {
        let l = self.l;
        let rays = self.plane_rays(fan, first, scratch);
        let load = |numbers: &Each| l.load(numbers);
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let steps = load(&rays.steps);
        let period = l.splat_i(fan.room() as i32);
        // Borders that the horizon has come over, and where the pixel under the next one goes.
        let (mut border, mut place) = (zero, l.load_i(&rays.place));
        // The light of the pixel under the next border, so far, and its parts.
        let (mut red_blue, mut green_alpha) = (l.splat_i(0), l.splat_i(0));
        let mut parts = l.splat_i(0);
        // Of the last border, one over how many of its direction's lengths away the ground is, which
        // is affine in the image of a plane; and 1 / t of the horizon.
        let (mut near, mut far) = (zero, zero);
        if rays.live != 0 {
            let (up, up_step) = (load(&rays.up[0]), load(&rays.up[1]));
            let (major, major_step) = (load(&rays.major[0]), load(&rays.major[1]));
            let (enter, leave) = (load(&rays.enter), load(&rays.leave));
            let [last_enter, first_leave] = rays.over_ground();
            let planes = PlaneGroup::new(l, &rays.advance);
            let all_parts = load(&rays.parts);
            let steep = l.splat(self.steep() as f32);
            let mut live = l.mask(rays.live);

            // All planes of a group are in one resolution, that which suits one of them.
            let middle = rays.live.trailing_zeros() as usize;
            let coarsest = self.fields.len() - 1;
            let cell = f64::from(self.frame.detail.as_ref().map_or(1.0, |detail| detail.cell));
            let width_at = |steps: f32| {
                let step = (fan.seen(first + middle)[0] + steps as u32).min(fan.to - 1);
                (cell * self.pixel_width(step, fan.lane(step, first + middle))) as f32
            };
            let level_at = |t: f32, width: f32| {
                let covered = t * width;
                if covered < FINEST {
                    0
                } else {
                    (((covered.to_bits() >> 23) - 127) as usize).min(coarsest)
                }
            };
            let limit_of = |level: usize, width: f32| {
                if level == coarsest {
                    f32::INFINITY
                } else if level == 0 {
                    FINEST / width
                } else {
                    (2 << level) as f32 / width
                }
            };
            let width = width_at(0.0);
            let same = l.splat(1.0 + SAME * width / cell as f32);
            let mut level = level_at(rays.start, width);
            let mut limit = limit_of(level, width);
            let mut field = &self.fields[level];
            let line = (rays.start / field.scale + field.major.fraction) as i32;
            let mut line = line.max(field.major.cells[0]);
            let mut t = (line as f32 - field.major.fraction) * field.scale;
            let mut height = Crossing::new(l, field, &planes, line).heights(l, field, &planes);

            let mut horizon = load(&rays.horizon);
            // The pixel's slopes.
            let mut low = zero;
            let mut run = l.max(major, steep);
            let mut high = l.div(up, run);
            let mut per_slope = zero;
            // The last line's slopes, as far as there is ground, and its colours.
            let mut slope = l.mul(height, l.splat(1.0 / t.max(NEAREST)));
            let mut colours = [l.splat_i(0); 2];
            // Whether nothing was seen since the last blocks began.
            let mut is_idle = true;
            loop {
                if t >= limit {
                    let mut done = [0.0; LANES];
                    l.store(border, &mut done);
                    let width = width_at(done[middle]);
                    let coarser = level_at(t, width);
                    if coarser > level {
                        level = coarser;
                        field = &self.fields[level];
                        line = (t / field.scale + field.major.fraction + 1e-3) as i32;
                    }
                    limit = limit_of(level, width).max(t * 1.001);
                }
                if field.major.is_block(line) {
                    if is_idle {
                        let passes = |level: usize| {
                            let ceiling = ceiling(field, &planes, line, level)?;
                            let behind = line + (1 << level);
                            let end = (behind as f32 - field.major.fraction) * field.scale;
                            let ceiling = l.splat(ceiling);
                            let below = l.and(
                                l.lt(ceiling, l.mul(horizon, l.splat(t))),
                                l.lt(ceiling, l.mul(horizon, l.splat(end))),
                            );
                            (end <= limit && l.bits(l.and_not(live, below)) == 0).then_some(behind)
                        };
                        if let Some(behind) = PASSED.into_iter().find_map(passes) {
                            line = behind;
                            t = (line as f32 - field.major.fraction) * field.scale;
                            height =
                                Crossing::new(l, field, &planes, line).heights(l, field, &planes);
                            slope = l.mul(height, l.splat(1.0 / t.max(NEAREST)));
                            live = l.and(live, l.lt(l.splat(t), leave));
                            if l.bits(live) == 0 {
                                break;
                            }
                            continue;
                        }
                    }
                    is_idle = true;
                }
                line += 1;
                if line > field.major.cells[1] + 1 {
                    break;
                }
                let end = (line as f32 - field.major.fraction) * field.scale;
                let crossing = Crossing::new(l, field, &planes, line);
                let end_height = crossing.heights(l, field, &planes);
                let mut here = live;
                let mut from_inverse = l.splat(1.0 / t.max(NEAREST));
                let mut inverse = l.splat(1.0 / end);
                let mut end_slope = l.mul(end_height, inverse);
                if t < last_enter || first_leave < end {
                    // The ground begins or ends between the lines.
                    let from = l.max(l.splat(t), enter);
                    let to = l.min(l.splat(end), leave);
                    live = l.and(live, l.lt(from, leave));
                    if l.bits(live) == 0 {
                        break;
                    }
                    here = l.and(live, l.lt(from, to));
                    let rise = l.mul(l.sub(end_height, height), l.splat(1.0 / (end - t)));
                    from_inverse = l.div(one, l.max(from, l.splat(NEAREST)));
                    slope = l.mul(
                        l.add(height, l.mul(rise, l.sub(from, l.splat(t)))),
                        from_inverse,
                    );
                    inverse = l.div(one, l.max(to, l.splat(NEAREST)));
                    end_slope = l.mul(l.add(height, l.mul(rise, l.sub(to, l.splat(t)))), inverse);
                }
                // Where the ground begins over the horizon, its side is seen, too.
                let top = l.max(slope, end_slope);
                let mut visible = l.and(here, l.lt(horizon, top));
                if l.bits(visible) != 0 {
                    is_idle = false;
                    let end_colours = match field.colours {
                        Some(colours) => crossing.colours(l, field, &planes, colours),
                        None => [l.splat_i(0); 2],
                    };
                    // Where the line before was not seen, all that is seen lies close to this one.
                    let unseen = l.or(l.lt(slope, horizon), l.lt(horizon, slope));
                    let ends = [
                        [
                            l.select_i(unseen, end_colours[0], colours[0]),
                            l.select_i(unseen, end_colours[1], colours[1]),
                        ],
                        end_colours,
                    ];
                    colours = end_colours;
                    let rise = l.max(l.sub(end_slope, slope), l.splat(f32::MIN_POSITIVE));
                    let per_rise = l.div(one, rise);
                    // How much of the way from line to line has been seen.
                    let mut done_share = zero;
                    loop {
                        let over = l.and(visible, l.le(high, top));
                        if l.bits(over) == 0 {
                            break;
                        }
                        let share = l.max(l.mul(l.sub(high, slope), per_rise), zero);
                        let rest = l.sub_i(l.splat_i(PARTS as i32), parts);
                        let [more_red_blue, more_green_alpha] =
                            light(l, ends, l.add(done_share, share), rest);
                        let whole = [
                            l.add_i(red_blue, more_red_blue),
                            l.add_i(green_alpha, more_green_alpha),
                        ];
                        done_share = l.select(over, share, done_share);
                        let way = l.mul(l.sub(inverse, from_inverse), share);
                        let crossed = l.mul(l.add(from_inverse, way), run);
                        let is_one = l.le(near, l.mul(crossed, same));
                        let between = l.mul(l.add(near, crossed), l.splat(0.5));
                        let at = l.select(is_one, between, near);
                        let pixel = l.and(over, l.lt(zero, border));
                        l.scatter_pairs(
                            pixel,
                            place,
                            [packed(l, whole), l.bits_of_float(at)],
                            seen,
                        );
                        place = l.add_i_where(pixel, place, period);
                        border = l.select(over, l.add(border, one), border);
                        near = l.select(over, crossed, near);
                        low = l.select(over, high, low);
                        let next_run = l.max(l.add(major, l.mul(border, major_step)), steep);
                        let next = l.div(l.add(up, l.mul(border, up_step)), next_run);
                        let next_per_slope = l.mul(l.mul(run, next_run), all_parts);
                        per_slope = l.select(over, next_per_slope, per_slope);
                        run = next_run;
                        high = next;
                        red_blue = l.select_i(over, l.splat_i(0), red_blue);
                        green_alpha = l.select_i(over, l.splat_i(0), green_alpha);
                        parts = l.select_i(over, l.splat_i(0), parts);
                        let is_done = l.lt(steps, border);
                        visible = l.and_not(visible, is_done);
                        live = l.and_not(live, is_done);
                    }
                    let up_to = l.mul(l.sub(top, low), per_slope);
                    let up_to = l.to_int(l.max(l.min(up_to, l.splat(PARTS)), zero));
                    let up_to = l.select_i(visible, l.max_i(up_to, parts), parts);
                    let more = l.sub_i(up_to, parts);
                    let [more_red_blue, more_green_alpha] =
                        light(l, ends, l.add(done_share, one), more);
                    red_blue = l.add_i(red_blue, more_red_blue);
                    green_alpha = l.add_i(green_alpha, more_green_alpha);
                    parts = up_to;
                    horizon = l.select(visible, top, horizon);
                    far = l.select(visible, inverse, far);
                    if l.bits(live) == 0 {
                        break;
                    }
                }
                t = end;
                height = end_height;
                slope = end_slope;
            }
        }
        let (mut borders, mut places) = ([0.0; LANES], [0; LANES]);
        l.store(border, &mut borders);
        l.store_i(place, &mut places);
        let mut colours = [0; LANES];
        l.store_i(packed(l, [red_blue, green_alpha]), &mut colours);
        // Half-way up the pixel.
        let half = l.div(l.splat(0.5 * PARTS), l.max(l.to_float(parts), one));
        let mut middles = [0.0; LANES];
        let end = l.add(
            l.sub(border, one),
            l.mul(l.to_float(parts), l.splat(1.0 / PARTS)),
        );
        let end = l.add(load(&rays.major[0]), l.mul(end, load(&rays.major[1])));
        let far = l.mul(far, end);
        l.store(l.add(near, l.mul(l.sub(far, near), half)), &mut middles);
        for k in 0..LANES {
            // The ground ends in this pixel, and above it there is the sky.
            let mut pixel = [0; 2];
            let mut left = rays.steps[k] as usize;
            if borders[k] > 0.0 {
                left = (rays.steps[k] + 1.0 - borders[k]) as usize;
                let is_ground = colours[k] < 0;
                let at = if is_ground { middles[k] } else { 0.0 };
                pixel = [colours[k], at.to_bits() as i32];
            }
            for row in 0..left {
                seen[places[k] as usize + row * fan.room()] = pixel;
                pixel = [0; 2];
            }
        }
    }
}

/// Closer lines than this t are taken to lie there.
const NEAREST: f32 = 1e-3;

/// So many parts of the light of a piece of ground between two colours; it lies half of `twice_share`
/// of the way from the first one to the second.
#[inline(always)]
fn light<L: Lanes>(
    l: L,
    [begin, end]: [[L::I; 2]; 2],
    twice_share: L::F,
    parts: L::I,
) -> [L::I; 2] {
    let share = l.to_int(l.mul(l.min(twice_share, l.splat(2.0)), l.splat(64.0)));
    let of_end = l.shr_i(l.mul_halves(parts, share), l.splat_i(7));
    let of_begin = twice(l, l.sub_i(parts, of_end));
    let of_end = twice(l, of_end);
    [
        l.add_i(
            l.mul_halves(begin[0], of_begin),
            l.mul_halves(end[0], of_end),
        ),
        l.add_i(
            l.mul_halves(begin[1], of_begin),
            l.mul_halves(end[1], of_end),
        ),
    ]
}

/// Colours from sums of light in halves.
#[inline(always)]
fn packed<L: Lanes>(l: L, [red_blue, green_alpha]: [L::I; 2]) -> L::I {
    let green_alpha = l.add_i(green_alpha, l.splat_i(0x0080_0080));
    let green_alpha = l.and_i(green_alpha, l.splat_i(0xff00_ff00_u32 as i32));
    l.add_i(upper_bytes(l, red_blue), green_alpha)
}
