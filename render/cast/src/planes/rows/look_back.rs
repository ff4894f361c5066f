//! From which rays those of a chunk begin, found for many of them at once.

use super::March;
use super::predecessor::{Predecessor, Runs};
use super::scratch::{BLOCK, MEMORY, Scratch};
use crate::lanes::{LANES, Lanes};
use crate::planes::steepness::SQUARE;
use crate::planes::wave::CHUNK;

/// How many runs are looked at side by side: one after the other, each would wait for its own roots and divisions.
const SIDE_BY_SIDE: usize = 8;

/// How many steps back the rays lie at most from which all of a block begin.
const NEAR: usize = 3;

/// How many lanes aside blocks of a region lie at most from each other: the farther, the less holds for all of it.
const MOST_ASIDE: i32 = BLOCK as i32 / 2;

/// From which rays those of a chunk begin.
#[derive(Clone)]
pub(super) struct Before {
    /// Those of each block of neighbours that begin from one.
    blocks: [Option<Predecessor>; CHUNK / BLOCK],
    /// Those of each group, in the other blocks.
    groups: [Option<Predecessor>; CHUNK / LANES],
    /// Where each block lies in this step and some to come.
    regions: [Region; CHUNK / BLOCK],
}

/// Rays of some steps that may all begin from those one step back.
#[derive(Clone, Copy)]
struct Region {
    /// Behind the last of the steps.
    behind: u32,
    /// From the first to the last lane.
    lanes: [i32; 2],
    /// From which they begin. None where that is not known of all of them.
    before: Option<Predecessor>,
}

impl Region {
    /// Whether a block of a step that begins at lane `first` lies in it.
    #[inline(always)]
    fn has(&self, step: u32, first: i32) -> bool {
        let last = first + BLOCK as i32 - 1;
        (step < self.behind) & (self.lanes[0] <= first) & (last <= self.lanes[1])
    }
}

impl Before {
    pub(super) fn new() -> Self {
        let nowhere = Region {
            behind: 0,
            lanes: [0; 2],
            before: None,
        };
        Self {
            blocks: [None; CHUNK / BLOCK],
            groups: [None; CHUNK / LANES],
            regions: [nowhere; CHUNK / BLOCK],
        }
    }

    /// That of all of the block that begins `lanes` behind the chunk's first lane.
    #[inline(always)]
    pub(super) fn block(&self, lanes: usize) -> Option<Predecessor> {
        self.blocks[lanes / BLOCK]
    }

    /// Whether it is foretold of most of so many lanes where their rays end.
    #[inline(always)]
    pub(super) fn foretells(&self, lanes: usize) -> bool {
        let blocks = &self.blocks[..lanes.div_ceil(BLOCK)];
        let foretell = blocks.iter().flatten().filter(|before| before.foretells());
        4 * foretell.count() >= 3 * blocks.len()
    }

    /// Whether that was found for several steps.
    #[cfg(test)]
    pub(super) fn is_in_region(&self, lanes: usize) -> bool {
        self.regions[lanes / BLOCK].before.is_some()
    }

    /// That of a group of a block which has none.
    #[inline(always)]
    pub(super) fn group(&self, lanes: usize) -> Option<Predecessor> {
        self.groups[lanes / LANES]
    }
}

