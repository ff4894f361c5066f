//! A step's rays set out: most end in their first cell, so they go there side by side, as they are,
//! and only those that go on are closed up into waves.

use super::climb::{self, approach, rises_far};
use super::coarser::Coarser;
use super::field::Field;
use super::patches::Patches;
use super::roofs::FINEST;
use super::strips::{StripWidths, Strips};
use super::walk::{Crossing, Passage, ask, cross, fetch, go_on, hits_here, meet, place};
use super::wave::{CHUNK, Ray, Waves};
use crate::lanes::{LANES, Lanes, group, group_mut};

/// Rays that set out, a number a lane.
// On a page's border, as `Numbers` are.
#[repr(align(4096))]
pub(super) struct Departure {
    inverse: [f32; CHUNK],
    leave: [f32; CHUNK],
    t: [f32; CHUNK],
    major: [i32; CHUNK],
    minor: [i32; CHUNK],
    /// For each group, where its first lane lies among all numbers that are kept of steps; the number
    /// of the resolution that its rays are in; which of them set out here; and which of those are
    /// led to the roofs of their blocks first.
    firsts: [u32; CHUNK / LANES],
    levels: [u16; CHUNK / LANES],
    masks: [u16; CHUNK / LANES],
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
            firsts: [0; CHUNK / LANES],
            levels: [0; CHUNK / LANES],
            masks: [0; CHUNK / LANES],
            high: [0; CHUNK / LANES],
        }
    }
}

/// Rays of a group that may set out together.
pub(super) struct Departing<L: Lanes> {
    /// The number of the resolution that they are in.
    pub(super) level: usize,
    pub(super) mask: L::M,
    /// Those of them that are led to the roofs of their blocks first.
    pub(super) high: L::M,
    /// Where they are, and their mirrored cells there.
    pub(super) t: L::F,
    pub(super) cell: [L::I; 2],
}

impl Departure {
    /// Forgets the rays of the group that begins at lane `at`, which lies at `first` among all numbers
    /// that are kept of steps.
    #[inline(always)]
    pub(super) fn clear(&mut self, at: usize, first: usize) {
        self.firsts[at / LANES] = first as u32;
        self.masks[at / LANES] = 0;
        self.high[at / LANES] = 0;
    }

    /// Whether the group that begins at lane `at` has no rays yet.
    #[inline(always)]
    pub(super) fn is_free(&self, at: usize) -> bool {
        self.masks[at / LANES] == 0
    }

    /// For each group of the first `count` lanes, where its first one lies, and those led to roofs
    /// and those led through cells, once all have set out.
    #[inline(always)]
    pub(super) fn led(&self, count: usize) -> impl Iterator<Item = (u32, [u16; 2])> {
        let groups = self.high.iter().zip(&self.masks).zip(&self.firsts);
        groups
            .take(count.div_ceil(LANES))
            .map(|((&high, &low), &first)| (first, [high, low]))
    }

    /// Takes `rays` as the group that begins at lane `at`.
    #[inline(always)]
    pub(super) fn put<L: Lanes>(&mut self, l: L, at: usize, ray: &Ray<L>, rays: &Departing<L>) {
        self.levels[at / LANES] = rays.level as u16;
        self.masks[at / LANES] = l.bits(rays.mask);
        self.high[at / LANES] = l.bits(rays.high);
        l.store(ray.inverse, group_mut(&mut self.inverse, at));
        l.store(ray.leave, group_mut(&mut self.leave, at));
        l.store(rays.t, group_mut(&mut self.t, at));
        self.put_cell(l, at, rays.cell);
    }

    #[inline(always)]
    fn put_cell<L: Lanes>(&mut self, l: L, at: usize, [major, minor]: [L::I; 2]) {
        l.store_i(major, group_mut(&mut self.major, at));
        l.store_i(minor, group_mut(&mut self.minor, at));
    }

    #[inline(always)]
    fn cell<L: Lanes>(&self, l: L, at: usize) -> [L::I; 2] {
        [
            l.load_i(group(&self.major, at)),
            l.load_i(group(&self.minor, at)),
        ]
    }
}

/// Lanes that set out together, and all numbers that are kept of steps.
pub(super) struct Step<'a> {
    /// How many lanes there are.
    pub(super) count: usize,
    pub(super) advance: &'a [f32],
    pub(super) slope: &'a [f32],
}

