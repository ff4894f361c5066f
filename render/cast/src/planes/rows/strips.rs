//! Where rays begin among cliffs: by the strips between rays of an earlier step.
//!
//! Where ground is so steep that it might come between a ray and any one before it, two rays tell what one
//! does not: what lies between their planes is straight along the minor axis but for the grid lines there,
//! which they have looked at on their way.

use super::March;
use super::directions::Directions;
use super::left::UNKNOWN;
use super::predecessor::Runs;
use super::scratch::{BLOCK, FARTHEST, MARGIN, MEMORY, Scratch};
use super::set_out::{Begin, Stay, VERY_HIGH};
use crate::lanes::{LANES, Lanes, group, group_mut};
use crate::planes::strips::{NARROW, StripWidths, WIDE};
use crate::planes::wave::{Ray, same_lanes};

/// How many lanes apart the outermost of those rays of an earlier step may lie that are asked for one.
const MOST: f64 = 3.0;

/// Every how many steps, beside the second one, it is looked at whether strips are of use, and at how many groups of
/// rays.
const LOOK: u32 = 8;
const LOOKS: usize = 16;

/// Of fewer lanes it is not looked at.
const LEAST: i32 = 4 * LANES as i32;

/// Cells: ways that are no longer cost rays no more than to keep strips.
const SHORT: f32 = 3.0;

/// Wide strips are kept where narrow ones would spare rays less than this part of their way: to look at three lines
/// and at two blocks takes twice as long as at one.
const LITTLE: f32 = 0.33;

/// From how many of these groups on rays keep their strips; they cease to where there is none.
const MANY: usize = 2;

/// The rays of an earlier step between which those of a group lie, and whose strips have these rays' own strips in
/// them.
#[derive(Clone, Copy)]
struct Enclosing {
    /// Steps back.
    steps: usize,
    /// Lanes aside, from the first to the last.
    lanes: [i32; 2],
    /// By how many metres for each 1 of t the group's rays are higher, at least.
    rise: f64,
}

/// A sector's strips.
#[derive(Clone, Copy, Default)]
pub(super) struct StripsKept {
    /// From which step on rays keep them, where they do.
    from: Option<u32>,
    /// Whether they are looked at where they are wide.
    are_wide: bool,
    /// How wide those of the last steps are at most, in cells along the minor axis for each 1 of t.
    widths: [f32; MEMORY],
}

impl StripsKept {
    pub(super) fn are_kept(&self) -> bool {
        self.from.is_some()
    }

    /// Whether rays keep them that are wide: then a ray's own cell does not tell all that lies in its strip.
    pub(super) fn are_wide(&self) -> bool {
        self.are_kept() && self.are_wide
    }

    /// Whether it is in this step that rays begin to keep them.
    pub(super) fn begin_in(&self, step: u32) -> bool {
        self.from == Some(step)
    }

    /// How wide strips of the last steps are at most.
    pub(super) fn widths(&self) -> StripWidths {
        StripWidths {
            by_t: self.widths.iter().copied().fold(0.0, f32::max),
            most: if self.are_wide { WIDE } else { NARROW },
        }
    }
}

