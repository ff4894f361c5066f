//! Cell by cell: the exact meeting of rays with the ground's bilinear surface.

use super::climb::{self, NEAR, approach, level_for, rises_far};
use super::coarser::Coarser;
use super::field::Field;
use super::roofs::FINEST;
use super::wave::{CAPACITY, CHUNK, Column, Ray, Wave, group, group_mut};
use crate::lanes::{LANES, Lanes};

/// What one cell's or block's passage needs between its loops.
#[repr(align(64))]
pub(super) struct Passage {
    pub(super) place: Column<i32>,
    posts: [Column<f32>; 4],
}

impl Default for Passage {
    fn default() -> Self {
        Self {
            place: [0; CAPACITY],
            posts: [[0.0; CAPACITY]; 4],
        }
    }
}

/// A cell's corners: nearest, one further along the major axis, along the minor axis, along both.
#[inline(always)]
fn corners<L: Lanes>(field: &Field<'_>, [sw, se, nw, ne]: [L::F; 4]) -> [L::F; 4] {
    let [x, y] = field.x_y();
    let [sw, se, nw, ne] = if x.sign > 0 {
        [sw, se, nw, ne]
    } else {
        [se, sw, ne, nw]
    };
    let [near, x, y, both] = if y.sign > 0 {
        [sw, se, nw, ne]
    } else {
        [nw, ne, sw, se]
    };
    if field.major_axis == 0 {
        [near, x, y, both]
    } else {
        [near, y, x, both]
    }
}

/// Rays of a step that set out low over the ground, a number a lane: most of them end in their first
/// cell, so they go through it where they are, and only those that go on are closed up into a wave.
#[repr(align(64))]
pub(super) struct Departure {
    inverse: [f32; CHUNK],
    leave: [f32; CHUNK],
    t: [f32; CHUNK],
    major: [i32; CHUNK],
    minor: [i32; CHUNK],
    /// Which lanes of each group set out here.
    masks: [u16; CHUNK / LANES],
    /// And which of them are led to a roof first.
    high: [u16; CHUNK / LANES],
}

impl Default for Departure {
    fn default() -> Self {
        Self {
            inverse: [0.0; CHUNK],
            leave: [0.0; CHUNK],
            t: [0.0; CHUNK],
            major: [0; CHUNK],
            minor: [0; CHUNK],
            masks: [0; CHUNK / LANES],
            high: [0; CHUNK / LANES],
        }
    }
}

fn lanes<T>(numbers: &[T], at: usize) -> &[T; LANES] {
    numbers[at..].first_chunk().expect("room was made")
}

fn lanes_mut<T>(numbers: &mut [T], at: usize) -> &mut [T; LANES] {
    numbers[at..].first_chunk_mut().expect("room was made")
}

impl Departure {
    /// Forgets the rays of the group that begins at lane `at`.
    #[inline(always)]
    pub(super) fn clear(&mut self, at: usize) {
        self.masks[at / LANES] = 0;
        self.high[at / LANES] = 0;
    }

    /// Takes the rays of `mask` as the group that begins at lane `at`, each with its t and its
    /// mirrored cell there.
    #[inline(always)]
    pub(super) fn put<L: Lanes>(
        &mut self,
        l: L,
        at: usize,
        mask: L::M,
        high: L::M,
        ray: &Ray<L>,
        t: L::F,
        [major, minor]: [L::I; 2],
    ) {
        self.masks[at / LANES] = l.bits(mask);
        self.high[at / LANES] = l.bits(high);
        l.store(ray.inverse, lanes_mut(&mut self.inverse, at));
        l.store(ray.leave, lanes_mut(&mut self.leave, at));
        l.store(t, lanes_mut(&mut self.t, at));
        l.store_i(major, lanes_mut(&mut self.major, at));
        l.store_i(minor, lanes_mut(&mut self.minor, at));
    }

    #[inline(always)]
    fn cell<L: Lanes>(&self, l: L, at: usize) -> [L::I; 2] {
        [
            l.load_i(lanes(&self.major, at)),
            l.load_i(lanes(&self.minor, at)),
        ]
    }
}

/// The lanes of a step that set out together, among all numbers that are kept of it.
pub(super) struct Step<'a> {
    /// The number of the first lane, and how many lanes there are.
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) advance: &'a [f32],
    pub(super) slope: &'a [f32],
}

