//! Cell by cell: the exact meeting of rays with the ground's bilinear surface.

use super::climb::{NEAR, level_for};
use super::coarser::Coarser;
use super::fall::Fall;
use super::field::Field;
use super::patches::{NUMBERS, Patch, Patches, packed};
use super::strips::Strips;
use super::wave::{CAPACITY, Column, Ray, Wave};
use crate::lanes::{LANES, Lanes, group, group_mut};

/// What one cell's or block's passage needs between its loops.
// On a page's border, as `Numbers` are.
#[repr(align(4096))]
pub(super) struct Passage {
    pub(super) place: Column<i32>,
    /// How rays come through their cells, until it is known where they meet the ground there: the numbers
    /// of a [`Crossing`].
    crossings: [Column<f32>; 5],
    /// The ground that rays met, and its places among all patches.
    patch_places: Column<i32>,
    patches: [Column<i32>; NUMBERS],
}

impl Default for Passage {
    fn default() -> Self {
        Self {
            place: [0; CAPACITY],
            crossings: [[0.0; CAPACITY]; 5],
            patch_places: [0; CAPACITY],
            patches: [[0; CAPACITY]; NUMBERS],
        }
    }
}

impl Passage {
    #[inline(always)]
    pub(super) fn keep_crossing<L: Lanes>(&mut self, l: L, at: usize, crossing: &Crossing<L>) {
        let Crossing {
            next,
            clearance,
            fall:
                Fall {
                    here,
                    half_rate,
                    bend,
                },
            ..
        } = *crossing;
        let numbers = [next, clearance, here, half_rate, bend];
        for (to, numbers) in self.crossings.iter_mut().zip(numbers) {
            l.store(numbers, group_mut(to, at));
        }
    }

    /// How a group's rays come through their cells, as it was kept.
    #[inline(always)]
    pub(super) fn crossing<L: Lanes>(&self, l: L, at: usize, next_cell: [L::I; 2]) -> Crossing<L> {
        let [next, clearance, here, half_rate, bend] = &self.crossings;
        Crossing {
            next: l.load(group(next, at)),
            next_cell,
            clearance: l.load(group(clearance, at)),
            fall: Fall {
                here: l.load(group(here, at)),
                half_rate: l.load(group(half_rate, at)),
                bend: l.load(group(bend, at)),
            },
        }
    }

    /// Keeps the ground in a group's cells until all have gone their way.
    #[inline(always)]
    fn keep_patch<L: Lanes>(&mut self, l: L, at: usize, patch: &Patch<L>) {
        for (to, bits) in self.patches.iter_mut().zip(patch.bits(l)) {
            l.store_i(bits, group_mut(to, at));
        }
    }

