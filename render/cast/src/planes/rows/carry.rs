//! Steps of which most rays meet the ground in the very cell in which their predecessors met it:
//! they take its surface over and look for nothing.

use super::March;
use super::directions::Aim;
use super::predecessor::Predecessor;
use super::scratch::{BLOCK, MARGIN, MEMORY, Scratch};
use super::set_out::same_lanes;
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes, group, group_mut};
use crate::planes::patches::{CROSSES_MINOR, End, NONE, Path, next_cell};
use crate::planes::wave::{CHUNK, Ray, first_lanes};
use crate::tally::Tally;
use bytemuck::cast_mut;

/// The most rays that wait to be put on their way.
const MOST: usize = CHUNK + LANES;

/// Rays that end in other cells than their predecessors, closed up: a number a ray.
#[repr(align(64))]
pub(in crate::planes) struct Left {
    /// Of each group of a chunk, which rays are left.
    masks: [u16; CHUNK / LANES],
    len: usize,
    /// Where its result goes.
    id: [i32; MOST],
    advance: [f32; MOST],
    slope: [f32; MOST],
    /// Up to where it is clear: along the major axis or, where its cell has [`CROSSES_MINOR`], along the
    /// minor one. Negative where no ray before it tells.
    start: [f32; MOST],
    /// The cell into which it comes there, or [`NONE`] where that has to be found.
    cell: [i32; MOST],
    between: Between,
}

impl Default for Left {
    fn default() -> Self {
        Self {
            masks: [0; CHUNK / LANES],
            len: 0,
            id: [0; MOST],
            advance: [0.0; MOST],
            slope: [0.0; MOST],
            start: [0.0; MOST],
            cell: [0; MOST],
            between: Between::default(),
        }
    }
}

/// What is known of a block of rays between its two loops, a number a ray: of their [`Path`]s.
#[repr(align(64))]
struct Between {
    start: [f32; BLOCK],
    line: [f32; BLOCK],
    next: [i32; BLOCK],
    /// What is left of the cell.
    major: [f32; BLOCK],
    minor: [f32; BLOCK],
    here: [f32; BLOCK],
    rate: [f32; BLOCK],
    discriminant: [f32; BLOCK],
    inside: [u16; BLOCK / LANES],
}

impl Default for Between {
    fn default() -> Self {
        Self {
            start: [0.0; BLOCK],
            line: [0.0; BLOCK],
            next: [0; BLOCK],
            major: [0.0; BLOCK],
            minor: [0.0; BLOCK],
            here: [0.0; BLOCK],
            rate: [0.0; BLOCK],
            discriminant: [0.0; BLOCK],
            inside: [0; BLOCK / LANES],
        }
    }
}

