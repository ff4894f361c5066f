//! Steps whose rays fall so steeply that hardly any of them meets the ground twice: where they do is foretold by the
//! last two steps, and looked at there at once.

use super::March;
use super::carry::begin_beside;
use super::directions::Aim;
use super::left::UNKNOWN;
use super::look_back::Before;
use super::predecessor::Predecessor;
use super::scratch::{MARGIN, MEMORY, Scratch};
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes, group, group_mut, groups, groups_mut};
use crate::planes::patches::{Path, packed};
use crate::planes::walk::{ask, fetch, patch};
use crate::planes::wave::{CHUNK, first_lanes, same_lanes};
use glam::Vec3;

/// How many pixels below a ray ground is seen at most that would come up to it where it is taken to be clear: fewer
/// than those around which its steepness is known, and the lines through them lie aside.
const BELOW: f32 = 6.0;

/// Times the t where a ray comes into a cell: surely behind the line, however that is rounded.
const INSIDE: f32 = 1.000_001;

/// The cells in which a chunk's rays are foretold to end, a number a ray.
// On a page's border, as `Numbers` are.
#[repr(align(4096))]
pub(in crate::planes) struct Foretold {
    /// About where, and then where rays come into the cell there.
    t: [f32; CHUNK],
    /// The cell's name, as a [`Patch`](crate::planes::patches::Patch) has it.
    cell: [i32; CHUNK],
    /// Of each group, as a [`Predecessor`] has it.
    may_rise: [f32; CHUNK / LANES],
}

impl Default for Foretold {
    fn default() -> Self {
        Self {
            t: [0.0; CHUNK],
            cell: [0; CHUNK],
            may_rise: [0.0; CHUNK / LANES],
        }
    }
}

impl Predecessor {
    /// Whether it and the one before it tell about where those behind it end.
    #[inline(always)]
    pub(super) fn foretells(&self) -> bool {
        self.steps.get() == 1 && self.may_rise < f32::INFINITY
    }
}

