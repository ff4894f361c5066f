//! Steps of which most rays meet the ground in the very cell in which their predecessors met it:
//! they take its surface over and look for nothing.

use super::March;
use super::directions::Aim;
use super::left::{Share, UNKNOWN};
use super::look_back::Before;
use super::predecessor::Predecessor;
use super::scratch::{BLOCK, MARGIN, MEMORY, Scratch};
use super::set_out::further_on;
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes, group, group_mut, groups_mut};
use crate::planes::patches::Path;
use crate::planes::wave::{first_lanes, same_lanes};
use glam::Vec3;

/// Where rays begin that come over ground which `begins` so far along its axes: as [`further_on`] has it; of those of
/// which no ray before tells, as it is.
#[inline(always)]
pub(super) fn begin_beside<L: Lanes>(
    l: L,
    clear: L::F,
    further: f32,
    begins: [L::F; 2],
    inverse: L::F,
) -> L::F {
    // In this order: a ray along the major axis has no number there.
    let enter = l.max(l.mul(begins[1], inverse), begins[0]);
    let start = further_on(l, clear, further, enter, inverse);
    l.select(l.le(l.splat(0.0), clear), start, clear)
}

impl<L: Lanes> March<'_, L> {
    /// Tells a step's rays what they meet if that is in their predecessors' cells, and marks the others
    /// in `scratch.left`.
    ///
    /// There is no branch on what a ray finds: a processor would not foresee it, and know it late.
    pub(super) fn carry(
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
                self.aim_groups(step, lanes, scratch);
                let keeps_strips = scratch.strips.are_kept();
                if keeps_strips {
                    self.ask_for_pixels(step, lanes, canvas, scratch);
                    self.take_over_between(step, lanes, scratch);
                    scratch.left.further.fill(0.0);
                } else {
                    self.take_over(step, lanes, from, canvas, scratch);
                }
                match [self.begins_beside(), keeps_strips] {
                    [false, false] => self.meet_patches::<false, false>(step, lanes, scratch),
                    [true, false] => self.meet_patches::<true, false>(step, lanes, scratch),
                    [false, true] => self.meet_patches::<false, true>(step, lanes, scratch),
                    [true, true] => self.meet_patches::<true, true>(step, lanes, scratch),
                }
            },
        );
    }

    /// Whether the eye lies beside the ground, so that rays come over it somewhere.
    pub(super) fn begins_beside(&self) -> bool {
        self.bounds.iter().any(|[begin, _]| *begin > 0.0)
    }

    /// Where the ground begins along its axes: under the eye, if that is over it.
    #[inline(always)]
    pub(super) fn begins(&self) -> [L::F; 2] {
        self.bounds.map(
            #[inline(always)]
            |[begin, _]| self.l.splat(begin.max(0.0)),
        )
    }

    /// Finds the directions of the first rays of groups.
    #[inline(always)]
    pub(super) fn aim_groups(&self, step: u32, lanes: [i32; 2], scratch: &mut Scratch) {
        let left = &mut *scratch.left;
        let count = ((lanes[1] - lanes[0]) as usize).div_ceil(LANES);
        let [major, minor, up] = &mut left.directions;
        for (k, ((major, minor), up)) in (major.iter_mut().zip(minor).zip(up))
            .enumerate()
            .take(count)
        {
            let direction = self.directions.at(step, lanes[0] + (k * LANES) as i32);
            [*major, *minor, *up] = direction.as_vec3().to_array();
        }
    }

    /// What tells a step's rays where they begin: all that differs from group to group, or from block to block, so
    /// that they then go through one loop.
    #[inline(always)]
    pub(super) fn take_over(
        &self,
        step: u32,
        lanes: [i32; 2],
        from: &Before,
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
    ) {
        let l = self.l;
        let asked = scratch.pixels.asked(canvas, self.sector, step);
        for first in (lanes[0]..lanes[1]).step_by(BLOCK) {
            let behind = lanes[1].min(first + BLOCK as i32);
            for lane in (first..behind).step_by(LANES) {
                asked.prefetch(l, canvas, lane);
            }
            let in_chunk = (first - lanes[0]) as usize;
            if let Some(before) = from.block(in_chunk) {
                self.take_over_from(step, [first, behind], Some(before), in_chunk, scratch);
                continue;
            }
            for first in (first..behind).step_by(LANES) {
                let group = [first, behind.min(first + LANES as i32)];
                let in_chunk = (first - lanes[0]) as usize;
                self.take_over_from(step, group, from.group(in_chunk), in_chunk, scratch);
            }
        }
    }

    /// Writes to the places of neighbours that have one predecessor, from the first to behind the last, up to where
    /// they are clear by it, or [`UNKNOWN`]; they lie from number `in_chunk` on in their chunk.
    #[inline(always)]
    fn take_over_from(
        &self,
        step: u32,
        [first, behind]: [i32; 2],
        before: Option<Predecessor>,
        in_chunk: usize,
        scratch: &mut Scratch,
    ) {
        let l = self.l;
        let at = self.slot(step) + MARGIN + first as usize;
        let groups = (0..BLOCK).step_by(LANES);
        let groups = groups.zip((first..behind).step_by(LANES));
        let further = &mut scratch.left.further;
        let unknown = l.splat(UNKNOWN);
        let Some(before) = before else {
            for (k, _) in groups {
                further[(in_chunk + k) / LANES] = 0.0;
                l.store(unknown, group_mut(&mut scratch.reached, at + k));
            }
            return;
        };
        let before_step = step - before.steps.get();
        let before_lanes =
            scratch.lanes[before_step as usize % MEMORY].map(|lane| lane - before.lanes);
        let before_at = ((self.slot(before_step) + MARGIN) as i32 + first + before.lanes) as usize;
        let [reached, reached_before] = scratch
            .reached
            .get_disjoint_mut([at..at + BLOCK, before_at..before_at + BLOCK])
            .expect("steps do not share numbers");
        let all_known = before_lanes[0] <= first && behind <= before_lanes[1];
        for (k, lane) in groups {
            further[(in_chunk + k) / LANES] = before.further;
            let mut clear = l.abs(l.load(group(reached_before, k)));
            if !all_known {
                let known = l.mask(same_lanes(before_lanes, lane));
                clear = l.select(known, clear, unknown);
            }
            l.store(clear, group_mut(reached, k));
        }
    }

    /// Tells rays that know from where on what they meet there, and marks the others. Where rays keep `STRIPS`, it is
    /// noted where ground beside them rises over them.
    #[inline(always)]
    fn meet_patches<const BESIDE: bool, const STRIPS: bool>(
        &self,
        step: u32,
        [first, behind]: [i32; 2],
        scratch: &mut Scratch,
    ) {
        let l = self.l;
        let aim = Aim::new(l, self.frame, self.directions.lane);
        let lines = Path::lines(l, &self.fields[0]);
        let begins = self.begins();
        let width = scratch.strips.widths().by_t;
        let at = self.slot(step) + MARGIN + first as usize;
        let count = ((behind - first) as usize).div_ceil(LANES);
        let clear_inside = groups_mut(&mut scratch.clear[at..], count);
        let advances = groups_mut(&mut scratch.advance[at..], count);
        let slopes = groups_mut(&mut scratch.slope[at..], count);
        let reached = groups_mut(&mut scratch.reached[at..], count);
        let patches = scratch.patches.groups(at, count);
        let left = &mut *scratch.left;
        let directions = left.directions.each_ref().map(|of| &of[..count]);
        let further = &left.further[..count];
        let (passed, masks) = (&mut left.passed[..count], &mut left.masks[..count]);
        for k in 0..count {
            let direction = Vec3::new(directions[0][k], directions[1][k], directions[2][k]);
            let [major, minor, up] = aim.directions(l, direction);
            let scale = l.div(l.splat(1.0), major);
            let (advance, slope) = (l.mul(minor, scale), l.mul(up, scale));
            l.store(advance, &mut advances[k]);
            l.store(slope, &mut slopes[k]);
            let inverse = if BESIDE || STRIPS {
                l.div(major, minor)
            } else {
                scale
            };
            let clear = l.load(&reached[k]);
            let start = if BESIDE {
                begin_beside(l, clear, further[k], begins, inverse)
            } else {
                l.mul(clear, l.splat(1.0 + further[k]))
            };
            let patch = patches.load(l, k);
            let path = Path::new(l, lines, [advance, slope], start, &patch);
            if STRIPS {
                let slants = [advance, inverse, slope];
                let rises = path.rises_beside(l, slants, start, width, &patch);
                l.store_where(rises, start, &mut clear_inside[k]);
            }
            passed[k] = l.bits(path.is_in);
            let (t, left) = path.tell(l, path.is_in, advance, start, start);
            l.store(t, &mut reached[k]);
            masks[k] = left;
        }
        if let Some(last) = masks.last_mut() {
            *last &= first_lanes(behind - first - ((count - 1) * LANES) as i32);
        }
    }

    /// How many of some rays of a step meet the ground in other cells than those towards which they
    /// lie of the step before.
    #[inline(never)]
    fn changes(&self, step: u32, scratch: &Scratch) -> Share {
        const LOOKS: i32 = 32;
        let [from, to] = scratch.lanes[step as usize % MEMORY];
        let [from_before, to_before] = scratch.lanes[(step - 1) as usize % MEMORY];
        let mut changes = Share::default();
        if from >= to {
            // There lies what is left of other casts.
            return changes;
        }
        let towards = self.towards(step);
        let field = &self.fields[0];
        let cell = |step: u32, lane: i32| {
            let at = self.slot(step) + MARGIN + lane as usize;
            let t = scratch.reached[at];
            let aside = t * scratch.advance[at];
            let [major, minor] = [field.major.fraction, field.minor.fraction];
            (t >= 0.0).then_some([(t + major) as i32, (aside + minor) as i32])
        };
        for k in 0..LOOKS {
            let lane = from + (to - from) * (2 * k + 1) / (2 * LOOKS);
            let aside = (towards[0] + f64::from(lane) * towards[1]).round() as i32;
            if !(from_before..to_before).contains(&lane.saturating_add(aside)) {
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
/// have ceased to do so; and in which step first: a sector may be one of many pieces.
const LOOK: u32 = 8;
const REST: u32 = 32;
const SOON: u32 = 2;

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
        if step >= self.rests_until.max(SOON) && (step == SOON || step.is_multiple_of(LOOK)) {
            let changes = march.changes(step - 1, scratch);
            if changes.all >= 8 && changes.of() < FEW {
                let sector = march.sector;
                let [from, to] = sector.lanes(sector.steps / 2);
                let [aside, by_lane] = march.towards(sector.steps / 2);
                let aside = aside + 0.5 * f64::from(from + to) * by_lane;
                scratch.patches.begin(march.room, sector.steps, aside);
                scratch.patches.forget();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::lanes::{Isa, Portable};
    use crate::planes::PlanesScene;
    use crate::units::UnitCaster;
    use glam::{DVec2, DVec3};
    use sandtable_terrain::Ground;
    use sandtable_view::{Attitude, Camera};

    /// Whatever other casts have left where a step has no rays.
    #[test]
    fn a_step_without_rays_changes_no_cells() {
        let ground = Ground::from_fn(64, 64, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
        let scene = PlanesScene::new(Isa::best(), None, Scene::new(ground));
        let camera = Camera {
            eye: DVec3::new(30.0, 31.0, 20.0),
            attitude: Attitude::default(),
            horizontal_fov: 1.0,
        };
        let view = camera.view([160, 120]);
        let frame = scene.frame(&view).expect("a proper view");
        let sector = &frame.sectors[0];
        let mut scratch = Scratch::default();
        let room = 1024;
        let march = March::new(Portable, &frame, sector, room);
        scratch.reached.grow(MEMORY * room);
        scratch.advance.grow(MEMORY * room);
        scratch.reached.fill(1.5);
        let step = 9;
        let first = sector.lanes(step)[0];
        scratch.lanes = [[first, first + 40]; MEMORY];
        let changes = march.changes(step, &scratch);
        assert!(changes.all > 0 && changes.part == 0);
        scratch.lanes[step as usize % MEMORY] = [first; 2];
        assert_eq!(march.changes(step, &scratch).all, 0);
    }
}