/// Leads the rays of a step that set out low through their first cells, as [`walk`] does. Those that
/// go on join `low`, or `high`.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "where rays come from and may go")]
pub(super) fn depart<L: Lanes>(
    l: L,
    field: &Field<'_>,
    departure: &mut Departure,
    step: &Step<'_>,
    low: &mut Wave,
    high: &mut Wave,
    passage: &mut Passage,
    reached: &mut [f32],
) {
    if departure.high[..step.count.div_ceil(LANES)]
        .iter()
        .any(|&high| high != 0)
    {
        l.vectorize(
            #[inline(always)]
            || lead_to_roofs(l, field, departure, step, high, passage),
        );
    }
    l.vectorize(
        #[inline(always)]
        || {
            for at in (0..step.count).step_by(LANES) {
                let mask = departure.masks[at / LANES];
                if mask != 0 {
                    let cell = departure.cell(l, at);
                    place(l, field, l.mask(mask), cell, passage, at);
                }
            }
        },
    );
    l.vectorize(
        #[inline(always)]
        || {
            for at in (0..step.count).step_by(LANES) {
                if departure.masks[at / LANES] != 0 {
                    fetch(l, field, passage, at);
                }
            }
        },
    );
    l.vectorize(
        #[inline(always)]
        || {
            let numbers = l.load_i(&std::array::from_fn(|k| k as i32));
            let tiny = l.splat(f32::MIN_POSITIVE);
            let (mut kept, mut risen) = (low.len(), high.len());
            for at in (0..step.count).step_by(LANES) {
                let mask = departure.masks[at / LANES];
                if mask == 0 {
                    continue;
                }
                let id = step.first + at;
                let ray = Ray {
                    advance: l.load(lanes(step.advance, id)),
                    inverse: l.load(lanes(&departure.inverse, at)),
                    slope: l.load(lanes(step.slope, id)),
                    leave: l.load(lanes(&departure.leave, at)),
                    id: l.add_i(numbers, l.splat_i(id as i32)),
                };
                let t = l.load(lanes(&departure.t, at));
                let [major, minor] = departure.cell(l, at);
                let met = meet(l, field, &ray, t, [major, minor], passage, at);
                let mask = l.mask(mask);
                let hit = l.and(mask, met.hit);
                // What is still on its way is set when it has come further.
                let nothing = l.sub(l.splat(0.0), l.max(ray.leave, tiny));
                let result = l.select(hit, met.hit_t, nothing);
                l.store(result, lanes_mut(reached, id));
                let going = l.and_not(l.and(mask, l.lt(met.next, ray.leave)), hit);
                if l.bits(going) == 0 {
                    continue;
                }
                [kept, risen] = go_on(
                    l,
                    field,
                    low,
                    high,
                    [kept, risen],
                    going,
                    &ray,
                    &met,
                    [major, minor],
                );
            }
            low.truncate(kept);
            high.truncate(risen);
        },
    );
}

/// Leads rays that set out to the roofs of their blocks: those that pass over them go on in `wave`.
#[inline(always)]
fn lead_to_roofs<L: Lanes>(
    l: L,
    field: &Field<'_>,
    departure: &mut Departure,
    step: &Step<'_>,
    wave: &mut Wave,
    passage: &mut Passage,
) {
    let finest = l.splat_i(FINEST as i32);
    let numbers = l.load_i(&std::array::from_fn(|k| k as i32));
    let groups = || (0..step.count).step_by(LANES);
    for at in groups() {
        let high = departure.high[at / LANES];
        if high != 0 {
            let place = climb::place(l, field, l.mask(high), departure.cell(l, at), finest);
            l.store_i(place, group_mut(&mut passage.place, at));
        }
    }
    let mut risen = wave.len();
    for at in groups() {
        let high = departure.high[at / LANES];
        if high == 0 {
            continue;
        }
        let id = step.first + at;
        let ray = Ray {
            advance: l.load(lanes(step.advance, id)),
            inverse: l.load(lanes(&departure.inverse, at)),
            slope: l.load(lanes(step.slope, id)),
            leave: l.load(lanes(&departure.leave, at)),
            id: l.add_i(numbers, l.splat_i(id as i32)),
        };
        let (t, cell) = (l.load(lanes(&departure.t, at)), departure.cell(l, at));
        let place = l.load_i(group(&passage.place, at));
        let to = approach(l, field, &ray, t, cell, finest, place);
        let mask = l.mask(high);
        let t = l.select(mask, to.t, t);
        l.store(t, lanes_mut(&mut departure.t, at));
        l.store_i(
            l.select_i(mask, to.cell[0], cell[0]),
            lanes_mut(&mut departure.major, at),
        );
        l.store_i(
            l.select_i(mask, to.cell[1], cell[1]),
            lanes_mut(&mut departure.minor, at),
        );
        let past = l.and(mask, to.clear);
        let left = l.and_not(mask, l.lt(t, ray.leave));
        let past = l.or(past, left);
        departure.masks[at / LANES] &= !l.bits(past);
        let past = l.and_not(past, left);
        if l.bits(past) != 0 {
            let level = l.add_i_where(rises_far(l, field, &ray, &to, finest), finest, l.splat_i(1));
            risen = wave.put_at_level(l, risen, past, &ray, t, to.cell, level);
        }
    }
    wave.truncate(risen);
}