impl Step<'_> {
    /// The rays of a group, over the ground as `field` has it.
    #[inline(always)]
    fn ray<L: Lanes>(&self, l: L, field: &Field<'_>, departure: &Departure, at: usize) -> Ray<L> {
        let id = departure.firsts[at / LANES] as usize;
        let numbers = l.load_i(&std::array::from_fn(|k| k as i32));
        Ray {
            advance: l.load(group(self.advance, id)),
            inverse: l.load(group(&departure.inverse, at)),
            slope: l.mul(l.load(group(self.slope, id)), l.splat(field.scale)),
            leave: l.load(group(&departure.leave, at)),
            id: l.add_i(numbers, l.splat_i(id as i32)),
        }
    }
}

/// Leads the rays of a step that set out to the roofs of their blocks and through their first
/// cells, as [`climb`](super::climb::climb) and [`walk`](super::walk::walk) do: over `fields`, the
/// ground at all of its resolutions. Those that go on join `waves`.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "where rays come from and may go")]
pub(super) fn depart<L: Lanes, const KEEPS: bool, const STRIPS: bool>(
    l: L,
    fields: &[Field<'_>],
    departure: &mut Departure,
    step: &Step<'_>,
    waves: &mut [Waves],
    passage: &mut Passage,
    reached: &mut [f32],
    patches: &mut Patches,
    strips: Strips<'_>,
) {
    let groups = || (0..step.count).step_by(LANES);
    if groups().any(|at| departure.high[at / LANES] != 0) {
        l.vectorize(
            #[inline(always)]
            || {
                let widths = strips.widths;
                lead_to_roofs::<L, STRIPS>(l, fields, departure, step, waves, passage, widths);
            },
        );
    }
    l.vectorize(
        #[inline(always)]
        || {
            for at in groups() {
                let mask = departure.masks[at / LANES];
                if mask != 0 {
                    let field = &fields[departure.levels[at / LANES] as usize];
                    let cell = departure.cell(l, at);
                    place(l, field, l.mask(mask), cell, passage, at);
                }
            }
        },
    );
    if are_far(fields) {
        l.vectorize(
            #[inline(always)]
            || {
                for at in groups() {
                    if departure.masks[at / LANES] != 0 {
                        let field = &fields[departure.levels[at / LANES] as usize];
                        ask(l, field, passage, at);
                    }
                }
            },
        );
    }
    lead_through_cells::<L, KEEPS, STRIPS>(
        l, fields, departure, step, waves, passage, reached, patches, strips,
    );
}

/// Whether any resolution's memory may be far, so that it is asked for.
fn are_far(fields: &[Field<'_>]) -> bool {
    fields.iter().any(|field| field.ahead.is_some())
}

/// Leads rays to the roofs of their blocks; those that pass over them join waves.
#[inline(always)]
fn lead_to_roofs<L: Lanes, const STRIPS: bool>(
    l: L,
    fields: &[Field<'_>],
    departure: &mut Departure,
    step: &Step<'_>,
    waves: &mut [Waves],
    passage: &mut Passage,
    widths: StripWidths,
) {
    let finest = l.splat_i(FINEST as i32);
    let groups = || (0..step.count).step_by(LANES);
    for at in groups() {
        let high = departure.high[at / LANES];
        if high != 0 {
            let field = &fields[departure.levels[at / LANES] as usize];
            let place = climb::place(l, field, l.mask(high), departure.cell(l, at), finest);
            l.store_i(place, group_mut(&mut passage.place, at));
        }
    }
    if are_far(fields) {
        for at in groups() {
            if departure.high[at / LANES] != 0 {
                let field = &fields[departure.levels[at / LANES] as usize];
                climb::ask(l, field, passage, at);
            }
        }
    }
    for at in groups() {
        let high = departure.high[at / LANES];
        if high == 0 {
            continue;
        }
        let level = departure.levels[at / LANES] as usize;
        let field = &fields[level];
        let ray = step.ray(l, field, departure, at);
        let (t, cell) = (l.load(group(&departure.t, at)), departure.cell(l, at));
        let place = group(&passage.place, at);
        let mask = l.mask(high);
        let to = approach::<L, STRIPS>(l, field, mask, &ray, t, cell, finest, place, widths);
        let t = l.select(mask, to.t, t);
        let cell = [
            l.select_i(mask, to.cell[0], cell[0]),
            l.select_i(mask, to.cell[1], cell[1]),
        ];
        l.store(t, group_mut(&mut departure.t, at));
        departure.put_cell(l, at, cell);
        let left = l.and_not(mask, l.lt(t, ray.leave));
        let past = l.and_not(l.and(mask, to.clear), left);
        departure.masks[at / LANES] &= !l.bits(l.or(past, left));
        let (waves, behind) = waves[level..].split_at_mut(1);
        if l.bits(left) != 0
            && let Some(mut coarser) = Coarser::behind(fields, level, behind)
        {
            let leave = field.leave(l, ray.inverse, ray.slope);
            let passes = l.and(left, l.lt(t, leave));
            coarser.take(l, passes, &ray, t, leave, Some(finest));
        }
        if l.bits(past) != 0 {
            let far = rises_far(l, field, &ray, &to, finest);
            let level = l.add_i_where(far, finest, l.splat_i(1));
            waves[0].high.push_at_level(l, past, &ray, t, cell, level);
        }
    }
}

/// Leads rays through their cells; those that go on join waves.
///
/// Two loops, as [`walk`](super::walk::walk) has.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "as `depart` has")]
fn lead_through_cells<L: Lanes, const KEEPS: bool, const STRIPS: bool>(
    l: L,
    fields: &[Field<'_>],
    departure: &mut Departure,
    step: &Step<'_>,
    waves: &mut [Waves],
    passage: &mut Passage,
    reached: &mut [f32],
    patches: &mut Patches,
    mut strips: Strips<'_>,
) {
    let groups = || (0..step.count).step_by(LANES);
    l.vectorize(
        #[inline(always)]
        || {
            for at in groups() {
                if departure.masks[at / LANES] == 0 {
                    continue;
                }
                let field = &fields[departure.levels[at / LANES] as usize];
                let ray = step.ray(l, field, departure, at);
                let (t, cell) = (l.load(group(&departure.t, at)), departure.cell(l, at));
                let posts = fetch(l, field, passage, at);
                let (crossing, patch) = cross(l, field, &ray, t, cell, posts);
                if KEEPS {
                    patches.store(l, departure.firsts[at / LANES] as usize, &patch);
                }
                if STRIPS {
                    let mask = l.mask(departure.masks[at / LANES]);
                    let rises = strips.rises(l, field, mask, &ray, t, cell, &crossing, &patch);
                    strips.end_first(l, rises, departure.firsts[at / LANES] as usize, t);
                }
                if L::HOLDS_LITTLE {
                    end::<L, KEEPS>(
                        l, fields, departure, step, waves, at, &crossing, reached, patches,
                    );
                } else {
                    departure.put_cell(l, at, crossing.next_cell);
                    passage.keep_crossing(l, at, &crossing);
                }
            }
        },
    );
    if L::HOLDS_LITTLE {
        return;
    }
    l.vectorize(
        #[inline(always)]
        || {
            for at in groups() {
                if departure.masks[at / LANES] != 0 {
                    let crossing = passage.crossing(l, at, departure.cell(l, at));
                    end::<L, KEEPS>(
                        l, fields, departure, step, waves, at, &crossing, reached, patches,
                    );
                }
            }
        },
    );
}

/// Ends the way through their cells of the group's rays that begins at lane `at`.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "as `depart` has")]
fn end<L: Lanes, const KEEPS: bool>(
    l: L,
    fields: &[Field<'_>],
    departure: &Departure,
    step: &Step<'_>,
    waves: &mut [Waves],
    at: usize,
    crossing: &Crossing<L>,
    reached: &mut [f32],
    patches: &mut Patches,
) {
    let number = at / LANES;
    let mask = l.mask(departure.masks[number]);
    let level = departure.levels[number] as usize;
    let first = departure.firsts[number] as usize;
    let field = &fields[level];
    let (waves, behind) = waves[level..].split_at_mut(1);
    let Waves { low, high } = &mut waves[0];
    let mut coarser = Coarser::behind(fields, level, behind);
    let ray = step.ray(l, field, departure, at);
    let met = meet(l, l.load(group(&departure.t, at)), crossing);
    let hit = hits_here(l, field, mask, &ray, &met, crossing, coarser.as_mut());
    if KEEPS {
        // Those that go on write theirs later.
        patches.keep_cells(l, first, hit);
    }
    let reached = group_mut(reached, first);
    let hit_t = l.mul(met.hit_t, l.splat(field.scale));
    l.store_where(hit, hit_t, reached);
    let going = l.and_not(l.and(mask, l.lt(crossing.next, ray.leave)), hit);
    if l.bits(going) == 0 {
        return;
    }
    let ends = [low.len(), high.len()];
    let [kept, risen] = go_on(l, field, low, high, ends, going, &ray, crossing);
    low.truncate(kept);
    high.truncate(risen);
}
