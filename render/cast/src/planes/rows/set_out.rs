//! A step's rays set out: where they begin, and in which wave.

use super::March;
use super::directions::{Aim, Aimed};
use super::look_back::Before;
use super::scratch::{MARGIN, MEMORY, Scratch};
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes, group, group_mut};
use crate::planes::climb::{FAR, NEAR, level_for};
use crate::planes::depart::{Departing, Departure};
use crate::planes::wave::{Ray, Waves, first_lanes, same_lanes};

/// Rays of a group that set out low from which on they go through their first cell as they are, not
/// closed up with others.
const MANY: u32 = 8;

/// Times the t where a ray comes over the ground: surely behind it, however that is rounded; and as much more for
/// each cell along the major axis in which it goes one along the minor one, as hardly slanted rays' slants are
/// rounded beside those of their neighbours.
const BEHIND: f32 = 1.00001;
const SLANTED: f32 = 1e-6;

/// How high over the ground rays are taken to be that begin where no ray was before, in metres: more
/// than any are, and few enough to be divided by what is small.
pub(super) const VERY_HIGH: f32 = 1e30;

/// Up to where rays are clear that come over the ground at `enter`, if those before them came as far as `reached`
/// and they are clear for `further` times that beyond it; `inverse` as a [`Ray`] has it.
///
/// That holds for those that came over the ground before: else the ray before may have met the ground's side, and
/// knows of no ground below it.
#[inline(always)]
pub(super) fn further_on<L: Lanes>(
    l: L,
    reached: L::F,
    further: f32,
    enter: L::F,
    inverse: L::F,
) -> L::F {
    let behind = l.add(l.splat(BEHIND), l.mul(inverse, l.splat(SLANTED)));
    // No number where an eye over the ground looks along the major axis.
    let comes = l.le(reached, l.mul(enter, behind));
    let clear = l.mul(reached, l.splat(1.0 + further));
    l.select(comes, l.max(reached, enter), clear)
}

/// Where sixteen rays are over the ground.
pub(super) struct Stay<L: Lanes> {
    /// Those that are over it at all, or may come down to it.
    pub(super) ok: L::M,
    pub(super) enter: L::F,
    pub(super) leave: L::F,
}

/// Where sixteen rays begin by those of an earlier step.
pub(super) struct Begin<L: Lanes> {
    /// Those that know it.
    pub(super) known: L::M,
    /// Up to where they are clear, and about how many metres they are over the ground there.
    pub(super) start: L::F,
    pub(super) over: L::F,
}

impl<L: Lanes> Stay<L> {
    /// What rays have reached until something is found: they have left the ground.
    #[inline(always)]
    pub(super) fn nothing(&self, l: L) -> L::F {
        // Below 0 even where there is no ground at all.
        l.sub(l.splat(0.0), l.max(self.leave, l.splat(f32::MIN_POSITIVE)))
    }
}