/// Finds where the posts of a group's cells lie, and asks for their memory where it may be far.
#[inline(always)]
fn place<L: Lanes>(
    l: L,
    field: &Field<'_>,
    mask: L::M,
    cell: [L::I; 2],
    passage: &mut Passage,
    at: usize,
) {
    let place = field.heights.only(l, mask, field.place(l, cell));
    if let Some(ahead) = field.ahead {
        let ahead = l.add_i(place, l.splat_i(ahead));
        l.prefetch::<_, 1>(&field.heights.items, ahead);
    }
    l.store_i(place, group_mut(&mut passage.place, at));
}

/// Fetches the posts of a group's cells.
#[inline(always)]
fn fetch<L: Lanes>(l: L, field: &Field<'_>, passage: &mut Passage, at: usize) {
    let place = l.load_i(group(&passage.place, at));
    let posts = l.cells(&field.heights.items, place, field.heights.stride);
    for (to, posts) in passage.posts.iter_mut().zip(posts) {
        l.store(posts, group_mut(to, at));
    }
}

/// Leads each ray of `wave` through its cell. Those that meet the ground write their t to
/// `reached`; those that leave the ground are dropped; those that end far over it go to `high`,
/// and those that are too far for this resolution to `coarser`.
///
/// Three loops, as each has so little between one group's begin and end that the processor works on
/// several groups at once.
#[inline(always)]
pub(super) fn walk<L: Lanes>(
    l: L,
    field: &Field<'_>,
    wave: &mut Wave,
    high: &mut Wave,
    passage: &mut Passage,
    reached: &mut [f32],
    coarser: Option<Coarser<'_>>,
) {
    l.vectorize(
        #[inline(always)]
        || {
            for at in (0..wave.len()).step_by(LANES) {
                let mask = l.mask(wave.mask(at));
                place(l, field, mask, wave.cell(l, at), passage, at);
            }
        },
    );
    l.vectorize(
        #[inline(always)]
        || {
            for at in (0..wave.len()).step_by(LANES) {
                fetch(l, field, passage, at);
            }
        },
    );
    l.vectorize(
        #[inline(always)]
        || pass(l, field, wave, high, passage, reached, coarser),
    );
}

#[inline(always)]
fn pass<L: Lanes>(
    l: L,
    field: &Field<'_>,
    wave: &mut Wave,
    high: &mut Wave,
    passage: &Passage,
    reached: &mut [f32],
    mut coarser: Option<Coarser<'_>>,
) {
    let scale = l.splat(field.scale);
    let rays = wave.len();
    let (mut kept, mut risen) = (0, high.len());
    for at in (0..rays).step_by(LANES) {
        let mask = l.mask(wave.mask(at));
        let ray = wave.ray(l, at);
        let cell = wave.cell(l, at);
        let met = meet(l, field, &ray, wave.t(l, at), cell, passage, at);
        let mut hit = l.and(mask, met.hit);
        if let Some(coarser) = &mut coarser {
            let ends = l.and_not(mask, l.lt(met.next, ray.leave));
            if l.bits(ends) != 0 {
                // The last cell of a coarse level may reach out over the ground's border.
                let leave = field.leave(l, ray.inverse, ray.slope);
                hit = l.and_not(hit, l.and(ends, l.lt(leave, met.hit_t)));
                let passes = l.and_not(l.and(ends, l.lt(met.next, leave)), hit);
                coarser.take(l, passes, &ray, met.next, leave, None);
            }
        }
        l.scatter(hit, ray.id, l.mul(met.hit_t, scale), reached);
        let going = l.and_not(l.and(mask, l.lt(met.next, ray.leave)), hit);
        [kept, risen] = go_on(l, field, wave, high, [kept, risen], going, &ray, &met, cell);
    }
    wave.truncate(kept);
    high.truncate(risen);
}