impl<L: Lanes> March<'_, L> {
    /// Forgets what ground rays have met.
    #[inline(never)]
    pub(super) fn forget(&self, scratch: &mut Scratch) {
        let [from, to] = self.sector.reach();
        for slot in 0..MEMORY as u32 {
            let at = self.slot(slot) + MARGIN;
            scratch.patches.forget(at + from as usize..at + to as usize);
        }
    }

    /// Tells a step's rays what they meet if that is in their predecessors' cells, and marks the others
    /// in `scratch.left`.
    ///
    /// There is no branch on what a ray finds: a processor would not foresee it, and know it late.
    #[inline(always)]
    pub(super) fn carry<T: Tally>(
        &self,
        step: u32,
        lanes: [i32; 2],
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
        tally: &mut T,
    ) {
        let l = self.l;
        let aim = Aim::new(l, self.frame, self.directions.lane);
        let towards = self.towards(step);
        let asked = scratch.pixels.asked(canvas, self.sector, step);
        tally.rays(step, lanes[0], lanes[1] - lanes[0]);
        for first in (lanes[0]..lanes[1]).step_by(BLOCK) {
            let behind = lanes[1].min(first + BLOCK as i32);
            for lane in (first..behind).step_by(LANES) {
                asked.prefetch(l, canvas, lane);
            }
            let all = [first, behind];
            if let Some(before) = self.nearest(step, towards, [first, behind - 1]) {
                let in_chunk = (first - lanes[0]) as usize;
                self.carry_block(&aim, step, all, Some(before), in_chunk, scratch, tally);
                continue;
            }
            for first in (first..behind).step_by(LANES) {
                let behind = behind.min(first + LANES as i32);
                let before = self.any_before(step, towards, [first, behind - 1]);
                let in_chunk = (first - lanes[0]) as usize;
                self.carry_block(
                    &aim,
                    step,
                    [first, behind],
                    before,
                    in_chunk,
                    scratch,
                    tally,
                );
            }
        }
    }

    /// As `carry`, of neighbours that have one predecessor, from the first to behind the last; they lie
    /// from number `in_chunk` on in their chunk.
    #[inline(always)]
    #[allow(
        clippy::too_many_arguments,
        reason = "which rays, and where they are kept"
    )]
    fn carry_block<T: Tally>(
        &self,
        aim: &Aim<L>,
        step: u32,
        [first, behind]: [i32; 2],
        before: Option<Predecessor>,
        in_chunk: usize,
        scratch: &mut Scratch,
        tally: &mut T,
    ) {
        let l = self.l;
        let field = &self.fields[0];
        let at = self.slot(step) + MARGIN + first as usize;
        let none = l.splat_i(NONE);
        let groups = (0..BLOCK).step_by(LANES);
        let groups = groups.zip((first..behind).step_by(LANES));
        let advances = block_mut(&mut scratch.advance, at);
        let slopes = block_mut(&mut scratch.slope, at);
        let left = &mut *scratch.left;
        let Some(before) = before else {
            let reached = block_mut(&mut scratch.reached, at);
            for (k, lane) in groups {
                let aimed = aim.at(l, self.directions.at(step, lane));
                l.store(aimed.advance, group_mut(advances, k));
                l.store(aimed.slope, group_mut(slopes, k));
                l.store(l.splat(-1.0), group_mut(reached, k));
                scratch.patches.forget(at + k..at + k + LANES);
                left.masks[(in_chunk + k) / LANES] = first_lanes(behind - lane);
            }
            return;
        };
        let before_step = step - before.steps as u32;
        let before_lanes =
            scratch.lanes[before_step as usize % MEMORY].map(|lane| lane - before.lanes);
        let all_known = before_lanes[0] <= first && behind <= before_lanes[1];
        let before_at = ((self.slot(before_step) + MARGIN) as i32 + first + before.lanes) as usize;
        let [reached, starts] = scratch
            .reached
            .get_disjoint_mut([at..at + BLOCK, before_at..before_at + BLOCK])
            .expect("steps do not share numbers");
        let (mut patches, known_patches) = scratch.patches.of_steps([at, before_at]);
        let [major_begin, minor_begin] = self.bounds.map(|[begin, _]| begin.max(0.0));
        let is_outside = major_begin > 0.0 || minor_begin > 0.0;
        let direction = self.directions.at(step, first);
        let (left, between) = (&mut left.masks, &mut left.between);
        for (k, lane) in groups.clone() {
            let [major, minor, up] = aim.further(l, direction, k);
            let scale = l.div(l.splat(1.0), major);
            let (advance, slope) = (l.mul(minor, scale), l.mul(up, scale));
            l.store(advance, group_mut(advances, k));
            l.store(slope, group_mut(slopes, k));
            let mut start = l.abs(l.load(group(starts, k)));
            if is_outside {
                let enter = l.div(l.mul(l.splat(minor_begin), major), minor);
                // In this order: a ray along the major axis has no number there.
                start = l.max(start, l.max(enter, l.splat(major_begin)));
            }
            let known = if all_known {
                l.mask(u16::MAX)
            } else {
                l.mask(same_lanes(before_lanes, lane))
            };
            let patch = known_patches.load(l, k);
            patches.store(l, k, &patch);
            let path = Path::new(l, field, [advance, slope], start, &patch);
            let start = l.select(known, start, l.splat(-1.0));
            l.store(start, group_mut(&mut between.start, k));
            l.store(path.line, group_mut(&mut between.line, k));
            l.store_i(path.next, group_mut(&mut between.next, k));
            l.store(path.end.major_left, group_mut(&mut between.major, k));
            l.store(path.end.minor_left, group_mut(&mut between.minor, k));
            l.store(path.end.here, group_mut(&mut between.here, k));
            l.store(path.end.rate, group_mut(&mut between.rate, k));
            l.store(
                path.end.discriminant,
                group_mut(&mut between.discriminant, k),
            );
            between.inside[k / LANES] = l.bits(l.and(known, path.is_in));
        }
        for (k, lane) in groups {
            let advance = l.load(group(advances, k));
            let inside = l.mask(between.inside[k / LANES]);
            let start = l.load(group(&between.start, k));
            let end = End {
                major_left: l.load(group(&between.major, k)),
                minor_left: l.load(group(&between.minor, k)),
                here: l.load(group(&between.here, k)),
                rate: l.load(group(&between.rate, k)),
                discriminant: l.load(group(&between.discriminant, k)),
            };
            let (hit, further) = end.find(l, advance);
            let hit = l.and(inside, hit);
            // What is left goes on behind the cell, if the ray is clear that far.
            let from = l.select(inside, l.load(group(&between.line, k)), start);
            let t = l.select(hit, l.add(start, further), from);
            l.store(t, group_mut(reached, k));
            let next = l.select_i(inside, l.load_i(group(&between.next, k)), none);
            patches.set_cells(l, k, hit, next);
            let all = first_lanes(behind - lane);
            left[(in_chunk + k) / LANES] = all & !l.bits(hit);
            tally.cells_of((at + k) as i32, all & l.bits(hit));
        }
    }

    /// Closes up the rays that are left of a chunk.
    #[inline(always)]
    pub(super) fn close_up(&self, step: u32, [first, behind]: [i32; 2], scratch: &mut Scratch) {
        let l = self.l;
        let left = &mut *scratch.left;
        let mut len = 0;
        for lane in (first..behind).step_by(LANES) {
            let mask = l.mask(left.masks[(lane - first) as usize / LANES]);
            let at = self.slot(step) + MARGIN + lane as usize;
            let bits = |numbers: &[f32]| l.bits_of_float(l.load(group(numbers, at)));
            let values = [
                self.ids(at),
                bits(&scratch.advance),
                bits(&scratch.slope),
                bits(&scratch.reached),
                scratch.patches.cells(l, at),
            ];
            let columns = [
                group_mut(&mut left.id, len),
                cast_mut(group_mut(&mut left.advance, len)),
                cast_mut(group_mut(&mut left.slope, len)),
                cast_mut(group_mut(&mut left.start, len)),
                group_mut(&mut left.cell, len),
            ];
            l.compress_all(mask, values, columns);
            len += l.bits(mask).count_ones() as usize;
        }
        left.len = len;
    }

    /// Puts the rays of a chunk on their way that are left; gives how many of those that meet ground
    /// they are, about.
    #[inline(always)]
    pub(super) fn send_left(&self, chunk: [i32; 2], scratch: &mut Scratch) -> Share {
        let l = self.l;
        let field = &self.fields[0];
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let mut near_ground = 0;
        for at in (0..scratch.left.len).step_by(LANES) {
            let all = l.mask(first_lanes((scratch.left.len - at) as i32));
            let left = &scratch.left;
            let id = l.load_i(group(&left.id, at));
            let advance = l.load(group(&left.advance, at));
            let slope = l.load(group(&left.slope, at));
            let start = l.load(group(&left.start, at));
            let cell = l.load_i(group(&left.cell, at));
            let inverse = l.div(one, advance);
            let stay = self.stay(all, inverse, slope);
            let ray = Ray {
                advance,
                inverse,
                slope,
                leave: stay.leave,
                id,
            };
            l.scatter(all, id, stay.nothing(l), &mut scratch.reached);
            let known = l.and(stay.ok, l.le(zero, start));
            let fresh = l.and_not(stay.ok, known);
            // Those that passed their predecessors' cells stand on a line of the one or the other axis.
            let passed = l.gt_i(l.splat_i(NONE), cell);
            let crosses_minor = l.gt_i(l.and_i(cell, l.splat_i(CROSSES_MINOR)), l.splat_i(0));
            let crosses_minor = l.and(passed, crosses_minor);
            let start = l.select(crosses_minor, l.mul(start, inverse), start);
            let near = l.and(known, l.lt(start, stay.leave));
            let [major, minor] = field.cell_at(l, start, advance);
            let [next_major, next_minor] = next_cell(l, cell);
            let cell = [
                l.select_i(passed, next_major, major),
                l.select_i(passed, next_minor, minor),
            ];
            scratch.waves[0].low.push(l, near, &ray, start, cell);
            near_ground += l.bits(near).count_ones() as usize;
            if l.bits(fresh) != 0 {
                self.begin_fresh(scratch, fresh, &ray, &stay);
            }
        }
        Share {
            part: near_ground,
            all: (chunk[1] - chunk[0]) as usize - scratch.left.len + near_ground,
        }
    }

    /// How many of some rays of a step meet the ground in other cells than those towards which they
    /// lie of the step before.
    #[inline(never)]
    fn changes(&self, step: u32, scratch: &Scratch) -> Share {
        const LOOKS: i32 = 32;
        let [from, to] = scratch.lanes[step as usize % MEMORY];
        let [from_before, to_before] = scratch.lanes[(step - 1) as usize % MEMORY];
        let towards = self.towards(step);
        let field = &self.fields[0];
        let cell = |step: u32, lane: i32| {
            let at = self.slot(step) + MARGIN + lane as usize;
            let t = scratch.reached[at];
            let aside = t * scratch.advance[at];
            let [major, minor] = [field.major.fraction, field.minor.fraction];
            (t >= 0.0).then_some([(t + major) as i32, (aside + minor) as i32])
        };
        let mut changes = Share::default();
        for k in 0..LOOKS {
            let lane = from + (to - from) * (2 * k + 1) / (2 * LOOKS);
            let aside = (towards[0] + f64::from(lane) * towards[1]).round() as i32;
            if !(from_before..to_before).contains(&(lane + aside)) {
                continue;
            }
            if let (Some(here), Some(before)) = (cell(step, lane), cell(step - 1, lane + aside)) {
                changes.all += 1;
                changes.part += usize::from(here != before);
            }
        }
        changes
    }
}

