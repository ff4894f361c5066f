//! From which ray before it a ray may begin.

use super::March;
use super::directions::Directions;
use super::scratch::{FARTHEST, MARGIN, MEMORY, Scratch};
use crate::lanes::{LANES, Lanes};
use crate::planes::steepness::{GRADIENT, SQUARE};
use glam::DVec3;

/// Cells along the minor axis for each one along the major axis, up to which ground that comes between a
/// ray and the one that it begins from is seen beside both.
const MOST_ADVANCE: f64 = 6.0;

/// How steep the ground is at most, in metres a cell: along the minor axis, and in whatever direction.
#[derive(Clone, Copy)]
pub(in crate::planes) struct Steep {
    pub(super) aside: f64,
    pub(super) gradient: f64,
}

/// From which ray each of a group begins.
#[derive(Clone, Copy)]
pub(super) struct Predecessor {
    /// Steps back.
    pub(super) steps: usize,
    /// Lanes aside.
    pub(super) lanes: i32,
    /// By how many metres for each 1 of t the group's rays are higher, about.
    pub(super) rise: f64,
    /// How much further at least they are clear than that one, times how far that is.
    pub(super) further: f64,
}

/// Where rays fall by no more than this part of what ground rises towards them, they begin hardly further on.
const GENTLE: f64 = 0.1;

/// How much further at least neighbours are clear than those before them, whose directions differ from theirs by
/// `to`, times how far these came: where that is, they are over all ground by as much as `room` tells. From there
/// on they fall, and ground rises towards them.
#[inline(always)]
fn further(steepest: Steep, [a, b]: [DVec3; 2], to: DVec3, room: f64) -> f64 {
    let falls = -a.z.min(b.z);
    if falls <= GENTLE * steepest.gradient * a.x.max(b.x) {
        return 0.0;
    }
    let run = |d: DVec3| d.x * d.x + d.y * d.y;
    let closes = falls + steepest.gradient * run(a).max(run(b)).sqrt();
    let span = |d: DVec3| d.x * (d.x + to.x);
    let span = span(a).max(span(b));
    let further = 0.99 * room * a.x.min(b.x) / (span * closes).max(f64::MIN_POSITIVE);
    further.clamp(0.0, 1.0)
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

    /// The nearest ray before a group's from which it may begin: one so much lower that ground
    /// that is not steeper than `steepest` cannot come between them. What that ray passed over is
    /// passed over by the group's rays then.
    #[inline(always)]
    pub(super) fn predecessor(
        &self,
        step: u32,
        slope: [f64; 2],
        [first, last]: [i32; 2],
        steepest: Steep,
        most: usize,
    ) -> Option<Predecessor> {
        let ends = [
            self.directions.at(step, first),
            self.directions.at(step, last),
        ];
        let slope = slope[0] + 0.5 * f64::from(first + last) * slope[1];
        let Directions {
            step: u, lane: v, ..
        } = self.directions;
        for steps in 1..=most.min(step as usize) {
            let lanes = (slope * steps as f64).round();
            let to = lanes * v - steps as f64 * u;
            let (mut rise, mut room) = (f64::INFINITY, f64::INFINITY);
            // Right beside the vanishing point lines may run along steps.
            let mut sound = lanes.abs() <= FARTHEST;
            for end in ends {
                let higher = end.z * to.x - to.z * end.x;
                let aside = end.y * to.x - to.y * end.x;
                // Rays that enter the ground from its side must do so no earlier.
                let enters_later = self.bounds[1][0] <= 0.0 || aside <= 0.0;
                room = room.min(higher - 1.001 * steepest.aside * aside.abs());
                sound &= enters_later && end.x + to.x > 0.0;
                rise = rise.min(higher / (end.x * (end.x + to.x)));
            }
            if sound && room >= 0.0 {
                return Some(Predecessor {
                    steps,
                    lanes: lanes as i32,
                    rise,
                    further: further(steepest, ends, to, room),
                });
            }
        }
        None
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
    #[inline(always)]
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
mod tests {
    use super::*;
    use crate::lanes::{Isa, Portable};
    use crate::planes::PlanesScene;
    use crate::planes::steepness::AROUND;
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
                        let towards = march.towards(step);
                        let flat = Steep {
                            aside: 0.0,
                            gradient: 0.0,
                        };
                        let before = march.any_before(step, towards, [first, last], flat);
                        let Some(before) = before else {
                            continue;
                        };
                        for lane in [first, last] {
                            let ray = directions.at(step, lane);
                            let a = directions.at(step - before.steps as u32, lane + before.lanes);
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
        let (mut looked, mut steep, mut clear, mut ways) = (0, 0, 0.0, 0.0);
        for view in views().into_iter().step_by(4) {
            let image = pool.picture(&Brute, &scene, view).expect("a proper view");
            let frame = prepared.frame(&view).expect("a proper view");
            for sector in &frame.sectors {
                let march = March::new(Portable, &frame, sector, 0);
                let [major, minor] = march.bounds;
                let metres = DVec3::new([1.0, 1.3][sector.major], [1.3, 1.0][sector.major], 1.0);
                let hit = |step: u32, lane: i32| {
                    let [i, j] = sector.pixel(step, lane);
                    let depth = image.depth[(j * view.size[0] + i) as usize];
                    let d = march.directions.at(step, lane);
                    f64::from(depth) * d.x / (d * metres).length()
                };
                let mut steepest = Vec::new();
                for step in 0..sector.steps {
                    march.look_around(step, &mut steepest);
                    let [from, to] = sector.lanes(step);
                    for first in (from..to).step_by(LANES) {
                        let last = (to - 1).min(first + LANES as i32 - 1);
                        let steepest = steepest[first as usize >> SQUARE];
                        let towards = march.towards(step);
                        let Some(before) = march.any_before(step, towards, [first, last], steepest)
                        else {
                            continue;
                        };
                        let before_step = step - before.steps as u32;
                        let before_lanes = sector.lanes(before_step);
                        for lane in first..=last {
                            let lane_before = lane + before.lanes;
                            if !(before_lanes[0]..before_lanes[1]).contains(&lane_before) {
                                continue;
                            }
                            let d = march.directions.at(step, lane);
                            let (t, end) = (hit(before_step, lane_before), hit(step, lane));
                            let aside = t * d.y / d.x;
                            // It may have met the ground's side.
                            let entered =
                                |at: f64, [begin, _]: [f32; 2]| at > 1.00001 * f64::from(begin);
                            let is_over = entered(t, major) && entered(aside, minor);
                            if t.is_infinite() || !is_over {
                                continue;
                            }
                            let further = before.further * t;
                            assert!(
                                t + further <= end + 1e-3,
                                "{t} + {further}, {end}: {view:?}"
                            );
                            looked += 1;
                            if d.z < -4.0 * d.x && end.is_finite() {
                                steep += 1;
                                clear += further;
                                ways += end - t;
                            }
                        }
                    }
                }
            }
        }
        assert!(looked > 100_000 && steep > 10_000, "{looked}, {steep}");
        assert!(clear > 0.3 * ways, "{clear} of {ways}");
    }
}
