//! From which rays those of a chunk begin, found for many of them at once.

use super::March;
use super::predecessor::{Predecessor, Runs};
use super::scratch::{BLOCK, MEMORY, Scratch};
use crate::lanes::{LANES, Lanes};
use crate::planes::wave::CHUNK;

/// How many runs are looked at side by side: one after the other, each would wait for its own roots and divisions.
const SIDE_BY_SIDE: usize = 8;

/// How many steps back the rays lie at most from which all of a block begin.
const NEAR: usize = 3;

/// From which rays those of a chunk begin.
pub(super) struct Before {
    /// Those of each block of neighbours that begin from one.
    blocks: [Option<Predecessor>; CHUNK / BLOCK],
    /// Those of each group, in the other blocks.
    groups: [Option<Predecessor>; CHUNK / LANES],
}

impl Before {
    pub(super) fn new() -> Self {
        Self {
            blocks: [None; CHUNK / BLOCK],
            groups: [None; CHUNK / LANES],
        }
    }

    /// That of all of the block that begins `lanes` behind the chunk's first lane.
    #[inline(always)]
    pub(super) fn block(&self, lanes: usize) -> Option<Predecessor> {
        self.blocks[lanes / BLOCK]
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

    /// Finds from which rays those of a chunk of lanes begin: all of a block from one if that lies near, or else each
    /// group from one of any step that is kept.
    pub(super) fn look_back(
        &self,
        step: u32,
        lanes: [i32; 2],
        scratch: &Scratch,
        before: &mut Before,
    ) {
        self.l.vectorize(
            #[inline(always)]
            || {
                let across = self.across(step);
                let behind = |number: usize, count: usize| lanes[0] + (number * count) as i32;
                let blocks = ((lanes[1] - lanes[0]) as usize).div_ceil(BLOCK);
                let (mut left, mut count) = ([0; CHUNK / LANES], 0);
                for from in (0..blocks).step_by(SIDE_BY_SIDE) {
                    let runs = self.runs_of(
                        step,
                        BLOCK,
                        lanes,
                        across,
                        scratch,
                        #[inline(always)]
                        |k| (from + k).min(blocks - 1),
                    );
                    let found = self.predecessors(step, &runs, NEAR);
                    for k in 0..SIDE_BY_SIDE.min(blocks - from) {
                        let found = found.of(k);
                        before.blocks[from + k] = found;
                        if found.is_none() {
                            let first = (from + k) * (BLOCK / LANES);
                            for group in first..first + BLOCK / LANES {
                                left[count] = group;
                                count += usize::from(behind(group, LANES) < lanes[1]);
                            }
                        }
                    }
                }
                for left in left[..count].chunks(SIDE_BY_SIDE) {
                    let runs = self.runs_of(
                        step,
                        LANES,
                        lanes,
                        across,
                        scratch,
                        #[inline(always)]
                        |k| left[k.min(left.len() - 1)],
                    );
                    let found = self.predecessors(step, &runs, MEMORY - 1);
                    for (k, &group) in left.iter().enumerate() {
                        before.groups[group] = found.of(k);
                    }
                }
            },
        );
    }
}
