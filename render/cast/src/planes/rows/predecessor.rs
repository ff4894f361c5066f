//! From which ray before it a ray may begin.

use super::March;
use super::directions::Directions;
use super::scratch::{FARTHEST, MARGIN, MEMORY, Scratch};
use crate::lanes::{LANES, Lanes};
use crate::planes::sectors::WHOLE;
use crate::planes::steepness::{GRADIENT, SQUARE};
use glam::DVec3;
use std::num::NonZeroU32;

/// Cells along the minor axis for each one along the major axis, up to which ground that comes between a
/// ray and the one that it begins from is seen beside both.
const MOST_ADVANCE: f64 = 6.0;

/// How steep the ground is at most, in metres a cell: along the minor axis, and in whatever direction.
#[derive(Clone, Copy)]
pub(in crate::planes) struct Steep {
    pub(super) aside: f64,
    pub(super) gradient: f64,
}

/// From which ray each of some neighbours begins.
#[derive(Clone, Copy)]
pub(super) struct Predecessor {
    /// Steps back.
    pub(super) steps: NonZeroU32,
    /// Lanes aside.
    pub(super) lanes: i32,
    /// By how many metres for each 1 of t the neighbours are higher, about.
    pub(super) rise: f32,
    /// How much further at least they are clear than that one, times how far that is.
    pub(super) further: f32,
    /// By how many metres their clearance grows at most for each 1 of t where they come out of ground; infinite where
    /// they fall too little to be foretold by it.
    pub(super) may_rise: f32,
}

/// Where rays fall by no more than this part of what ground rises towards them, they begin hardly further on.
const GENTLE: f64 = 0.1;

/// Where ground falls along rays by no more than so many times as much as they do, it is foretold where they end: where
/// it might fall by more, too many of them may have met it before.
const STEEPER: f64 = 2.0;

