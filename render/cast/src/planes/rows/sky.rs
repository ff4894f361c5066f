//! Sky over sky: where a step's rays have met no ground, those above them need not be led along it.

use super::March;
use super::directions::Directions;
use super::scratch::{BLOCK, MARGIN, MEMORY, Scratch};
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes};
use crate::planes::shade::Shading;
use crate::planes::wave::{CHUNK, first_lanes};
use glam::DVec3;

/// Which of a step's rays see the sky: a bit a lane from its first one on, with room before it and
/// behind the last.
#[derive(Default)]
pub(super) struct SkyLanes {
    words: Vec<u64>,
    /// Whether a whole group does; else the words are not used.
    is_any: bool,
}

impl SkyLanes {
    /// Of steps with so many lanes.
    pub(super) fn with_room(lanes: usize) -> Self {
        Self {
            words: vec![0; lanes.div_ceil(64) + 3],
            is_any: false,
        }
    }

    pub(super) fn room(&self) -> usize {
        self.words.len().saturating_sub(3) * 64
    }

    pub(super) fn clear(&mut self) {
        self.is_any = false;
    }

    /// Takes down a chunk of lanes that begins at number `from`: those of `led` as they have been
    /// coloured, and the others, which all do.
    pub(super) fn put(&mut self, from: usize, chunk: [i32; 2], led: [i32; 2], shading: &Shading) {
        let [count, before, within] = [chunk[1], led[0], led[1]].map(|lane| lane - chunk[0]);
        let mut groups = [u16::MAX; CHUNK / LANES];
        let shaded = shading.sky((within - before) as usize);
        let before = before as usize / LANES;
        groups[before..before + shaded.len()].copy_from_slice(shaded);
        let last = (count - 1) / LANES as i32;
        groups[last as usize] &= first_lanes(count - last * LANES as i32);
        let groups = &groups[..=last as usize];
        if groups.contains(&u16::MAX) {
            self.put_groups(from, groups);
        }
    }

    fn put_groups(&mut self, from: usize, groups: &[u16]) {
        if !self.is_any {
            self.is_any = true;
            self.words.fill(0);
        }
        let words = &mut self.words[from / 64 + 1..];
        for (word, groups) in words.iter_mut().zip(groups.chunks(64 / LANES)) {
            let shifted = |(k, &group): (usize, &u16)| u64::from(group) << (k * LANES);
            *word = groups.iter().enumerate().map(shifted).sum();
        }
    }

    /// Lets the first and the last one of so many lanes stand for one more beside them, where they may.
    fn widen(&mut self, count: usize, [before, behind]: [bool; 2]) {
        let first = self.at(0) & 1;
        let last = self.at(count as i32 - 1) & 1;
        self.words[0] = (u64::from(before) * first) << 63;
        let word = &mut self.words[count / 64 + 1];
        *word &= !(1 << (count % 64));
        *word |= (u64::from(behind) * last) << (count % 64);
    }

    /// Sixty-four lanes from number `from` on.
    #[inline(always)]
    fn at(&self, from: i32) -> u64 {
        let number = usize::try_from(from + 64).unwrap_or(usize::MAX);
        match self.words.get(number / 64..) {
            // In two, as no number is shifted by 64.
            Some([low, high, ..]) => low >> (number % 64) | high << 1 << (63 - number % 64),
            _ => 0,
        }
    }
}

/// Which rays of an earlier step surround each of some in a step.
struct Surrounding {
    /// Steps back.
    steps: u32,
    /// Lanes aside, from the first to the last.
    lanes: [i32; 2],
    /// Whether the earlier step's first ray may do so alone, and its last one.
    alone: [bool; 2],
}