    /// And where that of rays goes that meet it there.
    #[inline(always)]
    fn keep_places<L: Lanes>(&mut self, l: L, at: usize, places: L::I) {
        l.store_i(places, group_mut(&mut self.patch_places, at));
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
pub(super) fn fetch<L: Lanes>(l: L, field: &Field<'_>, passage: &Passage, at: usize) -> [L::F; 4] {
    let place = group(&passage.place, at);
    l.cells(&field.heights.items, place, field.heights.stride)
}

/// Leads each ray of `wave` through its cell. Those that meet the ground write their t to
/// `reached` and, if it `KEEPS` that, the cell's ground to `patches`; where it keeps `STRIPS`, it is noted
/// where ground beside them rises over them; those that leave the ground are
/// dropped; those that end far over it go to `high`, and those that are too far for this resolution
/// to `coarser`.
///
/// Several loops, as each has so little between one group's begin and end that the processor works on
/// several groups at once: above all, none waits for roots and divisions before it knows its way.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "where rays come from and may go")]
pub(super) fn walk<L: Lanes, const KEEPS: bool, const STRIPS: bool>(
    l: L,
    field: &Field<'_>,
    wave: &mut Wave,
    high: &mut Wave,
    passage: &mut Passage,
    reached: &mut [f32],
    patches: &mut Patches,
    mut strips: Strips<'_>,
    coarser: Option<Coarser<'_>>,
) {
    let rays = wave.len();
    let groups = || (0..rays).step_by(LANES);
    l.vectorize(
        #[inline(always)]
        || {
            for at in groups() {
                let mask = l.mask(wave.mask(at));
                place(l, field, mask, wave.cell(l, at), passage, at);
            }
        },
    );
    if field.ahead.is_some() {
        l.vectorize(
            #[inline(always)]
            || {
                for at in groups() {
                    ask(l, field, passage, at);
                }
            },
        );
    }
    let mut ends = Ends {
        field,
        len: [0, high.len()],
        high,
        reached,
        patches,
        coarser,
    };
    l.vectorize(
        #[inline(always)]
        || {
            for at in groups() {
                let (ray, cell) = (wave.ray(l, at), wave.cell(l, at));
                let posts = fetch(l, field, passage, at);
                let t = wave.t(l, at);
                let (crossing, patch) = cross(l, field, &ray, t, cell, posts);
                if KEEPS {
                    passage.keep_patch(l, at, &patch);
                }
                if STRIPS {
                    let mask = l.mask(wave.mask(at));
                    let rises = strips.rises(l, field, mask, &ray, t, cell, &crossing, &patch);
                    strips.end(l, rises, ray.id, t);
                }
                if L::HOLDS_LITTLE {
                    ends.take::<L, KEEPS>(l, wave, passage, at, &crossing);
                } else {
                    wave.set_cell(l, at, crossing.next_cell);
                    passage.keep_crossing(l, at, &crossing);
                }
            }
        },
    );
    if !L::HOLDS_LITTLE {
        l.vectorize(
            #[inline(always)]
            || {
                for at in groups() {
                    let crossing = passage.crossing(l, at, wave.cell(l, at));
                    ends.take::<L, KEEPS>(l, wave, passage, at, &crossing);
                }
            },
        );
    }
    let [kept, risen] = ends.len;
    ends.high.truncate(risen);
    wave.truncate(kept);
    if KEEPS {
        l.vectorize(
            #[inline(always)]
            || {
                for at in groups() {
                    patches.scatter(&passage.patch_places, &passage.patches, at);
                }
            },
        );
    }
}

/// Where a wave's rays go from their cells.
struct Ends<'a, 'b> {
    field: &'a Field<'a>,
    high: &'a mut Wave,
    reached: &'a mut [f32],
    patches: &'a Patches,
    coarser: Option<Coarser<'b>>,
    /// How many rays are low and high behind their cells so far.
    len: [usize; 2],
}

impl Ends<'_, '_> {
    /// Takes the group that begins at ray `at`; those that stay low are closed up in `wave` itself.
    #[inline(always)]
    fn take<L: Lanes, const KEEPS: bool>(
        &mut self,
        l: L,
        wave: &mut Wave,
        passage: &mut Passage,
        at: usize,
        crossing: &Crossing<L>,
    ) {
        let Self { field, len, .. } = *self;
        let mask = l.mask(wave.mask(at));
        let ray = wave.ray(l, at);
        let met = meet(l, wave.t(l, at), crossing);
        let hit = hits_here(l, field, mask, &ray, &met, crossing, self.coarser.as_mut());
        let hit_t = l.mul(met.hit_t, l.splat(field.scale));
        l.scatter(hit, ray.id, hit_t, self.reached);
        if KEEPS {
            let places = self.patches.places(l, hit, ray.id);
            passage.keep_places(l, at, places);
        }
        let going = l.and_not(l.and(mask, l.lt(crossing.next, ray.leave)), hit);
        self.len = go_on(l, field, wave, self.high, len, going, &ray, crossing);
    }
}

/// Which rays meet the ground in their cell. Those that come to where this resolution ends go on to
/// the coarser one, if there is one.
#[inline(always)]
pub(super) fn hits_here<L: Lanes>(
    l: L,
    field: &Field<'_>,
    mask: L::M,
    ray: &Ray<L>,
    met: &Met<L>,
    crossing: &Crossing<L>,
    coarser: Option<&mut Coarser<'_>>,
) -> L::M {
    let mut hit = l.and(mask, met.hit);
    if let Some(coarser) = coarser {
        let ends = l.and_not(mask, l.lt(crossing.next, ray.leave));
        if l.bits(ends) != 0 {
            // The last cell of a coarse level may reach out over the ground's border, the coarsest one's too.
            let leave = field.leave(l, ray.inverse, ray.slope);
            hit = l.and_not(hit, l.and(ends, l.lt(leave, met.hit_t)));
            let passes = l.and_not(l.and(ends, l.lt(crossing.next, leave)), hit);
            coarser.take(l, passes, ray, crossing.next, leave, None);
        }
    }
    hit
}

/// Writes the rays of `going`, behind the cell that they cross, to `low` and `high`, closed up from
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
    crossing: &Crossing<L>,
) -> [usize; 2] {
    let Crossing {
        next,
        clearance,
        next_cell: cell,
        ..
    } = *crossing;
    let rate = field.closing_rate(l, ray.slope);
    let up = l.and(going, l.lt(l.mul(rate, l.splat(NEAR)), clearance));
    let stays = l.and_not(going, up);
    let kept = low.close_up(l, kept, stays, ray, next, cell);
    if l.bits(up) == 0 {
        return [kept, risen];
    }
    let level = level_for(l, l.div(clearance, rate));
    let risen = high.put_at_level(l, risen, up, ray, next, cell, level);
    [kept, risen]
}

/// How rays come through their cells.
pub(super) struct Crossing<L: Lanes> {
    /// The t behind the cell, the clearance there in metres, and the mirrored cell.
    pub(super) next: L::F,
    pub(super) clearance: L::F,
    pub(super) next_cell: [L::I; 2],
    /// The clearance over the way between, from 0 to 1.
    fall: Fall<L>,
}

/// Where rays meet the ground in their cells.
pub(super) struct Met<L: Lanes> {
    /// Those that do, and at which t.
    pub(super) hit: L::M,
    pub(super) hit_t: L::F,
}

/// How rays that are at t come through a mirrored cell with `posts`, and the cell's ground.
#[inline(always)]
pub(super) fn cross<L: Lanes>(
    l: L,
    field: &Field<'_>,
    ray: &Ray<L>,
    t: L::F,
    [major, minor]: [L::I; 2],
    posts: [L::F; 4],
) -> (Crossing<L>, Patch<L>) {
    let zero = l.splat(0.0);
    let major_line = l.splat(1.0 - field.major.fraction);
    let minor_line = l.splat(1.0 - field.minor.fraction);
    // Where the lines behind the cell lie.
    let to_major = l.add(l.to_float(major), major_line);
    let to_minor = l.add(l.to_float(minor), minor_line);
    let patch = patch(l, field, packed(l, [major, minor]), posts);
    let Patch {
        corner,
        by_minor,
        by_major,
        twist,
        ..
    } = patch;
    // The clearance at t. Far away t is rounded by so much that a ray may stand before the line over which it
    // came into the cell; a cliff that goes down behind that line would be as much higher there.
    let one = l.splat(1.0);
    let major_left = l.min(l.sub(to_major, t), one);
    let minor_left = l.min(l.sub(to_minor, l.mul(t, ray.advance)), one);
    let falls_minor = l.add(by_major, l.mul(twist, major_left));
    let height = l.add(l.mul(by_minor, major_left), l.mul(minor_left, falls_minor));
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
    let length = l.sub(next, t);
    let bend = l.mul(l.mul(twist, ray.advance), l.mul(length, length));
    let here = l.max(clearance, zero);
    let half_rate = l.mul(l.add(l.sub(next_clearance, here), bend), l.splat(0.5));
    let one = l.splat_i(1);
    let crossing = Crossing {
        next,
        clearance: next_clearance,
        next_cell: [
            l.add_i_where(crosses_major, major, one),
            l.add_i(minor, l.select_i(crosses_major, l.splat_i(0), one)),
        ],
        fall: Fall {
            here,
            half_rate,
            bend,
        },
    };
    (crossing, patch)
}

/// The ground in mirrored cells with names and `posts`.
#[inline(always)]
pub(super) fn patch<L: Lanes>(l: L, field: &Field<'_>, cell: L::I, posts: [L::F; 4]) -> Patch<L> {
    let eye = l.splat(field.eye_height);
    let eye_rest = l.splat(field.eye_rest);
    let [near, far_major, far_minor, both] = corners::<L>(field, posts);
    let by_minor = l.sub(far_minor, both);
    let by_major = l.sub(far_major, both);
    let by_none = l.sub(near, both);
    Patch {
        cell,
        // As near to the truth as if it had more digits.
        corner: l.sub(l.sub(both, eye), eye_rest),
        by_minor,
        by_major,
        twist: l.sub(l.sub(by_none, by_major), by_minor),
    }
}

/// Where rays that are at t in a cell meet the ground in it.
#[inline(always)]
pub(super) fn meet<L: Lanes>(l: L, t: L::F, crossing: &Crossing<L>) -> Met<L> {
    // What is missed at the end of a cell, as it is rounded, is below the ground in the next one.
    let share = crossing.fall.first_zero(l);
    Met {
        hit: l.le(share, l.splat(1.0)),
        hit_t: l.add(t, l.mul(share, l.sub(crossing.next, t))),
    }
}