impl<L: Lanes> March<'_, L> {
    /// Sets up the rays of a step and finds where they begin; parks those that begin high.
    ///
    /// Whether strips are kept is known where it is compiled: rays that keep none have all registers for themselves.
    pub(super) fn set_out<const KEEPS_STRIPS: bool>(
        &self,
        step: u32,
        lanes: [i32; 2],
        from: &Before,
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
    ) {
        let l = self.l;
        l.vectorize(
            #[inline(always)]
            || {
                let one = l.splat(1.0);
                let aim = Aim::new(l, self.frame, self.directions.lane);
                let across = self.across(step);
                let oblong = l.splat(self.oblong as f32);
                let slot = self.slot(step);
                let asked = scratch.pixels.asked(canvas, self.sector, step);
                for first in (lanes[0]..lanes[1]).step_by(LANES) {
                    let at = slot + MARGIN + first as usize;
                    let count = (lanes[1] - first).min(LANES as i32);
                    let all = l.mask(first_lanes(count));
                    // A few lines a group, long before they are written: many at once are waited for.
                    asked.prefetch(l, canvas, first);
                    let Aimed {
                        advance,
                        inverse,
                        slope,
                        scale,
                    } = aim.at(l, self.directions.at(step, first));
                    let stay = self.stay(all, inverse, slope);
                    l.store(advance, group_mut(&mut scratch.advance, at));
                    l.store(slope, group_mut(&mut scratch.slope, at));
                    l.store(stay.nothing(l), group_mut(&mut scratch.reached, at));
                    let in_chunk = (first - lanes[0]) as usize;
                    if KEEPS_STRIPS {
                        l.store(l.splat(f32::INFINITY), group_mut(&mut scratch.clear, at));
                    }
                    scratch.departure.clear(in_chunk, at);
                    let ray = Ray {
                        advance,
                        inverse,
                        slope,
                        leave: stay.leave,
                        id: self.ids(at),
                    };
                    // How many cells, of the longer of their sides, a pixel covers across its ray for each 1 of t.
                    let mut width = None;
                    if let Some(across) = across {
                        let turned = l.mul(oblong, advance);
                        let turned = l.sqrt(l.add(one, l.mul(turned, turned)));
                        width = Some(l.div(l.mul(l.splat(across), l.mul(scale, scale)), turned));
                    }
                    // Which rays know from an earlier step up to where they are clear, and about how high they are over the
                    // ground there.
                    let begin = if KEEPS_STRIPS {
                        let ends = [first, first + count - 1];
                        self.begin_by_strips(step, self.towards(step), ends, &ray, &stay, scratch)
                    } else {
                        match from.block(in_chunk).or(from.group(in_chunk)) {
                            Some(before) => {
                                let before_step = step - before.steps.get();
                                let before_lanes = scratch.lanes[before_step as usize % MEMORY];
                                // Those whose predecessors are the sector's.
                                let known = l.mask(same_lanes(before_lanes, first + before.lanes));
                                let before_at =
                                    (self.slot(before_step) + MARGIN) as i32 + first + before.lanes;
                                let start =
                                    l.abs(l.load(group(&scratch.reached, before_at as usize)));
                                let further = before.further;
                                let start = further_on(l, start, further, stay.enter, inverse);
                                let falls = l.mul(l.min(slope, l.splat(0.0)), l.splat(further));
                                let over = l.mul(start, l.add(l.splat(before.rise), falls));
                                Some(Begin { known, start, over })
                            }
                            None => None,
                        }
                    };
                    let mut fresh = stay.ok;
                    if let Some(Begin { known, start, over }) = begin {
                        let known = l.and(known, stay.ok);
                        fresh = l.and_not(stay.ok, known);
                        let known = l.and(known, l.lt(start, stay.leave));
                        let waves = &mut scratch.waves[..self.fields.len()];
                        let departure = &mut scratch.departure;
                        self.send(waves, departure, in_chunk, known, &ray, start, over, width);
                    }
                    if l.bits(fresh) != 0 {
                        let start = self.fresh_start(&ray, &stay);
                        let fresh = l.and(fresh, l.lt(start, stay.leave));
                        let waves = &mut scratch.waves[..self.fields.len()];
                        let (departure, over) = (&mut scratch.departure, l.splat(VERY_HIGH));
                        self.send(waves, departure, in_chunk, fresh, &ray, start, over, width);
                    }
                }
            },
        );
    }

    /// The numbers of the group that begins at number `at` among all that are kept of steps.
    #[inline(always)]
    pub(super) fn ids(&self, at: usize) -> L::I {
        let l = self.l;
        let lane_numbers = l.load_i(&std::array::from_fn(|k| k as i32));
        l.add_i(lane_numbers, l.splat_i(at as i32))
    }

    /// Where detail is chosen, by how much the minor part of a step's rays changes from one to the next, over their
    /// major part's square.
    #[inline(always)]
    pub(super) fn across(&self, step: u32) -> Option<f32> {
        let detail = self.frame.detail.as_ref();
        detail.filter(|_| self.frame.coarsens).map(|detail| {
            let (d, v) = (self.directions.at(step, 0), self.directions.lane);
            let across = f64::from(detail.cell) * (v.y * d.x - v.x * d.y).abs();
            (self.oblong.min(1.0) * across) as f32
        })
    }

    /// Where rays of `all` are over the ground.
    #[inline(always)]
    pub(super) fn stay(&self, all: L::M, inverse: L::F, slope: L::F) -> Stay<L> {
        let l = self.l;
        let zero = l.splat(0.0);
        let [[major_begin, major_end], [minor_begin, minor_end]] = self.bounds;
        let field = &self.fields[0];
        let mut leave = l.min(l.splat(major_end), l.mul(l.splat(minor_end), inverse));
        let mut ok = l.and(all, l.lt(zero, leave));
        if field.is_above() {
            ok = l.and(ok, l.lt(slope, zero));
        } else if l.bits(l.lt(zero, slope)) != 0 {
            let over = l.div(l.splat(field.highest - field.eye_height), slope);
            leave = l.select(l.lt(zero, slope), l.min(leave, over), leave);
        }
        let mut enter = l.splat(major_begin.max(0.0));
        if minor_begin > 0.0 {
            enter = l.max(enter, l.mul(l.splat(minor_begin), inverse));
        }
        if major_begin > 0.0 || minor_begin > 0.0 {
            // Straight down beside the ground there is none, however deep; which tells nothing of other rays.
            let leans = l.lt(l.splat(self.straight_down), slope);
            leave = l.select(leans, leave, zero);
        }
        ok = l.and(ok, l.lt(enter, leave));
        Stay { ok, enter, leave }
    }

    /// Where rays come over the ground, or down to where some may be.
    #[inline(always)]
    pub(super) fn fresh_start(&self, ray: &Ray<L>, stay: &Stay<L>) -> L::F {
        let l = self.l;
        let field = &self.fields[0];
        if field.is_above() {
            let down = l.div(l.splat(field.highest - field.eye_height), ray.slope);
            l.max(stay.enter, down)
        } else {
            stay.enter
        }
    }

    /// Puts rays of `mask` on their way from where they come over the ground, closed up with others.
    #[inline(always)]
    pub(super) fn begin_fresh(
        &self,
        scratch: &mut Scratch,
        mask: L::M,
        ray: &Ray<L>,
        stay: &Stay<L>,
    ) {
        let l = self.l;
        let start = self.fresh_start(ray, stay);
        let mask = l.and(mask, l.lt(start, stay.leave));
        let cell = self.fields[0].cell_at(l, start, ray.advance);
        let level = level_for(l, l.splat(VERY_HIGH));
        let high = &mut scratch.waves[0].high;
        high.push_at_level(l, mask, ray, start, cell, level);
    }

    /// Puts rays on their way that are clear up to `start` and, about, `over` metres over the ground
    /// there: those of the group that begins at lane `at` of a chunk. Where detail is chosen, a
    /// pixel covers `width` cells across its ray for each 1 of t.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "where rays come from and may go")]
    fn send(
        &self,
        waves: &mut [Waves],
        departure: &mut Departure,
        at: usize,
        mask: L::M,
        ray: &Ray<L>,
        start: L::F,
        over: L::F,
        width: Option<L::F>,
    ) {
        let l = self.l;
        let Some(width) = width else {
            self.send_over(0, waves, departure, at, mask, ray, start, over);
            return;
        };
        let coarsest = self.fields.len() as i32 - 1;
        // Finer levels than the ground's own have the same surface in smaller cells.
        let covered = l.max(l.mul(start, width), l.splat(self.fields[self.native].scale));
        let level = l.min_i(l.exponent(covered), l.splat_i(coarsest));
        let mut levels = [0; LANES];
        l.store_i(level, &mut levels);
        // Where a pixel comes to cover two cells: as far away, in cells, at all resolutions.
        let limit = l.div(l.splat(2.0), width);
        let mut left = l.bits(mask);
        while left != 0 {
            let number = levels[left.trailing_zeros() as usize];
            let these = l.and(l.mask(left), l.eq_i(level, l.splat_i(number)));
            left &= !l.bits(these);
            let field = &self.fields[number as usize];
            let (scale, inverse_scale) = (l.splat(field.scale), l.splat(1.0 / field.scale));
            let t = l.mul(start, inverse_scale);
            let leave = l.min(l.mul(ray.leave, inverse_scale), field.end(l, ray.inverse));
            let ray = Ray {
                slope: l.mul(ray.slope, scale),
                leave: if number < coarsest {
                    l.min(leave, limit)
                } else {
                    leave
                },
                ..*ray
            };
            self.send_over(number as usize, waves, departure, at, these, &ray, t, over);
        }
    }

    /// As `send`, over the resolution with a number; `ray` and `t` are that resolution's.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "as `send` has")]
    fn send_over(
        &self,
        level: usize,
        waves: &mut [Waves],
        departure: &mut Departure,
        at: usize,
        mask: L::M,
        ray: &Ray<L>,
        t: L::F,
        over: L::F,
    ) {
        let l = self.l;
        let (field, waves) = (&self.fields[level], &mut waves[level]);
        let cell = field.cell_at(l, t, ray.advance);
        let rate = field.closing_rate(l, ray.slope);
        let far = l.and(mask, l.lt(l.mul(rate, l.splat(FAR)), over));
        let mask = l.and_not(mask, far);
        if l.bits(mask).count_ones() >= MANY && departure.is_free(at) {
            let high = l.and(mask, l.lt(l.mul(rate, l.splat(NEAR)), over));
            let rays = Departing {
                level,
                mask,
                high,
                t,
                cell,
            };
            departure.put(l, at, ray, &rays);
        } else if l.bits(mask) != 0 {
            waves.low.push(l, mask, ray, t, cell);
        }
        if l.bits(far) != 0 {
            let blocks = level_for(l, l.div(over, rate));
            waves.high.push_at_level(l, far, ray, t, cell, blocks);
        }
    }
}