/// Writes the rays of `going`, behind the cell that they met, to `low` and `high`, closed up from
/// `ends` on; gives where the next go.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "what rays are made of")]
fn go_on<L: Lanes>(
    l: L,
    field: &Field<'_>,
    low: &mut Wave,
    high: &mut Wave,
    [kept, risen]: [usize; 2],
    going: L::M,
    ray: &Ray<L>,
    met: &Met<L>,
    [major, minor]: [L::I; 2],
) -> [usize; 2] {
    let one_cell = l.splat_i(1);
    let major = l.add_i_where(met.crosses_major, major, one_cell);
    let minor = l.add_i_where(l.and_not(going, met.crosses_major), minor, one_cell);
    let steep = field.steep(l, ray.slope);
    let up = l.and(going, l.lt(l.mul(steep, l.splat(NEAR)), met.clearance));
    let kept = low.put(l, kept, l.and_not(going, up), ray, met.next, [major, minor]);
    if l.bits(up) == 0 {
        return [kept, risen];
    }
    let level = level_for(l, l.div(met.clearance, steep));
    let risen = high.put_at_level(l, risen, up, ray, met.next, [major, minor], level);
    [kept, risen]
}

/// How rays came through a cell.
struct Met<L: Lanes> {
    /// Those that meet the ground in it, and at which t.
    hit: L::M,
    hit_t: L::F,
    /// The t behind the cell, the clearance there in metres, and whether that is at a line across
    /// the major axis.
    next: L::F,
    clearance: L::F,
    crosses_major: L::M,
}

/// Where rays that are at t in a mirrored cell meet the ground in it.
#[inline(always)]
fn meet<L: Lanes>(
    l: L,
    field: &Field<'_>,
    ray: &Ray<L>,
    t: L::F,
    [major, minor]: [L::I; 2],
    passage: &Passage,
    at: usize,
) -> Met<L> {
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let major_line = l.splat(1.0 - field.major.fraction);
    let minor_line = l.splat(1.0 - field.minor.fraction);
    let eye = l.splat(field.eye_height);
    let eye_rest = l.splat(field.eye_rest);
    let [sw, se, nw, ne] = &passage.posts;
    let posts = [sw, se, nw, ne].map(|posts| group(posts, at));
    let [near, far_major, far_minor, both] = corners::<L>(
        field,
        [
            l.load(posts[0]),
            l.load(posts[1]),
            l.load(posts[2]),
            l.load(posts[3]),
        ],
    );
    // Where the lines behind the cell lie.
    let to_major = l.add(l.to_float(major), major_line);
    let to_minor = l.add(l.to_float(minor), minor_line);
    // Heights over the corner that is far along both; and of that over the eye, as near to
    // the truth as if it had more digits.
    let corner = l.sub(l.sub(both, eye), eye_rest);
    let by_minor = l.sub(far_minor, both);
    let by_major = l.sub(far_major, both);
    let by_none = l.sub(near, both);
    // The clearance at t.
    let major_left = l.sub(to_major, t);
    let minor_left = l.sub(to_minor, l.mul(t, ray.advance));
    let far = l.mul(major_left, by_minor);
    let this = l.add(by_major, l.mul(major_left, l.sub(by_none, by_major)));
    let height = l.add(far, l.mul(minor_left, l.sub(this, far)));
    let clearance = l.sub(l.sub(l.mul(t, ray.slope), corner), height);
    // And at the end of the cell, on its far edge: back along the edge from that corner.
    let minor_t = l.mul(to_minor, ray.inverse);
    let crosses_major = l.lt(to_major, minor_t);
    let next = l.max(l.min(to_major, minor_t), t);
    let left = l.select(
        crosses_major,
        l.sub(to_minor, l.mul(next, ray.advance)),
        l.sub(to_major, next),
    );
    let height = l.mul(l.select(crosses_major, by_major, by_minor), left);
    let next_clearance = l.sub(l.sub(l.mul(next, ray.slope), corner), height);
    // Along the cell the clearance is a quadratic; this is its bend over the segment.
    let twist = l.sub(l.sub(by_none, by_major), by_minor);
    let length = l.sub(next, t);
    let bend = l.mul(l.mul(twist, ray.advance), l.mul(length, length));
    // Its first root, in the form that neither cancels nor divides by a bend of 0.
    let start = l.max(clearance, zero);
    let linear = l.add(l.sub(next_clearance, start), bend);
    let twice = l.add(start, start);
    let discriminant = l.add(l.mul(linear, linear), l.mul(l.add(twice, twice), bend));
    let root = l.sqrt(l.max(discriminant, zero));
    let divisor = l.sub(root, linear);
    // Both ends in the air: a root only where the quadratic dips below 0 in between.
    let dips = l.and(
        l.and(l.le(zero, discriminant), l.lt(linear, zero)),
        l.lt(twice, divisor),
    );
    let below = l.or(l.le(next_clearance, zero), l.le(clearance, zero));
    let share = l.min(l.div(twice, l.max(divisor, l.splat(1e-30))), one);
    Met {
        hit: l.or(below, dips),
        hit_t: l.add(t, l.mul(share, length)),
        next,
        clearance: next_clearance,
        crosses_major,
    }
}