/// How much further at least neighbours are clear than those before them, whose directions differ from theirs by
/// `to`, times how far these came: where that is, they are over all ground by as much as `room` tells. From there
/// on they fall, and ground rises towards them. And by how much their clearance grows at most, as a [`Predecessor`] has
/// it. The neighbours lie between those of `corners`.
#[inline(always)]
fn further<const C: usize>(steepest: Steep, corners: [DVec3; C], to: DVec3, room: f64) -> [f64; 2] {
    let numbers = |d: DVec3| {
        let square = d.x * d.x + d.y * d.y;
        [-d.z, d.z, square, d.x * (d.x + to.x), d.x, -d.x]
    };
    let mut most = numbers(corners[0]);
    for corner in &corners[1..] {
        for (most, number) in most.iter_mut().zip(numbers(*corner)) {
            *most = most.max(number);
        }
    }
    let [
        falls,
        minus_least,
        square,
        span,
        most_major,
        minus_least_major,
    ] = most;
    let ground = steepest.gradient * square.sqrt();
    let closes = falls + ground;
    let further = 0.99 * room * -minus_least_major / (span * closes).max(f64::MIN_POSITIVE);
    let further = if falls > GENTLE * steepest.gradient * most_major {
        further.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let may_rise = (1.001 * ground + minus_least).max(0.0) / -minus_least_major;
    let may_rise = if ground < -STEEPER * minus_least {
        may_rise
    } else {
        f64::INFINITY
    };
    [further, may_rise]
}

/// So many runs of neighbours, from the first to the last of each, in a step and some behind it, and how steep the
/// ground is at most around them.
pub(super) struct Runs<const N: usize> {
    /// How many steps behind that step the last one lies.
    steps: u32,
    pub(super) first: [i32; N],
    last: [i32; N],
    aside: [f64; N],
    gradient: [f64; N],
}

impl<const N: usize> Runs<N> {
    /// Each of them by its number, in one step.
    #[inline(always)]
    pub(super) fn new(run: impl Fn(usize) -> ([i32; 2], Steep)) -> Self {
        let mut runs = Self {
            steps: 0,
            first: [0; N],
            last: [0; N],
            aside: [0.0; N],
            gradient: [0.0; N],
        };
        for k in 0..N {
            let ([first, last], steep) = run(k);
            (runs.first[k], runs.last[k]) = (first, last);
            (runs.aside[k], runs.gradient[k]) = (steep.aside, steep.gradient);
        }
        runs
    }

    /// And in so many steps behind that one.
    #[inline(always)]
    pub(super) fn up_to(self, steps: u32) -> Self {
        Self { steps, ..self }
    }
}

/// From which rays runs of neighbours begin.
pub(super) struct Predecessors<const N: usize> {
    /// Steps back, 0 where there is none.
    steps: [f64; N],
    lanes: [f64; N],
    /// By how much they are over all ground, as [`further`] takes it.
    room: [f64; N],
    rise: [f64; N],
    further: [f64; N],
    may_rise: [f64; N],
}

impl<const N: usize> Predecessors<N> {
    /// That of a run.
    #[inline(always)]
    pub(super) fn of(&self, k: usize) -> Option<Predecessor> {
        Some(Predecessor {
            steps: NonZeroU32::new(self.steps[k] as u32)?,
            lanes: self.lanes[k] as i32,
            rise: self.rise[k] as f32,
            further: self.further[k] as f32,
            may_rise: self.may_rise[k] as f32,
        })
    }

    /// Of how many there is none.
    pub(super) fn none(&self) -> usize {
        self.steps.iter().filter(|&&steps| steps == 0.0).count()
    }
}

impl<L: Lanes> March<'_, L> {
    /// Towards the vanishing point: lanes aside for each step back, as an affine function of the
    /// lane.
    #[inline(always)]
    pub(super) fn towards(&self, step: u32) -> [f64; 2] {
        let [along, across, w] = self.vertical;
        let back = (f64::from(step) * w - along).abs();
        [across / back, -w / back]
    }

    /// The nearest rays before runs of neighbours from which these may begin, no more than `most` steps back: rays so
    /// much lower that ground that is not steeper than it is around them cannot come between. What those rays passed
    /// over is passed over by the neighbours then.
    ///
    /// Looked for at the `CORNERS` of the runs: the two ends of those of one step, or the four of those of several, as
    /// what is asked there holds between them, too.
    ///
    /// Side by side and without branches, as processors take eight numbers at once.
    #[inline(always)]
    pub(super) fn predecessors<const N: usize, const CORNERS: usize>(
        &self,
        step: u32,
        runs: &Runs<N>,
        most: usize,
    ) -> Predecessors<N> {
        const { assert!(CORNERS == 2 || CORNERS == 4) };
        debug_assert!(CORNERS == 4 || runs.steps == 0);
        let towards = self.towards(step + runs.steps / 2);
        let Directions {
            step: u, lane: v, ..
        } = self.directions;
        let begins = [step, step + runs.steps].map(|step| self.directions.at(step, 0));
        let corners = |k: usize| -> [DVec3; CORNERS] {
            std::array::from_fn(|corner| {
                let lane = [runs.first[k], runs.last[k]][corner % 2];
                begins[corner / 2] + f64::from(lane) * v
            })
        };
        let to = |lanes: f64, back: f64| lanes * v - back * u;
        let higher = |end: DVec3, to: DVec3| end.z * to.x - to.z * end.x;
        // Rays that enter the ground from its side must do so no earlier.
        let may_enter_earlier = self.bounds[1][0] <= 0.0;
        let least_major = self.least_major;
        let mut found = Predecessors {
            steps: [0.0; N],
            lanes: [0.0; N],
            room: [0.0; N],
            rise: [0.0; N],
            further: [0.0; N],
            may_rise: [0.0; N],
        };
        for steps in 1..=most.min(step as usize) {
            let back = steps as f64;
            for k in 0..N {
                let middle = 0.5 * f64::from(runs.first[k] + runs.last[k]);
                let lanes = ((towards[0] + middle * towards[1]) * back + WHOLE) - WHOLE;
                let to = to(lanes, back);
                let mut room = f64::INFINITY;
                // Right beside the vanishing point lines may run along steps.
                let mut sound = lanes.abs() <= FARTHEST;
                for end in corners(k) {
                    let aside = end.y * to.x - to.y * end.x;
                    let least = higher(end, to) - 1.001 * runs.aside[k] * aside.abs();
                    room = if least < room { least } else { room };
                    sound &= (may_enter_earlier | (aside <= 0.0))
                        & (end.x > least_major)
                        & (end.x + to.x > least_major);
                }
                let is_new = sound & (room >= 0.0) & (found.steps[k] == 0.0);
                found.steps[k] = if is_new { back } else { found.steps[k] };
                found.lanes[k] = if is_new { lanes } else { found.lanes[k] };
                found.room[k] = if is_new { room } else { found.room[k] };
            }
            if found.steps.iter().all(|&steps| steps > 0.0) {
                break;
            }
        }
        for k in 0..N {
            let (corners, to) = (corners(k), to(found.lanes[k], found.steps[k]));
            let [a, b] = [corners[0], corners[CORNERS - 1]]
                .map(|end| higher(end, to) / (end.x * (end.x + to.x)));
            let steepest = Steep {
                aside: runs.aside[k],
                gradient: runs.gradient[k],
            };
            found.rise[k] = a.min(b);
            [found.further[k], found.may_rise[k]] = further(steepest, corners, to, found.room[k]);
        }
        found
    }

    /// The nearest ray before those of a step from the first to the last of `ends` from which they may begin.
    #[inline(always)]
    pub(super) fn any_before(
        &self,
        step: u32,
        ends: [i32; 2],
        steepest: Steep,
    ) -> Option<Predecessor> {
        let runs = Runs::<1>::new(|_| (ends, steepest));
        self.predecessors::<1, 2>(step, &runs, MEMORY - 1).of(0)
    }

    /// Whether, up to a square's side of steps behind a step, neither the rays of a lane and of those of its
    /// square and the next two, nor those from which they begin advance more than [`MOST_ADVANCE`] along the
    /// minor axis for each one along the major axis.
    fn advances_around(&self, step: u32) -> impl Fn(i32) -> bool {
        let side = f64::from(1 << SQUARE);
        let halves = [
            0.5 * (side + MEMORY as f64),
            0.5 * (3.0 * side) + MARGIN as f64,
        ];
        let step = f64::from(step) - MEMORY as f64 + halves[0];
        let middle = self.directions.at_place(0, 0.0) + step * self.directions.step;
        // Both are affine over the image.
        let sides = [1.0, -1.0].map(|sign| {
            let room = |d: DVec3| MOST_ADVANCE * d.x + sign * d.y;
            let by_lane = room(self.directions.lane);
            let least = room(middle)
                - halves[0] * room(self.directions.step).abs()
                - halves[1] * by_lane.abs();
            move |lane: f64| least + lane * by_lane
        });
        move |lane| {
            let middle = f64::from(lane) + 1.5 * side;
            sides.iter().all(|side| side(middle) >= 0.0)
        }
    }

    /// Takes note of how steep the ground is at most around a step's lanes, where that changes.
    #[inline(never)]
    pub(super) fn look_around(&self, step: u32, steepest: &mut Vec<Steep>) {
        let line = self.sector.image_step(step);
        let Some(seen) = &self.frame.steepness else {
            if step == 0 {
                let lanes = self.frame.rays.size[1 - self.sector.step_axis];
                steepest.clear();
                steepest.resize((lanes as usize >> SQUARE) + 1, self.steepest());
            }
            return;
        };
        let before = line.wrapping_add_signed(-self.sector.direction);
        if step == 0 || line >> SQUARE != before >> SQUARE {
            let along = |axis| seen.along(axis, self.sector.step_axis, line);
            let seen = along(1 - self.sector.major).zip(along(GRADIENT));
            let advances = self.advances_around(step);
            steepest.clear();
            steepest.extend((0..).zip(seen).map(|(square, (aside, gradient))| {
                if advances(square << SQUARE) {
                    Steep {
                        aside: f64::from(aside),
                        gradient: f64::from(gradient),
                    }
                } else {
                    self.steepest()
                }
            }));
        }
    }

    /// How steep the ground is at most anywhere.
    fn steepest(&self) -> Steep {
        Steep {
            aside: self.steepest[0],
            gradient: f64::from(self.frame.levels[0].steepness.gradient()),
        }
    }

    /// How steep the ground is at most where the last step's rays came to, in the resolution that
    /// suits rays there.
    ///
    /// What is nearer and finer may be steeper, and come between a ray and its predecessor by less
    /// than a pixel: where detail is chosen, that is too small to count.
    #[inline(never)]
    pub(super) fn steepest_near(
        &self,
        scratch: &Scratch,
        step: u32,
        ends: [i32; 2],
        across: f32,
    ) -> Steep {
        // Along a ray at coarser and coarser resolutions that is not known.
        let steep = |aside: f64| Steep {
            aside,
            gradient: f64::INFINITY,
        };
        let before = step.wrapping_sub(1);
        // A step may have lanes that the one before has not: there lies what is left of others.
        let [from, to] = scratch.lanes[before as usize % MEMORY];
        if from >= to {
            return steep(self.steepest[0]);
        }
        let before = self.slot(before) + MARGIN;
        let reached = |lane: i32| scratch.reached[before + lane.clamp(from, to - 1) as usize].abs();
        let mut nearest = reached(ends[1]);
        for lane in (ends[0]..ends[1]).step_by(LANES) {
            nearest = nearest.min(reached(lane));
        }
        let d = self.directions.at(step, ends[0]);
        let turned = (d.x * d.x + (self.oblong * d.y).powi(2)).sqrt();
        let width = across / turned as f32 / d.x as f32;
        let covered = (nearest * width).max(1.0);
        let coarsest = self.steepest.len() - 1;
        let level = (covered.to_bits() >> 23) as usize - 127;
        steep(self.steepest[level.min(coarsest)])
    }
}