impl<L: Lanes> March<'_, L> {
    /// Tells a step's rays what they meet if that is in the cells in which the last two steps have them end, and marks
    /// the others in `scratch.left`, as [`March::carry`] does.
    pub(super) fn extrapolate(
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
                self.take_over(step, lanes, from, canvas, scratch);
                self.foretell(step, lanes, from, scratch);
                if self.begins_beside() {
                    self.place_foretold::<true>(step, lanes, scratch);
                } else {
                    self.place_foretold::<false>(step, lanes, scratch);
                }
            },
        );
        let field = &self.fields[0];
        if field.ahead.is_some() {
            l.vectorize(
                #[inline(always)]
                || {
                    for at in (0..(lanes[1] - lanes[0]) as usize).step_by(LANES) {
                        ask(l, field, &scratch.passage, at);
                    }
                },
            );
        }
        l.vectorize(
            #[inline(always)]
            || self.meet_foretold(step, lanes, scratch),
        );
    }

    /// Finds about where rays end: as much further than those before them as these than the ones before.
    #[inline(always)]
    fn foretell(&self, step: u32, [first, behind]: [i32; 2], from: &Before, scratch: &mut Scratch) {
        let l = self.l;
        let lanes = scratch.lanes[(step - 2) as usize % MEMORY];
        let reached = &scratch.reached;
        let foretold = &mut *scratch.foretold;
        for lane in (first..behind).step_by(LANES) {
            let in_chunk = (lane - first) as usize;
            let before = from.block(in_chunk).or(from.group(in_chunk));
            let before = before.filter(Predecessor::foretells);
            let to = group_mut(&mut foretold.t, in_chunk);
            let Some(before) = before else {
                foretold.may_rise[in_chunk / LANES] = 0.0;
                l.store(l.splat(UNKNOWN), to);
                continue;
            };
            foretold.may_rise[in_chunk / LANES] = before.may_rise;
            let lane_before = lane + 2 * before.lanes;
            let known = l.mask(same_lanes(lanes, lane_before));
            let at = (self.slot(step - 2) + MARGIN) as i32 + lane_before;
            let first = l.abs(l.load(group(reached, at as usize)));
            let second = l.load(group(reached, self.slot(step) + MARGIN + lane as usize));
            let third = l.add(second, l.sub(second, first));
            // No further than where ground that rises to a ray would be seen around it.
            let farthest = if before.may_rise > 0.0 {
                BELOW * before.rise / before.may_rise
            } else {
                f32::MAX
            };
            let third = l.min(third, l.mul(second, l.splat(1.0 + farthest)));
            l.store(l.select(known, third, l.splat(UNKNOWN)), to);
        }
    }

    /// Finds the cells there, and where rays come into them.
    #[inline(always)]
    fn place_foretold<const BESIDE: bool>(
        &self,
        step: u32,
        [first, behind]: [i32; 2],
        scratch: &mut Scratch,
    ) {
        let l = self.l;
        let field = &self.fields[0];
        let aim = Aim::new(l, self.frame, self.directions.lane);
        let begins = self.begins();
        // Of the lines behind cell 0: the lines before a cell lie, to the last bit, where they do behind the one before it.
        let [major_line, minor_line] = Path::lines(l, field);
        let at = self.slot(step) + MARGIN + first as usize;
        let count = ((behind - first) as usize).div_ceil(LANES);
        let advances = groups_mut(&mut scratch.advance[at..], count);
        let slopes = groups_mut(&mut scratch.slope[at..], count);
        let reached = groups_mut(&mut scratch.reached[at..], count);
        let places = groups_mut(&mut scratch.passage.place, count);
        let directions = scratch.left.directions.each_ref().map(|of| &of[..count]);
        let further = &scratch.left.further[..count];
        let foretold = &mut *scratch.foretold;
        let cells = groups_mut(&mut foretold.cell, count);
        let foretold = groups_mut(&mut foretold.t, count);
        let one = l.splat_i(1);
        for k in 0..count {
            let direction = Vec3::new(directions[0][k], directions[1][k], directions[2][k]);
            let [major, minor, up] = aim.directions(l, direction);
            let scale = l.div(l.splat(1.0), major);
            let (advance, slope) = (l.mul(minor, scale), l.mul(up, scale));
            let inverse = l.div(major, minor);
            l.store(advance, &mut advances[k]);
            l.store(slope, &mut slopes[k]);
            let clear = l.load(&reached[k]);
            let start = if BESIDE {
                begin_beside(l, clear, further[k], begins, inverse)
            } else {
                l.mul(clear, l.splat(1.0 + further[k]))
            };
            l.store(start, &mut reached[k]);
            let cell = field.cell_at(l, l.max(l.load(&foretold[k]), start), advance);
            let to = |cell: L::I, line: L::F| l.add(l.to_float(l.sub_i(cell, one)), line);
            let to_major = to(cell[0], major_line);
            let to_minor = l.mul(to(cell[1], minor_line), inverse);
            let entry = l.mul(l.max(to_minor, to_major), l.splat(INSIDE));
            l.store(l.max(entry, start), &mut foretold[k]);
            l.store_i(packed(l, cell), &mut cells[k]);
            l.store_i(field.place(l, cell), &mut places[k]);
        }
    }

    /// Tells rays what they meet in these cells if they are clear up to there, and marks the others.
    ///
    /// Up to `start` a ray is clear. From there on its clearance grows by no more than `may_rise` for each 1 of t,
    /// wherever it comes out of ground; so where it is that much at least, it has not been in any.
    #[inline(always)]
    fn meet_foretold(&self, step: u32, [first, behind]: [i32; 2], scratch: &mut Scratch) {
        let l = self.l;
        let field = &self.fields[0];
        let lines = Path::lines(l, field);
        let at = self.slot(step) + MARGIN + first as usize;
        let count = ((behind - first) as usize).div_ceil(LANES);
        let advances = groups(&scratch.advance[at..], count);
        let slopes = groups(&scratch.slope[at..], count);
        let reached = groups_mut(&mut scratch.reached[at..], count);
        let foretold = &*scratch.foretold;
        let may_rise = &foretold.may_rise[..count];
        let cells = groups(&foretold.cell, count);
        let foretold = groups(&foretold.t, count);
        let left = &mut *scratch.left;
        let (passed, masks) = (&mut left.passed[..count], &mut left.masks[..count]);
        let zero = l.splat(0.0);
        for k in 0..count {
            let posts = fetch(l, field, &scratch.passage, k * LANES);
            let (advance, slope) = (l.load(&advances[k]), l.load(&slopes[k]));
            let (start, t) = (l.load(&reached[k]), l.load(&foretold[k]));
            let patch = patch(l, field, l.load_i(&cells[k]), posts);
            let path = Path::new(l, lines, [advance, slope], t, &patch);
            let least = l.mul(l.splat(may_rise[k]), l.sub(t, start));
            let may_have_met = l.and(l.lt(start, t), l.lt(path.over, least));
            let known = l.and(path.is_in, l.le(zero, start));
            let clear = l.and_not(known, may_have_met);
            passed[k] = l.bits(clear);
            let (t, left) = path.tell(l, clear, advance, t, start);
            l.store(t, &mut reached[k]);
            masks[k] = left;
        }
        if let Some(last) = masks.last_mut() {
            *last &= first_lanes(behind - first - ((count - 1) * LANES) as i32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Canvas;
    use crate::lanes::{Isa, Portable};
    use crate::planes::PlanesScene;
    use crate::planes::sectors::AHEAD;
    use crate::units::UnitCaster;
    use crate::{Brute, CastPool, Image, Scene};
    use glam::{DVec2, DVec3};
    use sandtable_terrain::Ground;
    use sandtable_view::{Attitude, Camera};
    use std::sync::Arc;

    /// Ground of 260 × 260 posts with ridges one post wide.
    fn ridges(k: u32) -> Arc<Scene> {
        let is_ridge = |line: u32| ((line + k) * 37 % 101).is_multiple_of(2 + k % 7);
        let height = |col: u32, row: u32| {
            let ridge = f64::from(is_ridge(col) || is_ridge(row + 40));
            let [x, y] = [col, row].map(f64::from);
            let rise = 0.5 + 0.1 * f64::from(k);
            (0.3 * (0.3 * x + 0.2 * y).sin() + rise * ridge) as f32
        };
        let ground = Ground::from_fn(260, 260, DVec2::new(1.0, 1.2), height);
        Scene::new(ground.expect("a sound grid"))
    }

    /// From over ridges that fall by more than some rays do, what rays are told is what brute force finds; and those that
    /// are told nothing begin before that.
    #[test]
    fn rays_are_told_where_they_first_meet_the_ground() {
        let pool = CastPool::new(2).expect("threads");
        let mut scratch = Scratch::default();
        let (mut told, mut left, mut steep) = (0, 0, 0);
        let attitudes = [[-1.57, 0.0], [-1.3, 0.6], [-1.0, 0.1], [-1.1, 2.0]];
        // The ground ends before the one, and on all sides of the other.
        let eyes = [
            DVec3::new(40.3, 140.7, 80.0),
            DVec3::new(131.0, 133.3, 150.0),
        ];
        let heads = eyes.map(|eye| attitudes.map(|attitude| (eye, attitude)));
        // Ridges closer by and farther apart, lower and higher, in pixels of about a cell's width and wider ones.
        let grounds = (0..20).map(|k| (ridges(k), [60 + 17 * (k % 7), 120]));
        let views = grounds.flat_map(|of| {
            heads
                .as_flattened()
                .iter()
                .map(move |&head| (of.clone(), head))
        });
        for ((scene, size), (eye, [pitch, roll])) in views {
            let prepared = PlanesScene::new(Isa::best(), None, scene.clone());
            let camera = Camera {
                eye,
                attitude: Attitude {
                    yaw: 0.3,
                    pitch,
                    roll,
                },
                horizontal_fov: 1.3,
            };
            let view = camera.view(size);
            let truth = pool.picture(&Brute, &scene, view).expect("a proper view");
            let frame = prepared.frame(&view).expect("a proper view");
            let mut image = Image::default();
            image.reset(view);
            let canvas = Canvas::new(&mut image);
            for sector in &frame.sectors {
                let room = scratch.begin(&frame, sector, &canvas);
                let march = March::new(Portable, &frame, sector, room);
                let mut befores = scratch.take_befores(&frame, sector);
                for step in 0..sector.steps {
                    let lanes = sector.lanes(step);
                    scratch.lanes[step as usize % MEMORY] = lanes;
                    march.look_around(step, &mut scratch.steepest);
                    let ahead: [_; AHEAD] = sector.lanes_from(step - step % AHEAD as u32);
                    let ahead = &ahead[step as usize % AHEAD..];
                    let before = &mut befores[0];
                    march.look_back(step, lanes, ahead, &scratch, before);
                    if step > 1 && before.foretells((lanes[1] - lanes[0]) as usize) {
                        march.extrapolate(step, lanes, before, &canvas, &mut scratch);
                        let groups: Vec<_> = march.told(step, lanes, &scratch).collect();
                        for (k, lane) in (lanes[0]..lanes[1]).enumerate() {
                            let (at, rays) = groups[k / LANES];
                            let found = f64::from(scratch.reached[at + k % LANES]);
                            let end = march.end_in(&truth, step, lane);
                            if rays >> (k % LANES) & 1 == 1 {
                                let close = (found - end).abs() < 1e-3 * end.max(1.0);
                                assert!(close, "{found}, truly {end}: {view:?}");
                                told += 1;
                                steep += u32::from(scratch.foretold.may_rise[k / LANES] > 0.0);
                                continue;
                            }
                            left += 1;
                            let d = march.directions.at(step, lane);
                            let passed = scratch.left.passed[k / LANES] >> (k % LANES) & 1 == 1;
                            // On a line of the minor axis; or none before it tells.
                            let clear = match found < 0.0 {
                                true if passed => -found * d.x / d.y,
                                true => 0.0,
                                false => found,
                            };
                            assert!(clear < end + 1e-3, "{found}, truly {end}: {view:?}");
                        }
                    }
                    for lane in lanes[0]..lanes[1] {
                        let at = march.slot(step) + MARGIN + lane as usize;
                        let d = march.directions.at(step, lane);
                        let [[_, major], [_, minor]] = march.bounds.map(|of| of.map(f64::from));
                        let leave = major.min(minor * d.x / d.y);
                        let end = march.end_in(&truth, step, lane);
                        scratch.reached[at] = if end < leave { end } else { -leave } as f32;
                    }
                }
                scratch.befores = befores;
            }
        }
        assert!(told > 50_000 && left > 10_000, "{told} told, {left} left");
        assert!(steep > 20_000, "{steep} where ground may fall by more");
    }
}