impl<L: Lanes> March<'_, L> {
    /// The lanes of a chunk whose rays must be led over the ground; on both sides of them rays see
    /// nothing but the sky as those below them do, of a step before `shaded`, and reach as far.
    ///
    /// Each such ray lies between two of the earlier step, or over one: over their ground by more than
    /// that may rise from their planes to its own. Wherever it is over the ground, one of both is, and
    /// has met none there.
    #[inline(always)]
    pub(super) fn led(
        &self,
        step: u32,
        chunk: [i32; 2],
        shaded: u32,
        scratch: &mut Scratch,
    ) -> [i32; 2] {
        // Beside the ground, rays come over it one after another.
        let is_beside = self.bounds[1][0] > 0.0;
        match shaded.checked_sub(1) {
            Some(last) if scratch.sky[last as usize % MEMORY].is_any && !is_beside => {
                self.led_under_sky(step, chunk, step - last, scratch)
            }
            _ => chunk,
        }
    }

    #[inline(never)]
    fn led_under_sky(
        &self,
        step: u32,
        [first, behind]: [i32; 2],
        nearest: u32,
        scratch: &mut Scratch,
    ) -> [i32; 2] {
        let chunk = [first, behind];
        let Some(around) = self.surrounding(step, [first, behind - 1], nearest, scratch) else {
            return chunk;
        };
        let before = step - around.steps;
        let lanes_before = scratch.lanes[before as usize % MEMORY];
        let sky = &mut scratch.sky[before as usize % MEMORY];
        if !sky.is_any {
            return chunk;
        }
        sky.widen((lanes_before[1] - lanes_before[0]) as usize, around.alone);
        let mut led = [behind, first];
        for lane in (first..behind).step_by(BLOCK) {
            let mut all = u64::MAX;
            for aside in around.lanes[0]..=around.lanes[1] {
                all &= sky.at(lane + aside - lanes_before[0]);
            }
            if behind - lane < BLOCK as i32 {
                all |= u64::MAX << (behind - lane);
            }
            if all != u64::MAX {
                led[0] = led[0].min(lane + all.trailing_ones() as i32);
                led[1] = lane + BLOCK as i32 - all.leading_ones() as i32;
            }
        }
        // Whole groups.
        led[0] -= (led[0] - first) % LANES as i32;
        led[1] += (first - led[1]).rem_euclid(LANES as i32);
        led[1] = led[1].min(behind);
        if led[0] >= led[1] {
            led = [behind, behind];
        }
        // What is clear below is so here.
        let [from, to] = [before, step].map(|step| (self.slot(step) + MARGIN) as i32);
        let reached = &mut scratch.reached;
        let [first_before, last_before] =
            [lanes_before[0], lanes_before[1] - 1].map(|lane| (from + lane) as usize);
        reached[first_before - 1] = reached[first_before];
        reached[last_before + 1] = reached[last_before];
        for [begin, end] in [[first, led[0]], [led[1], behind]] {
            if begin < end {
                let below = from + around.lanes[0];
                let below = (below + begin) as usize..(below + end) as usize;
                reached.copy_within(below, (to + begin) as usize);
            }
        }
        led
    }

    /// The nearest rays, `nearest` steps back or more, that surround those from the first to the last
    /// of `ends` and lie so much lower that no ground can come between.
    #[inline(always)]
    fn surrounding(
        &self,
        step: u32,
        ends: [i32; 2],
        nearest: u32,
        scratch: &Scratch,
    ) -> Option<Surrounding> {
        /// Of a lane: rays no further aside lie over one.
        const ASIDE: f64 = 1e-4;
        let towards = self.towards(step);
        let directions = ends.map(|lane| self.directions.at(step, lane));
        let Directions {
            step: u, lane: v, ..
        } = self.directions;
        let [[_, major_end], [minor_begin, minor_end]] =
            self.bounds.map(|ends| ends.map(f64::from));
        let extent = minor_end - minor_begin.max(0.0);
        let steepest = scratch.steepest_along(ends);
        (nearest..(MEMORY as u32).min(step + 1)).find_map(|steps| {
            let back = f64::from(steps);
            let aside = ends.map(|lane| back * (towards[0] + f64::from(lane) * towards[1]));
            let low = (aside[0].min(aside[1]) + ASIDE).floor();
            let high = (aside[0].max(aside[1]) - ASIDE).ceil();
            // Whether the ray so many lanes aside is so much lower than all of them.
            let is_sound = |lanes: f64| {
                directions.iter().all(|d| {
                    let to = lanes * v - back * u;
                    let before = d + to;
                    let higher = d.z * to.x - to.z * d.x;
                    let aside = d.y * to.x - to.y * d.x;
                    // All of the ground must not lie between neighbours.
                    let apart = (v.y * before.x - v.x * before.y).abs();
                    let nearer = before.x - v.x.abs();
                    d.x > 0.0
                        && nearer > 0.0
                        && higher >= 1.001 * steepest * aside.abs()
                        && apart * major_end < extent * before.x * nearer
                })
            };
            let lanes = [low as i32, high as i32];
            let before = step - steps;
            let lanes_before = scratch.lanes[before as usize % MEMORY];
            // No more than one ray lies beside each.
            let is_next = [
                lanes_before[0] <= ends[0] + lanes[0] + 1,
                ends[1] + lanes[1] <= lanes_before[1],
            ];
            let edges = [lanes_before[0], lanes_before[1] - 1];
            let is_there = [
                lanes_before[0] <= ends[0] + lanes[0],
                ends[1] + lanes[1] < lanes_before[1],
            ];
            // Where low and high are one, the edge is neither, and has to be lower, too.
            let beside = [low + 1.0, high - 1.0];
            let alone = [0, 1].map(|k| {
                let edge = self.directions.at(before, edges[k]);
                is_next[k]
                    && self.surrounds_alone(edge, directions[k])
                    && (is_there[k] || is_sound(beside[k]))
            });
            (is_sound(low) && is_sound(high)).then_some(Surrounding {
                steps,
                lanes,
                alone,
            })
        })
    }

    /// Whether a ray towards `edge` is over the ground wherever one is that goes beside it towards `d`.
    fn surrounds_alone(&self, edge: DVec3, d: DVec3) -> bool {
        let [[_, major_end], [minor_begin, minor_end]] =
            self.bounds.map(|ends| ends.map(f64::from));
        let field = &self.fields[0];
        let advance = edge.y / edge.x;
        if d.y >= advance * d.x {
            return minor_begin <= 0.0;
        }
        // Where the ray is higher than all ground, it does not count.
        let top = f64::from(field.highest - field.eye_height).max(0.0);
        let mut reach = major_end;
        if d.z > 0.0 {
            reach = reach.min(top * d.x / d.z);
        }
        advance * reach <= minor_end
    }

    /// Asks for the memory of pixels.
    #[inline(always)]
    pub(super) fn ask_for_pixels(
        &self,
        step: u32,
        [first, behind]: [i32; 2],
        canvas: &Canvas<'_>,
        scratch: &Scratch,
    ) {
        self.l.vectorize(
            #[inline(always)]
            || {
                let asked = scratch.pixels.asked(canvas, self.sector, step);
                for lane in (first..behind).step_by(LANES) {
                    asked.prefetch(self.l, canvas, lane);
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_read_from_anywhere() {
        let mut sky = SkyLanes::with_room(130);
        let groups = [
            0x8001, 0xffff, 0, 0x00f0, 0x1234, 0xffff, 0xffff, 0xffff, 0x0003,
        ];
        sky.put_groups(0, &groups);
        let is_set = |lane: i32| {
            let group = usize::try_from(lane)
                .ok()
                .and_then(|lane| groups.get(lane / LANES));
            group.is_some_and(|group| group >> (lane as usize % LANES) & 1 != 0)
        };
        for from in -70..150 {
            for k in 0..64 {
                let bit = sky.at(from) >> k & 1 != 0;
                assert_eq!(bit, is_set(from + k), "{k} from {from}");
            }
        }
        sky.widen(130, [true, true]);
        assert_eq!(sky.at(-1) & 7, 3);
        assert_eq!(sky.at(128) & 7, 7);
        sky.clear();
        sky.put_groups(0, &[1]);
        assert!((-70..150).all(|from| from == 0 || sky.at(from) & 1 == 0));
    }
}