impl<L: Lanes> March<'_, L> {
    /// Begins to keep strips or ceases to, and finds how wide those of a step are where that is of use.
    pub(super) fn look_at_strips(&self, step: u32, scratch: &mut Scratch) {
        let looks = step == 1 || step > 0 && step.is_multiple_of(LOOK);
        if !looks && !scratch.strips.are_kept() {
            return;
        }
        let width = self.strip_width(step, scratch.lanes[step as usize % MEMORY]);
        let kept = &mut scratch.strips;
        if !kept.are_kept() {
            kept.widths = [0.0; MEMORY];
        }
        kept.widths[step as usize % MEMORY] = width;
        if looks {
            let [of_use, far] = self.strips_of_use(step, scratch);
            let kept = &mut scratch.strips;
            // A sector may be one of many pieces: what ceases in none of them begins in each.
            let many = if step == 1 { 1 } else { MANY };
            if kept.from.is_none() && of_use >= many {
                kept.from = Some(step);
                kept.are_wide = false;
                scratch.keeps_patches = false;
            } else if of_use == 0 {
                kept.from = None;
            }
            if kept.from.is_some() && !kept.are_wide && far >= MANY {
                // What is inside strips that have come to be wide has not been looked at so far.
                kept.are_wide = true;
                kept.from = Some(step);
                scratch.keeps_patches = false;
            }
        }
        if width.is_infinite() {
            scratch.strips.from = None;
        }
    }

    /// Of so many groups of a step strips would be of use: rays have none before them to begin from, and would
    /// be spared at least half of their way to where those of the step before came. And of so many of these if
    /// they are wide.
    #[inline(never)]
    fn strips_of_use(&self, step: u32, scratch: &Scratch) -> [usize; 2] {
        let [from, to] = scratch.lanes[step as usize % MEMORY];
        let before = scratch.lanes[(step - 1) as usize % MEMORY];
        let count = to - from;
        if count < LEAST || before[0] >= before[1] {
            return [0; 2];
        }
        let field = &self.fields[0];
        let runs = Runs::<LOOKS>::new(|k| {
            let first = from + (count - 1) * k as i32 / LOOKS as i32;
            let last = to.min(first + LANES as i32) - 1;
            ([first, last], scratch.steepest_around(first))
        });
        // In a sector's second step, too, those count that lie a few steps back: soon there will be such, and to
        // begin to keep strips takes longer than to wait for them.
        let as_of = step.max(MEMORY as u32 - 1);
        let found = self.l.vectorize(
            #[inline(always)]
            || self.predecessors::<LOOKS, 2>(as_of, &runs, MEMORY - 1),
        );
        if found.none() == 0 {
            return [0; 2];
        }
        let narrow = NARROW / scratch.strips.widths().by_t;
        let (mut of_use, mut far) = (0, 0);
        for (k, first) in runs.first.into_iter().enumerate() {
            let d = self.directions.at(step, first);
            let begin = if field.is_above() {
                (f64::from(field.highest - field.eye_height) * d.x / d.z) as f32
            } else {
                self.bounds[0][0].max(0.0)
            };
            let lane = first.clamp(before[0], before[1] - 1);
            let at = self.slot(step - 1) + MARGIN + lane as usize;
            let way = scratch.reached[at].abs() - begin;
            let is_far = narrow - begin < LITTLE * way;
            let limit = if is_far { WIDE * narrow } else { narrow };
            let is_of_use = found.of(k).is_none() && way > SHORT && limit - begin > 0.5 * way;
            of_use += usize::from(is_of_use);
            far += usize::from(is_of_use && is_far);
        }
        [of_use, far]
    }

    /// How wide strips between a step's neighbours are at most: infinitely, where one does not run along the
    /// major axis.
    fn strip_width(&self, step: u32, [from, to]: [i32; 2]) -> f32 {
        let v = self.directions.lane;
        let ends = [from - 1, to].map(|lane| self.directions.at(step, lane));
        let nearest = ends[0].x.min(ends[1].x);
        if nearest <= 0.0 {
            return f32::INFINITY;
        }
        // The same for all lanes.
        let across = (v.y * ends[0].x - v.x * ends[0].y).abs();
        (1.001 * across / (nearest * nearest)) as f32
    }

    /// The nearest step's rays between which those of a group lie from the first to the last of `ends`, and their
    /// strips, and which are not higher.
    fn enclosing(
        &self,
        step: u32,
        towards: [f64; 2],
        ends: [i32; 2],
        scratch: &Scratch,
    ) -> Option<Enclosing> {
        let Directions {
            step: u, lane: v, ..
        } = self.directions;
        let most = step - scratch.strips.from?;
        // The group's own strips reach to the rays beside it.
        let aside =
            [ends[0] - 1, ends[1] + 1].map(|lane| towards[0] + f64::from(lane) * towards[1]);
        let ends = ends.map(|lane| self.directions.at(step, lane));
        for steps in 1..=(MEMORY as u32 - 1).min(most) {
            let back = f64::from(steps);
            let from = (back * aside[0].min(aside[1]) - 1e-6).floor();
            let to = (back * aside[0].max(aside[1]) + 1e-6).ceil();
            if from.abs().max(to.abs()) > FARTHEST || to - from > MOST {
                continue;
            }
            let (mut rise, mut sound) = (f64::INFINITY, true);
            for end in ends {
                for lanes in [from, to] {
                    let way = lanes * v - back * u;
                    let higher = end.z * way.x - way.z * end.x;
                    sound &= higher >= 0.0 && end.x + way.x > 0.0;
                    rise = rise.min(higher / (end.x * (end.x + way.x)));
                }
            }
            if sound {
                return Some(Enclosing {
                    steps: steps as usize,
                    lanes: [from as i32, to as i32],
                    rise,
                });
            }
        }
        None
    }

    /// Where the rays of a group from the first to the last of `ends` begin by those between which they lie.
    #[inline(always)]
    pub(super) fn begin_by_strips(
        &self,
        step: u32,
        towards: [f64; 2],
        ends: [i32; 2],
        ray: &Ray<L>,
        stay: &Stay<L>,
        scratch: &Scratch,
    ) -> Option<Begin<L>> {
        let l = self.l;
        let enclosing = self.enclosing(step, towards, ends, scratch)?;
        let (known, clear) = self.clear_between(step, &enclosing, ends[0], scratch);
        // Where strips become too wide rays may still be high, as where they come over the ground.
        let widest = l.splat(scratch.strips.widths().farthest());
        let fresh = self.fresh_start(ray, stay);
        let follows = l.and(l.lt(clear, widest), l.lt(fresh, clear));
        let start = l.max(l.min(clear, widest), fresh);
        let over = l.mul(start, l.splat(enclosing.rise as f32));
        let over = l.select(follows, over, l.splat(VERY_HIGH));
        Some(Begin { known, start, over })
    }

    /// Which rays of the group that begins at lane `first` lie between some of an earlier step, and up to where they are
    /// clear by these.
    #[inline(always)]
    fn clear_between(
        &self,
        step: u32,
        enclosing: &Enclosing,
        first: i32,
        scratch: &Scratch,
    ) -> (L::M, L::F) {
        let l = self.l;
        let before = step - enclosing.steps as u32;
        let lanes = scratch.lanes[before as usize % MEMORY];
        let [from, to] = enclosing.lanes;
        let known = same_lanes(lanes, first + from) & same_lanes(lanes, first + to);
        let mut clear = l.splat(f32::INFINITY);
        for aside in from..=to {
            let at = (self.slot(before) + MARGIN) as i32 + first + aside;
            let reached = l.load(group(&scratch.reached, at as usize));
            let inside = l.load(group(&scratch.clear, at as usize));
            clear = l.min(clear, l.min(l.abs(reached), inside));
        }
        (l.mask(known), clear)
    }

    /// Writes to the places of a step's rays up to where they are clear by those between which they lie, or [`UNKNOWN`];
    /// and that nothing is known to rise in their own strips.
    #[inline(always)]
    pub(super) fn take_over_between(&self, step: u32, lanes: [i32; 2], scratch: &mut Scratch) {
        let l = self.l;
        let towards = self.towards(step);
        let farthest = l.splat(scratch.strips.widths().farthest());
        for first in (lanes[0]..lanes[1]).step_by(BLOCK) {
            let behind = lanes[1].min(first + BLOCK as i32);
            let of_block = self.enclosing(step, towards, [first, behind - 1], scratch);
            for first in (first..behind).step_by(LANES) {
                let ends = [first, behind.min(first + LANES as i32) - 1];
                let enclosing = match of_block {
                    None => self.enclosing(step, towards, ends, scratch),
                    some => some,
                };
                let clear = match enclosing {
                    Some(enclosing) => {
                        let (known, clear) = self.clear_between(step, &enclosing, first, scratch);
                        l.select(known, l.min(clear, farthest), l.splat(UNKNOWN))
                    }
                    None => l.splat(UNKNOWN),
                };
                let at = self.slot(step) + MARGIN + first as usize;
                l.store(clear, group_mut(&mut scratch.reached, at));
                l.store(l.splat(f32::INFINITY), group_mut(&mut scratch.clear, at));
            }
        }
    }
}