/// So many of all.
#[derive(Clone, Copy, Default)]
pub(super) struct Share {
    part: usize,
    all: usize,
}

impl std::ops::AddAssign for Share {
    fn add_assign(&mut self, other: Self) {
        self.part += other.part;
        self.all += other.all;
    }
}

impl Share {
    fn of(self) -> f32 {
        self.part as f32 / self.all as f32
    }
}

/// Whether a sector's rays carry on: as long as few of them come into other cells.
#[derive(Clone, Copy, Default)]
pub(super) struct Carrying {
    /// From which step on they do, where they do.
    from: Option<u32>,
    /// Until then it is not looked at whether they might.
    rests_until: u32,
}

/// The parts of rays in other cells than their predecessors up to which they begin to carry on, and up
/// to which they go on to do so.
const FEW: f32 = 0.25;
const MANY: f32 = 0.38;

/// Every how many steps it is looked at whether rays may carry on, and for how many it is not when they
/// have ceased to do so.
const LOOK: u32 = 8;
const REST: u32 = 32;

impl Carrying {
    /// Whether a step's rays carry on. The step before the first one that does keeps the ground that
    /// its rays meet.
    #[inline(never)]
    pub(super) fn begin<L: Lanes>(
        &mut self,
        march: &March<'_, L>,
        step: u32,
        scratch: &mut Scratch,
    ) -> bool {
        if let Some(from) = self.from {
            return from <= step;
        }
        if step >= self.rests_until.max(2) && step.is_multiple_of(LOOK) {
            let changes = march.changes(step - 1, scratch);
            if changes.all >= 8 && changes.of() < FEW {
                march.forget(scratch);
                scratch.keeps_patches = true;
                self.from = Some(step + 1);
            }
        }
        false
    }

    /// Takes note of how many of a step's rays that met ground came into other cells.
    #[inline(never)]
    pub(super) fn end(&mut self, left: Share, rays: i32, step: u32, scratch: &mut Scratch) {
        let is_sky = left.all < rays as usize / 4;
        if is_sky || left.of() > MANY {
            scratch.keeps_patches = false;
            self.from = None;
            self.rests_until = step + REST;
        }
    }
}

/// Those of a block of neighbours.
#[inline(always)]
fn block_mut(numbers: &mut [f32], at: usize) -> &mut [f32; BLOCK] {
    numbers[at..].first_chunk_mut().expect("room for a block")
}
