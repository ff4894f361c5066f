//! Where rays begin among cliffs: by the strips between rays of an earlier step.
//!
//! Where ground is so steep that it might come between a ray and any one before it, two rays tell what one
//! does not: what lies between their planes is straight along the minor axis but for the grid lines there,
//! which they have looked at on their way.

use super::March;
use super::directions::Directions;
use super::scratch::{FARTHEST, MARGIN, MEMORY, Scratch};
use super::set_out::{Begin, Stay, VERY_HIGH, same_lanes};
use crate::lanes::{LANES, Lanes, group};
use crate::planes::wave::Ray;

/// How many cells wide strips may be: wider ones may have several grid lines inside.
const WIDEST: f32 = 1.0;

/// So many rays of an earlier step may be asked for one.
const MOST: f64 = 4.0;

/// Every how many steps it is looked at whether strips are of use, and at how many groups of rays.
const LOOK: u32 = 8;
const LOOKS: i32 = 16;

/// Of fewer lanes it is not looked at.
const LEAST: i32 = 4 * LANES as i32;

/// Cells: ways that are no longer cost rays little.
const SHORT: f32 = 16.0;

/// From how many of these groups on rays keep their strips, and up to how many they cease to.
const MANY: i32 = 2;
const FEW: i32 = 0;

/// The rays of an earlier step whose strips have in them those of a group and these rays' own strips.
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
    /// How wide those of the last steps are at most, in cells along the minor axis for each 1 of t.
    widths: [f32; MEMORY],
}

impl StripsKept {
    pub(super) fn are_kept(&self) -> bool {
        self.from.is_some()
    }

    /// How wide strips of the last steps are at most.
    pub(super) fn width(&self) -> f32 {
        self.widths.iter().copied().fold(0.0, f32::max)
    }
}

impl<L: Lanes> March<'_, L> {
    /// Begins to keep strips or ceases to, and finds how wide those of a step are.
    pub(super) fn look_at_strips(&self, step: u32, scratch: &mut Scratch) {
        if step > 0 && step.is_multiple_of(LOOK) {
            let of_use = self.strips_of_use(step, scratch);
            let kept = &mut scratch.strips;
            if kept.from.is_none() && of_use >= MANY {
                kept.from = Some(step);
                scratch.keeps_patches = false;
            } else if of_use <= FEW {
                kept.from = None;
            }
        }
        let width = self.strip_width(step, scratch.lanes[step as usize % MEMORY]);
        let kept = &mut scratch.strips;
        kept.widths[step as usize % MEMORY] = width;
        if width.is_infinite() {
            kept.from = None;
        }
    }

    /// Of so many groups of a step strips would be of use: rays have none before them to begin from, and would
    /// be spared at least half of their way to where those of the step before came.
    #[inline(never)]
    fn strips_of_use(&self, step: u32, scratch: &Scratch) -> i32 {
        let [from, to] = scratch.lanes[step as usize % MEMORY];
        let before = scratch.lanes[(step - 1) as usize % MEMORY];
        let count = to - from;
        if count < LEAST || before[0] >= before[1] {
            return 0;
        }
        let field = &self.fields[0];
        let towards = self.towards(step);
        let limit = WIDEST / scratch.strips.width();
        let is_of_use = |first: &i32| {
            let last = to.min(first + LANES as i32) - 1;
            let d = self.directions.at(step, *first);
            let begin = if field.is_above() {
                (f64::from(field.highest - field.eye_height) * d.x / d.z) as f32
            } else {
                self.bounds[0][0].max(0.0)
            };
            let lane = (*first).clamp(before[0], before[1] - 1);
            let at = self.slot(step - 1) + MARGIN + lane as usize;
            let way = scratch.reached[at].abs() - begin;
            let steepest = scratch.steepest_around(*first);
            way > SHORT
                && limit - begin > 0.5 * way
                && self
                    .any_before(step, towards, [*first, last], steepest)
                    .is_none()
        };
        let groups = (0..LOOKS).map(|k| from + (count - 1) * k / LOOKS);
        groups.filter(is_of_use).count() as i32
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
        let aside = ends.map(|lane| towards[0] + f64::from(lane) * towards[1]);
        let ends = ends.map(|lane| self.directions.at(step, lane));
        let advances_by_lane = v.y * ends[0].x > v.x * ends[0].y;
        for steps in 1..=(MEMORY as u32 - 1).min(most) {
            let back = f64::from(steps);
            let mut from = (back * aside[0].min(aside[1]) - 1e-6).floor();
            let mut to = (back * aside[0].max(aside[1]) + 1e-6).ceil();
            // And, of those that advance less, one more, for the rays' own strips.
            if advances_by_lane {
                from -= 1.0;
            } else {
                to += 1.0;
            }
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
        let before = step - enclosing.steps as u32;
        let lanes = scratch.lanes[before as usize % MEMORY];
        let [from, to] = enclosing.lanes;
        let known = same_lanes(lanes, ends[0] + from) & same_lanes(lanes, ends[0] + to);
        let mut clear = l.splat(f32::INFINITY);
        for aside in from..=to {
            let at = (self.slot(before) + MARGIN) as i32 + ends[0] + aside;
            let reached = l.load(group(&scratch.reached, at as usize));
            let inside = l.load(group(&scratch.clear, at as usize));
            clear = l.min(clear, l.min(l.abs(reached), inside));
        }
        // Where strips become too wide rays may still be high, as where they come over the ground.
        let widest = l.splat(WIDEST / scratch.strips.width());
        let fresh = self.fresh_start(ray, stay);
        let follows = l.and(l.lt(clear, widest), l.lt(fresh, clear));
        let start = l.max(l.min(clear, widest), fresh);
        let over = l.mul(start, l.splat(enclosing.rise as f32));
        let over = l.select(follows, over, l.splat(VERY_HIGH));
        Some(Begin {
            known: l.mask(known),
            start,
            over,
        })
    }
}
