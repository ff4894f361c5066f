//! Cell by cell: the exact meeting of rays with the ground's bilinear surface.

use super::climb::{NEAR, level_for};
use super::coarser::Coarser;
use super::field::Field;
use super::patches::{NUMBERS, Patch, Patches, packed};
use super::wave::{CAPACITY, Column, Ray, Wave};
use crate::lanes::{LANES, Lanes, group, group_mut};

/// What one cell's or block's passage needs between its loops.
#[repr(align(64))]
pub(super) struct Passage {
    pub(super) place: Column<i32>,
    posts: [Column<f32>; 4],
    /// The ground that rays met, and the numbers of these rays: of those that met none, one that no ray
    /// has.
    ids: Column<i32>,
    patches: [Column<i32>; NUMBERS],
}

impl Default for Passage {
    fn default() -> Self {
        Self {
            place: [0; CAPACITY],
            posts: [[0.0; CAPACITY]; 4],
            ids: [0; CAPACITY],
            patches: [[0; CAPACITY]; NUMBERS],
        }
    }
}

impl Passage {
    /// Keeps the ground that a group's rays meet until all have gone their way.
    #[inline(always)]
    fn keep<L: Lanes>(&mut self, l: L, at: usize, hit: L::M, id: L::I, patch: &Patch<L>) {
        let id = l.select_i(hit, id, l.splat_i(i32::MAX));
        l.store_i(id, group_mut(&mut self.ids, at));
        for (to, bits) in self.patches.iter_mut().zip(patch.bits(l)) {
            l.store_i(bits, group_mut(to, at));
        }
    }
}

/// A cell's corners: nearest, one further along the major axis, along the minor axis, along both.
#[inline(always)]
pub(super) fn corners<L: Lanes>(field: &Field<'_>, [sw, se, nw, ne]: [L::F; 4]) -> [L::F; 4] {
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

/// Finds where the posts of a group's cells lie.
#[inline(always)]
pub(super) fn place<L: Lanes>(
    l: L,
    field: &Field<'_>,
    mask: L::M,
    cell: [L::I; 2],
    passage: &mut Passage,
    at: usize,
) {
    let place = field.heights.only(l, mask, field.place(l, cell));
    l.store_i(place, group_mut(&mut passage.place, at));
}

/// Asks for the memory of the posts of a group's cells, where it may be far.
#[inline(always)]
pub(super) fn ask<L: Lanes>(l: L, field: &Field<'_>, passage: &Passage, at: usize) {
    if let Some(ahead) = field.ahead {
        let place = group(&passage.place, at);
        l.prefetch::<_, 1>(&field.heights.items, place, ahead);
    }
}

/// Fetches the posts of a group's cells.
#[inline(always)]
pub(super) fn fetch<L: Lanes>(l: L, field: &Field<'_>, passage: &mut Passage, at: usize) {
    let place = group(&passage.place, at);
    let posts = l.cells(&field.heights.items, place, field.heights.stride);
    for (to, posts) in passage.posts.iter_mut().zip(posts) {
        l.store(posts, group_mut(to, at));
    }
}

/// Leads each ray of `wave` through its cell. Those that meet the ground write their t to
/// `reached` and, if it `KEEPS` that, the cell's ground to `patches`; those that leave the ground are
/// dropped; those that end far over it go to `high`, and those that are too far for this resolution
/// to `coarser`.
///
/// Three loops, as each has so little between one group's begin and end that the processor works on
/// several groups at once.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "where rays come from and may go")]
pub(super) fn walk<L: Lanes, const KEEPS: bool>(
    l: L,
    field: &Field<'_>,
    wave: &mut Wave,
    high: &mut Wave,
    passage: &mut Passage,
    reached: &mut [f32],
    patches: &mut Patches,
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
                ask(l, field, passage, at);
            }
            for at in (0..wave.len()).step_by(LANES) {
                fetch(l, field, passage, at);
            }
        },
    );
    l.vectorize(
        #[inline(always)]
        || pass::<L, KEEPS>(l, field, wave, high, passage, reached, patches, coarser),
    );
}

#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "as `walk` has")]
fn pass<L: Lanes, const KEEPS: bool>(
    l: L,
    field: &Field<'_>,
    wave: &mut Wave,
    high: &mut Wave,
    passage: &mut Passage,
    reached: &mut [f32],
    patches: &mut Patches,
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
        let hit = hits_here(l, field, mask, &ray, &met, coarser.as_mut());
        l.scatter(hit, ray.id, l.mul(met.hit_t, scale), reached);
        if KEEPS {
            passage.keep(l, at, hit, ray.id, &met.patch);
        }
        let going = l.and_not(l.and(mask, l.lt(met.next, ray.leave)), hit);
        [kept, risen] = go_on(l, field, wave, high, [kept, risen], going, &ray, &met, cell);
    }
    wave.truncate(kept);
    high.truncate(risen);
    if KEEPS {
        for at in (0..rays).step_by(LANES) {
            patches.scatter(&passage.ids, &passage.patches, at);
        }
    }
}

/// Which rays meet the ground in their cell. Those that come to where this resolution ends go on to
/// the coarser one.
#[inline(always)]
pub(super) fn hits_here<L: Lanes>(
    l: L,
    field: &Field<'_>,
    mask: L::M,
    ray: &Ray<L>,
    met: &Met<L>,
    coarser: Option<&mut Coarser<'_>>,
) -> L::M {
    let mut hit = l.and(mask, met.hit);
    if let Some(coarser) = coarser {
        let ends = l.and_not(mask, l.lt(met.next, ray.leave));
        if l.bits(ends) != 0 {
            // The last cell of a coarse level may reach out over the ground's border.
            let leave = field.leave(l, ray.inverse, ray.slope);
            hit = l.and_not(hit, l.and(ends, l.lt(leave, met.hit_t)));
            let passes = l.and_not(l.and(ends, l.lt(met.next, leave)), hit);
            coarser.take(l, passes, ray, met.next, leave, None);
        }
    }
    hit
}

/// Writes the rays of `going`, behind the cell that they met, to `low` and `high`, closed up from
/// `ends` on; gives where the next go.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "what rays are made of")]
pub(super) fn go_on<L: Lanes>(
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
    let rate = field.closing_rate(l, ray.slope);
    let up = l.and(going, l.lt(l.mul(rate, l.splat(NEAR)), met.clearance));
    let kept = low.put(l, kept, l.and_not(going, up), ray, met.next, [major, minor]);
    if l.bits(up) == 0 {
        return [kept, risen];
    }
    let level = level_for(l, l.div(met.clearance, rate));
    let risen = high.put_at_level(l, risen, up, ray, met.next, [major, minor], level);
    [kept, risen]
}

/// How rays came through a cell.
pub(super) struct Met<L: Lanes> {
    /// Those that meet the ground in it, and at which t.
    pub(super) hit: L::M,
    pub(super) hit_t: L::F,
    /// The t behind the cell, the clearance there in metres, and whether that is at a line across
    /// the major axis.
    pub(super) next: L::F,
    pub(super) clearance: L::F,
    crosses_major: L::M,
    /// The cell's ground.
    pub(super) patch: Patch<L>,
}

/// Where rays that are at t in a mirrored cell meet the ground in it.
#[inline(always)]
pub(super) fn meet<L: Lanes>(
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
        patch: Patch {
            cell: packed(l, [major, minor]),
            corner,
            by_minor,
            by_major,
            twist,
        },
    }
}
