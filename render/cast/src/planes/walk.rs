//! Cell by cell: the exact meeting of rays with the ground's bilinear surface.

use super::climb::level_for;
use super::coarser::Coarser;
use super::field::Field;
use super::wave::{CAPACITY, Column, Wave, group, group_mut};
use crate::lanes::{LANES, Lanes};

/// What one cell's passage needs between its loops.
#[repr(align(64))]
pub(super) struct Passage {
    posts: [Column<f32>; 4],
}

impl Default for Passage {
    fn default() -> Self {
        Self {
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

/// Leads each ray of `wave` through its cell. Those that meet the ground write their t to
/// `reached`; those that leave the ground are dropped; those that end far over it go to `high`,
/// and those that are too far for this resolution to `coarser`.
///
/// Two loops, as each has so little between one group's begin and end that the processor works on
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
                let heights = field.heights;
                let place = field.place(l, wave.cell(l, at));
                let place = heights.only(l, l.mask(wave.mask(at)), place);
                let posts = l.cells(&heights.items, place, heights.stride);
                for (to, posts) in passage.posts.iter_mut().zip(posts) {
                    l.store(posts, group_mut(to, at));
                }
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
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let one_cell = l.splat_i(1);
    let major_line = l.splat(1.0 - field.major.fraction);
    let minor_line = l.splat(1.0 - field.minor.fraction);
    let eye = l.splat(field.eye_height);
    let eye_rest = l.splat(field.eye_rest);
    let near_limit = l.splat(field.near);
    let inverse_near = l.splat(1.0 / field.near);
    let scale = l.splat(field.scale);
    let rays = wave.len();
    let (mut kept, mut risen) = (0, high.len());
    for at in (0..rays).step_by(LANES) {
        let mask = l.mask(wave.mask(at));
        let ray = wave.ray(l, at);
        let t = wave.t(l, at);
        let [major, minor] = wave.cell(l, at);
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
        let mut hit = l.and(mask, l.or(below, dips));
        let share = l.min(l.div(twice, l.max(divisor, l.splat(1e-30))), one);
        let hit_t = l.add(t, l.mul(share, length));
        if let Some(coarser) = &mut coarser {
            let ends = l.and_not(mask, l.lt(next, ray.leave));
            if l.bits(ends) != 0 {
                // The last cell of a coarse level may reach out over the ground's border.
                let leave = field.leave(l, ray.inverse, ray.slope);
                hit = l.and_not(hit, l.and(ends, l.lt(leave, hit_t)));
                let passes = l.and_not(l.and(ends, l.lt(next, leave)), hit);
                coarser.take(l, passes, &ray, next, leave, None);
            }
        }
        l.scatter(hit, ray.id, l.mul(hit_t, scale), reached);
        let going = l.and_not(l.and(mask, l.lt(next, ray.leave)), hit);
        let major = l.add_i_where(crosses_major, major, one_cell);
        let minor = l.add_i_where(l.and_not(going, crosses_major), minor, one_cell);
        let up = l.and(going, l.lt(near_limit, next_clearance));
        kept = wave.put(l, kept, l.and_not(going, up), &ray, next, [major, minor]);
        if l.bits(up) != 0 {
            let level = level_for(l, l.mul(next_clearance, inverse_near));
            risen = high.put_at_level(l, risen, up, &ray, next, [major, minor], level);
        }
    }
    wave.truncate(kept);
    high.truncate(risen);
}