#[cfg(test)]
impl<L: Lanes> March<'_, L> {
    /// The t at which a lane's ray ends in an image of the view: infinite where it sees the sky.
    pub(super) fn end_in(&self, image: &crate::Image, step: u32, lane: i32) -> f64 {
        let [i, j] = self.sector.pixel(step, lane);
        let depth = image.depth[(j * self.frame.rays.size[0] + i) as usize];
        let d = self.directions.at(step, lane);
        let spacing = self.frame.ground.grid().spacing;
        let metres = if self.sector.major == 0 {
            DVec3::new(spacing.x, spacing.y, 1.0)
        } else {
            DVec3::new(spacing.y, spacing.x, 1.0)
        };
        f64::from(depth) * d.x / (d * metres).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{Isa, Portable};
    use crate::planes::PlanesScene;
    use crate::planes::sectors::AHEAD;
    use crate::planes::steepness::AROUND;
    use crate::planes::wave::CHUNK;
    use crate::units::UnitCaster;
    use crate::{Brute, CastPool, Scene};
    use glam::{DMat3, DVec2};
    use sandtable_terrain::Ground;
    use sandtable_view::{Attitude, Camera, Screen, View};

    /// Looking about, rolled, straight down and up; and at tables, by eyes beside them and close over them.
    fn views() -> Vec<View> {
        let mut views = Vec::new();
        let size = [640, 360];
        for (k, yaw) in [0.0, 0.4, 0.785, 1.3, 2.9, 4.1].into_iter().enumerate() {
            for pitch in [-1.57, -1.2, -0.8, -0.5, -0.1, 0.4, 1.2] {
                for roll in [0.0, 0.3, 0.785, 1.57, 2.5] {
                    let attitude = Attitude { yaw, pitch, roll };
                    let camera = Camera {
                        eye: DVec3::new(90.0 + 3.0 * k as f64, 110.0, 60.0),
                        attitude,
                        horizontal_fov: [0.7, 1.3, 2.2][k % 3],
                    };
                    views.push(camera.view(size));
                }
            }
        }
        for [x, y, z] in [
            [100.0, -30.0, 80.0],
            [10.0, 10.0, 40.0],
            [150.0, 90.0, 25.0],
            [300.0, 120.0, 30.0],
            [-80.0, -60.0, 22.0],
        ] {
            let corner = |x: f64, y: f64| DVec3::new(x, y, 20.0);
            views.push(View {
                eye: DVec3::new(x, y, z),
                window: Screen {
                    lower_left: corner(-10.0, 5.0),
                    lower_right: corner(190.0, 25.0),
                    upper_left: corner(-25.0, 155.0),
                },
                size,
            });
        }
        views
    }

    /// Ground that comes between a ray and the one that it begins from lies in the rectangle between both;
    /// what is known of how steep it is around the ray has to hold there.
    #[test]
    fn what_may_come_between_is_seen_around_a_ray() {
        // Gentle but for a cliff in a corner.
        let height = |col: u32, row: u32| {
            let gentle = 2.0 * (0.05 * f64::from(col + 2 * row)).sin() as f32;
            if col > 190 && row > 190 {
                gentle + 30.0
            } else {
                gentle
            }
        };
        let ground = Ground::from_fn(200, 200, DVec2::ONE, height).expect("a sound grid");
        let scene = PlanesScene::new(Isa::best(), None, Scene::new(ground));
        let (mut looked, mut farthest) = (0, 0.0_f64);
        for view in views() {
            let frame = scene.frame(&view).expect("a proper view");
            for sector in &frame.sectors {
                let march = March::new(Portable, &frame, sector, 0);
                let directions = &march.directions;
                let place = DMat3::from_cols(directions.step, directions.lane, directions.at(0, 0));
                let place = place.inverse();
                let mut steepest = Vec::new();
                for step in 0..sector.steps {
                    march.look_around(step, &mut steepest);
                    let [from, to] = sector.lanes(step);
                    for first in (from..to).step_by(LANES) {
                        if steepest[first as usize >> SQUARE].aside >= march.steepest[0] {
                            // Nothing is steeper anywhere.
                            continue;
                        }
                        let last = (to - 1).min(first + LANES as i32 - 1);
                        let flat = Steep {
                            aside: 0.0,
                            gradient: 0.0,
                        };
                        let before = march.any_before(step, [first, last], flat);
                        let Some(before) = before else {
                            continue;
                        };
                        for lane in [first, last] {
                            let ray = directions.at(step, lane);
                            let a = directions.at(step - before.steps.get(), lane + before.lanes);
                            let (ray, a) = (ray / ray.x, a / a.x);
                            for corner in [[a.y, ray.z], [ray.y, a.z]] {
                                let at = place * DVec3::new(1.0, corner[0], corner[1]);
                                let off = DVec2::new(at.x, at.y) / at.z
                                    - DVec2::new(f64::from(step), f64::from(lane));
                                assert!(at.z > 0.0, "{view:?}");
                                let off = off.abs().max_element();
                                assert!(off < 0.5 * AROUND, "{off} pixels in {view:?}");
                                farthest = farthest.max(off);
                                looked += 1;
                            }
                        }
                    }
                }
            }
        }
        assert!(looked > 100_000 && farthest > 4.0, "{looked}, {farthest}");
    }

    /// From where its predecessor ended a ray is clear for as long as it is said to be, and that is much of its
    /// way where it falls steeply.
    #[test]
    fn rays_are_clear_beyond_where_those_before_them_ended() {
        let height = |col: u32, row: u32| {
            let [x, y] = [col, row].map(f64::from);
            let cliff = if col.abs_diff(60) < 2 { 9.0 } else { 0.0 };
            (3.0 * (0.4 * x).sin() * (0.3 * y + 0.1 * x).cos() + cliff) as f32
        };
        let ground = Ground::from_fn(200, 200, DVec2::new(1.0, 1.3), height);
        let scene = Scene::new(ground.expect("a sound grid"));
        let prepared = PlanesScene::new(Isa::best(), None, scene.clone());
        let pool = CastPool::new(2).expect("threads");
        // Of groups alone, and of what is found for many at once.
        let (mut looked, mut steep, mut clear, mut ways) = ([0; 2], [0; 2], [0.0; 2], [0.0; 2]);
        let (mut blocks, mut regions) = (0, 0);
        for view in views().into_iter().step_by(4) {
            let image = pool.picture(&Brute, &scene, view).expect("a proper view");
            let frame = prepared.frame(&view).expect("a proper view");
            for sector in &frame.sectors {
                let march = March::new(Portable, &frame, sector, 0);
                let [major, minor] = march.bounds;
                let mut check =
                    |of: usize, step: u32, [first, last]: [i32; 2], before: Predecessor| {
                        let before_step = step - before.steps.get();
                        let before_lanes = sector.lanes(before_step);
                        for lane in first..=last {
                            let lane_before = lane + before.lanes;
                            if !(before_lanes[0]..before_lanes[1]).contains(&lane_before) {
                                continue;
                            }
                            let d = march.directions.at(step, lane);
                            let [t, end] = [(before_step, lane_before), (step, lane)]
                                .map(|(step, lane)| march.end_in(&image, step, lane));
                            let aside = t * d.y / d.x;
                            // It may have met the ground's side.
                            let entered =
                                |at: f64, [begin, _]: [f32; 2]| at > 1.00001 * f64::from(begin);
                            let is_over = entered(t, major) && entered(aside, minor);
                            if t.is_infinite() || !is_over {
                                continue;
                            }
                            let further = f64::from(before.further) * t;
                            assert!(
                                t + further <= end + 1e-3,
                                "{t} + {further}, {end}: {view:?}"
                            );
                            looked[of] += 1;
                            if d.z < -4.0 * d.x && end.is_finite() {
                                steep[of] += 1;
                                clear[of] += further;
                                ways[of] += end - t;
                            }
                        }
                    };
                let mut scratch = Scratch::default();
                let mut befores = scratch.take_befores(&frame, sector);
                for step in 0..sector.steps {
                    march.look_around(step, &mut scratch.steepest);
                    let [from, to] = sector.lanes(step);
                    let group = |first: i32| [first, (to - 1).min(first + LANES as i32 - 1)];
                    for first in (from..to).step_by(LANES) {
                        let steepest = scratch.steepest_around(first);
                        if let Some(before) = march.any_before(step, group(first), steepest) {
                            check(0, step, group(first), before);
                        }
                    }
                    // And of the blocks of several steps.
                    let ahead: [_; AHEAD] = sector.lanes_from(step - step % AHEAD as u32);
                    let ahead = &ahead[step as usize % AHEAD..];
                    let square = |step| sector.image_step(step) >> SQUARE;
                    let behind = step + march.steps_alike(step);
                    assert!(behind <= sector.steps && square(behind - 1) == square(step));
                    let before = &mut befores[0];
                    // As sky does, some lanes of some steps are left out.
                    let without = if step % 5 == 0 {
                        7 * step as i32 % 60
                    } else {
                        0
                    };
                    let from = to.min(from + without);
                    let chunk = [from, to.min(from + CHUNK as i32)];
                    march.look_back(step, chunk, ahead, &scratch, before);
                    for first in (chunk[0]..chunk[1]).step_by(LANES) {
                        let in_chunk = (first - from) as usize;
                        let in_block = before.block(in_chunk);
                        blocks += usize::from(in_block.is_some());
                        regions += usize::from(before.is_in_region(in_chunk));
                        if let Some(before) = in_block.or(before.group(in_chunk)) {
                            check(1, step, group(first), before);
                        }
                    }
                }
            }
        }
        assert!(looked.iter().all(|&looked| looked > 100_000), "{looked:?}");
        assert!(steep.iter().all(|&steep| steep > 10_000), "{steep:?}");
        let shares = [0, 1].map(|of| clear[of] / ways[of]);
        assert!(shares[0] > 0.3 && shares[1] > 0.2, "{shares:?}");
        assert!(2 * regions > blocks, "{regions} of {blocks}");
    }
}