impl<L: Lanes> March<'_, L> {
    /// Some of the runs of `count` neighbours each into which lanes are cut. `across` as in
    /// [`March::steepest_near`].
    #[inline(always)]
    fn runs_of(
        &self,
        step: u32,
        count: usize,
        lanes: [i32; 2],
        across: Option<f32>,
        scratch: &Scratch,
        number: impl Fn(usize) -> usize,
    ) -> Runs<SIDE_BY_SIDE> {
        Runs::new(
            #[inline(always)]
            |k| {
                let first = lanes[0] + (number(k) * count) as i32;
                let ends = [first, lanes[1].min(first + count as i32) - 1];
                let steepest = match across {
                    Some(across) => self.steepest_near(scratch, step, ends, across),
                    None => scratch.steepest_around(first),
                };
                (ends, steepest)
            },
        )
    }

    /// Of how many steps from a step on regions may be: they have one place's steepness.
    pub(super) fn steps_alike(&self, step: u32) -> u32 {
        let side = 1 << SQUARE;
        let line = self.sector.image_step(step) % side;
        let left = if self.sector.direction > 0 {
            side - line
        } else {
            line + 1
        };
        left.min(self.sector.steps - step)
    }

    /// Finds anew from which rays those of blocks begin that have come out of their regions.
    ///
    /// `ahead`: the lanes of this step, and of some to come.
    #[inline(always)]
    fn look_back_for_regions(
        &self,
        step: u32,
        lanes: [i32; 2],
        ahead: &[[i32; 2]],
        scratch: &Scratch,
        before: &mut Before,
    ) {
        let first_lane = |block: usize| lanes[0] + (block * BLOCK) as i32;
        let blocks = ((lanes[1] - lanes[0]) as usize).div_ceil(BLOCK);
        let (mut left, mut count) = ([0; CHUNK / BLOCK], 0);
        for (block, region) in before.regions[..blocks].iter().enumerate() {
            left[count] = block;
            count += usize::from(!region.has(step, first_lane(block)));
        }
        if count == 0 {
            return;
        }
        // A sector's first step has none before it.
        let steps = if step == 0 { 1 } else { self.steps_alike(step) };
        let ahead = &ahead[..ahead.len().min(steps as usize)];
        // Blocks go along with the first lanes of their steps.
        let aside = ahead.iter().map(|[from, _]| from - ahead[0][0]);
        let [least, most] = aside.fold([0; 2], |[least, most], aside| {
            [least.min(aside), most.max(aside)]
        });
        let is_near = ahead.len() > 1 && most - least <= MOST_ASIDE;
        for left in left[..count].chunks(SIDE_BY_SIDE) {
            let lanes = |block: usize| {
                let first = first_lane(block);
                [first + least, first + BLOCK as i32 - 1 + most]
            };
            let found = is_near.then(
                #[inline(always)]
                || {
                    let runs = Runs::new(
                        #[inline(always)]
                        |k| {
                            let lanes = lanes(left[k.min(left.len() - 1)]);
                            (lanes, scratch.steepest_over(lanes))
                        },
                    );
                    let runs = runs.up_to(ahead.len() as u32 - 1);
                    self.predecessors::<SIDE_BY_SIDE, 4>(step, &runs, 1)
                },
            );
            for (k, &block) in left.iter().enumerate() {
                before.regions[block] = Region {
                    behind: step + ahead.len() as u32,
                    lanes: lanes(block),
                    before: found.as_ref().and_then(|found| found.of(k)),
                };
            }
        }
    }

    /// Finds from which rays those of a chunk of lanes begin: all of a block from one if that lies near, or else each
    /// group from one of any step that is kept.
    ///
    /// `ahead`: the lanes of this step, and of some to come.
    pub(super) fn look_back(
        &self,
        step: u32,
        lanes: [i32; 2],
        ahead: &[[i32; 2]],
        scratch: &Scratch,
        before: &mut Before,
    ) {
        self.l.vectorize(
            #[inline(always)]
            || {
                let across = self.across(step);
                if across.is_none() {
                    self.look_back_for_regions(step, lanes, ahead, scratch, before);
                }
                let behind = |number: usize, count: usize| lanes[0] + (number * count) as i32;
                let blocks = ((lanes[1] - lanes[0]) as usize).div_ceil(BLOCK);
                let (mut left, mut count) = ([0; CHUNK / BLOCK], 0);
                for (block, region) in before.regions[..blocks].iter().enumerate() {
                    before.blocks[block] = region.before;
                    left[count] = block;
                    count += usize::from(region.before.is_none());
                }
                let (mut left_groups, mut groups) = ([0; CHUNK / LANES], 0);
                for left in left[..count].chunks(SIDE_BY_SIDE) {
                    let runs = self.runs_of(
                        step,
                        BLOCK,
                        lanes,
                        across,
                        scratch,
                        #[inline(always)]
                        |k| left[k.min(left.len() - 1)],
                    );
                    let found = self.predecessors::<SIDE_BY_SIDE, 2>(step, &runs, NEAR);
                    for (k, &block) in left.iter().enumerate() {
                        let found = found.of(k);
                        before.blocks[block] = found;
                        if found.is_none() {
                            let first = block * (BLOCK / LANES);
                            for group in first..first + BLOCK / LANES {
                                left_groups[groups] = group;
                                groups += usize::from(behind(group, LANES) < lanes[1]);
                            }
                        }
                    }
                }
                for left in left_groups[..groups].chunks(SIDE_BY_SIDE) {
                    let runs = self.runs_of(
                        step,
                        LANES,
                        lanes,
                        across,
                        scratch,
                        #[inline(always)]
                        |k| left[k.min(left.len() - 1)],
                    );
                    let found = self.predecessors::<SIDE_BY_SIDE, 2>(step, &runs, MEMORY - 1);
                    for (k, &group) in left.iter().enumerate() {
                        before.groups[group] = found.of(k);
                    }
                }
            },
        );
    }
}
