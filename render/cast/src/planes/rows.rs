//! Step by step away from the vanishing point of the vertical: one sector's rays.

mod recolour;
mod survey;

pub(super) use recolour::{reaches, recolour_sector};
pub(super) use survey::{begins, looks};

use super::climb::{climb, level_for};
use super::coarser::Coarser;
use super::field::{Axis, Field};
use super::footprint::Around;
use super::frame::Frame;
use super::maxima::TOP;
use super::pixels::PixelBlock;
use super::sectors::Sector;
use super::shade::{Chunk, Shader, Shading};
use super::walk::{Departure, Passage, Step, depart, walk};
use super::wave::{CHUNK, Ray, Wave};
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes};
use crate::tally::Tally;
use glam::DVec3;

/// How many steps back the ray may lie from which one begins.
const MEMORY: usize = 8;

/// What a thread needs to cast a sector, kept from one sector to the next.
#[derive(Default)]
pub(super) struct Scratch {
    /// For the last steps, how far each lane's ray came: to its hit, or (negative) to where it left
    /// the ground or, while it is on its way, to where it is clear.
    reached: Vec<f32>,
    lanes: [[i32; 2]; MEMORY],
    /// The rays of these steps, for their colours.
    advance: Vec<f32>,
    slope: Vec<f32>,
    /// The rays on their way over each of the ground's resolutions.
    waves: Vec<Waves>,
    departure: Box<Departure>,
    passage: Box<Passage>,
    shading: Box<Shading>,
    /// Colours and depths of the last steps.
    pixels: PixelBlock,
}

/// Rays over one resolution: those that go from cell to cell, and those that skip blocks.
#[derive(Default)]
struct Waves {
    low: Box<Wave>,
    high: Box<Wave>,
}

impl Waves {
    fn len(&self) -> usize {
        self.low.len() + self.high.len()
    }
}

impl Scratch {
    /// Makes ready for a sector; gives the numbers a step.
    fn begin(&mut self, frame: &Frame<'_>, sector: &Sector, canvas: &Canvas<'_>) -> usize {
        let width = frame.rays.size[1 - sector.step_axis] as usize;
        // A power of two, so that the step of a ray is quickly told from where its number lies.
        let room = (width + 2 * MARGIN + LANES).next_power_of_two();
        self.lanes = [[0, 0]; MEMORY];
        let levels = self.waves.len().max(frame.levels.len());
        self.waves.resize_with(levels, Waves::default);
        // A cast that panicked may have left some behind.
        for waves in &mut self.waves {
            waves.low.truncate(0);
            waves.high.truncate(0);
        }
        for numbers in [&mut self.reached, &mut self.advance, &mut self.slope] {
            numbers.resize(numbers.len().max(room * MEMORY), 0.0);
        }
        self.pixels.begin(canvas, sector, width + MARGIN);
        room
    }
}

/// Rays that may stay on their way while the next step begins: low and high ones each.
const UNFINISHED: usize = 2 * LANES;

/// Rays of a group that set out low from which on they go through their first cell as they are, not
/// closed up with others.
const MANY: u32 = 8;

/// Lanes that begin from one predecessor where the nearest will do for all of them.
const SHARED: i32 = 4 * LANES as i32;

/// Room before lane 0, so that neighbours of a step's first rays can be read.
const MARGIN: usize = 2 * LANES;

fn group(numbers: &[f32], at: usize) -> &[f32; LANES] {
    numbers[at..].first_chunk().expect("room was made")
}

fn group_mut(numbers: &mut [f32], at: usize) -> &mut [f32; LANES] {
    numbers[at..].first_chunk_mut().expect("room was made")
}

/// The part of a group of which `count` lanes are pixels.
fn first_lanes(count: i32) -> u16 {
    if count >= LANES as i32 {
        u16::MAX
    } else {
        (1 << count) - 1
    }
}

/// The rays of a sector: directions as an affine function of step and lane. Components are cells
/// along the major and the minor axis, both in the direction in which rays run, and metres up.
pub(super) struct Directions {
    first: DVec3,
    pub(super) step: DVec3,
    pub(super) lane: DVec3,
}

impl Directions {
    fn new(frame: &Frame<'_>, sector: &Sector) -> Self {
        let turned = |v: DVec3| {
            let (major, minor) = if sector.major == 0 {
                (v.x, v.y)
            } else {
                (v.y, v.x)
            };
            DVec3::new(
                major * f64::from(sector.signs[0]),
                minor * f64::from(sector.signs[1]),
                v.z,
            )
        };
        let rays = &frame.rays;
        let step = turned(rays.steps[sector.step_axis]);
        Self {
            first: turned(rays.first) + f64::from(sector.first_step) * step,
            step: f64::from(sector.direction) * step,
            lane: turned(rays.steps[1 - sector.step_axis]),
        }
    }

    pub(super) fn at(&self, step: u32, lane: i32) -> DVec3 {
        self.first + f64::from(step) * self.step + f64::from(lane) * self.lane
    }
}

/// From which ray each of a group begins.
#[derive(Clone, Copy)]
struct Predecessor {
    /// Steps back.
    steps: usize,
    /// Lanes aside.
    lanes: i32,
    /// By how many metres for each 1 of t the group's rays are higher, about.
    rise: f64,
}

/// All that one sector's cast knows.
struct March<'a, L: Lanes> {
    l: L,
    sector: &'a Sector,
    frame: &'a Frame<'a>,
    /// Numbers a step in the scratch.
    room: usize,
    /// The ground at its own resolution, and at coarser ones.
    fields: Vec<Field<'a>>,
    directions: Directions,
    /// The vanishing point of the vertical in steps and lanes of the sector.
    vertical: [f64; 3],
    /// Metres a cell of the ground, along the minor axis, that each of its resolutions is steep at
    /// most.
    steepest: Vec<f64>,
    /// Where the ground begins and ends, in cells from the eye along major and minor axis.
    bounds: [[f32; 2]; 2],
}

/// Casts a sector's pixels.
#[inline(always)]
pub(super) fn cast_sector<L: Lanes, T: Tally>(
    l: L,
    frame: &Frame<'_>,
    sector: &Sector,
    scratch: &mut Scratch,
    canvas: &Canvas<'_>,
    tally: &mut T,
) {
    let room = scratch.begin(frame, sector, canvas);
    let march = March::new(l, frame, sector, room);
    let shader = Shader::new(frame, sector, &march.fields[0]);
    // A pixel's footprint is seen by its neighbours of the steps before and behind.
    let lag = u32::from(frame.detail.is_some());
    let mut shaded = 0;
    for step in 0..sector.steps {
        // The step whose place this one takes must be done.
        if step as usize >= MEMORY && shaded + MEMORY as u32 <= step + 2 * lag {
            march.go_on(scratch, 0, tally);
            shaded = march.shade(&shader, canvas, scratch, shaded, step - lag);
        }
        let lanes = sector.lanes(step);
        scratch.lanes[step as usize % MEMORY] = lanes;
        for first in (lanes[0]..lanes[1]).step_by(CHUNK) {
            let chunk = [first, lanes[1].min(first + CHUNK as i32)];
            l.vectorize(
                #[inline(always)]
                || march.set_out(step, chunk, canvas, scratch, tally),
            );
            if frame.detail.is_none() {
                march.depart(step, chunk, scratch);
            }
            march.go_on(scratch, UNFINISHED, tally);
        }
        let done = march.first_open(step, scratch).saturating_sub(lag);
        shaded = march.shade(&shader, canvas, scratch, shaded, done);
    }
    march.go_on(scratch, 0, tally);
    march.shade(&shader, canvas, scratch, shaded, sector.steps);
    scratch.pixels.finish(l, canvas, sector);
}

impl<'a, L: Lanes> March<'a, L> {
    fn new(l: L, frame: &'a Frame<'a>, sector: &'a Sector, room: usize) -> Self {
        let field = |level: usize| {
            let scale = f64::from(1 << level);
            let [eye_x, eye_y] = [frame.eye.x / scale, frame.eye.y / scale];
            let ground = &frame.levels[level];
            let axis = |number: usize, sign| {
                let eye = [eye_x, eye_y][number];
                Axis::new(eye, ground.cells[number], sign)
            };
            let [major, minor] = [
                axis(sector.major, sector.signs[0]),
                axis(1 - sector.major, sector.signs[1]),
            ];
            Field {
                heights: &ground.heights,
                maxima: &ground.maxima,
                major,
                minor,
                major_axis: sector.major,
                eye_height: frame.eye.z as f32,
                eye_rest: (frame.eye.z - f64::from(frame.eye.z as f32)) as f32,
                highest: frame.highest + frame.rounding,
                rounding: frame.rounding,
                code_base: ground.code_base,
                code_step: ground.code_step,
                scale: scale as f32,
                near: frame.near * scale as f32,
                ends: [0.0; 2],
                ahead: ground.is_large().then(|| {
                    let [x, y] = if sector.major == 0 {
                        sector.signs
                    } else {
                        [sector.signs[1], sector.signs[0]]
                    };
                    let north = if y > 0 { ground.heights.stride } else { 0 };
                    i32::from(x > 0) + north as i32
                }),
            }
        };
        let mut fields: Vec<_> = (0..frame.levels.len()).map(field).collect();
        let [major, minor] = [fields[0].major, fields[0].minor];
        let bounds =
            [major, minor].map(|axis| [axis.line(axis.cells[0]), axis.line(axis.cells[1] + 1)]);
        let steepest = frame.levels.iter().zip(&fields);
        let steepest = steepest
            .map(|(level, field)| f64::from(level.steepest[1 - sector.major] / field.scale))
            .collect();
        for field in &mut fields {
            // Coarser cells may reach out over the ground's border: it ends where it ends.
            field.ends = bounds.map(|[_, end]| end / field.scale);
        }
        let [x, y, w] = frame.rays.vertical();
        let (across, along) = if sector.step_axis == 0 {
            (y, x)
        } else {
            (x, y)
        };
        // Steps count from the first one on, in the sector's direction.
        let direction = f64::from(sector.direction);
        let vertical = [
            direction * (along - f64::from(sector.first_step) * w),
            across,
            w,
        ];
        Self {
            l,
            sector,
            frame,
            room,
            fields,
            directions: Directions::new(frame, sector),
            vertical,
            steepest,
            bounds,
        }
    }

    /// Towards the vanishing point: lanes aside for each step back, as an affine function of the
    /// lane.
    #[inline(always)]
    fn towards(&self, step: u32) -> [f64; 2] {
        let [along, across, w] = self.vertical;
        let back = (f64::from(step) * w - along).abs();
        [across / back, -w / back]
    }

    /// The nearest ray before a group's from which it may begin: one so much lower that ground
    /// that is not steeper than `steepest` cannot come between them. What that ray passed over is
    /// passed over by the group's rays then.
    #[inline(always)]
    fn predecessor(
        &self,
        step: u32,
        slope: [f64; 2],
        [first, last]: [i32; 2],
        steepest: f64,
        most: usize,
    ) -> Option<Predecessor> {
        let ends = [first, last].map(|lane| self.directions.at(step, lane));
        let slope = slope[0] + 0.5 * f64::from(first + last) * slope[1];
        let Directions {
            step: u, lane: v, ..
        } = self.directions;
        for steps in 1..=most.min(step as usize) {
            let lanes = (slope * steps as f64).round();
            let to = lanes * v - steps as f64 * u;
            let mut rise = f64::INFINITY;
            let mut sound = true;
            for end in ends {
                let higher = end.z * to.x - to.z * end.x;
                let aside = end.y * to.x - to.y * end.x;
                // Rays that enter the ground from its side must do so no earlier.
                let enters_later = self.bounds[1][0] <= 0.0 || aside <= 0.0;
                sound &=
                    higher >= 1.001 * steepest * aside.abs() && enters_later && end.x + to.x > 0.0;
                rise = rise.min(higher / (end.x * (end.x + to.x)));
            }
            if sound {
                return Some(Predecessor {
                    steps,
                    lanes: lanes as i32,
                    rise,
                });
            }
        }
        None
    }

    /// How steep the ground is at most where the last step's rays came to, in the resolution that
    /// suits rays there.
    ///
    /// What is nearer and finer may be steeper, and come between a ray and its predecessor by less
    /// than a pixel: where detail is chosen, that is too small to count.
    #[inline(always)]
    fn steepest_near(&self, reached: &[f32], step: u32, ends: [i32; 2], across: f32) -> f64 {
        let before = self.slot(step.wrapping_sub(1)) + MARGIN;
        let [first, last] = ends.map(|lane| reached[before + lane as usize].abs());
        let d = self.directions.at(step, ends[0]);
        let width = across / (d.x * d.x + d.y * d.y).sqrt() as f32 / d.x as f32;
        let covered = (first.min(last) * width).max(1.0);
        let coarsest = self.steepest.len() - 1;
        let level = (covered.to_bits() >> 23) as usize - 127;
        self.steepest[level.min(coarsest)]
    }

    /// Where a step's numbers begin in the scratch; lane 0 comes `MARGIN` later.
    fn slot(&self, step: u32) -> usize {
        step as usize % MEMORY * self.room
    }

    /// The first step of which rays are still on their way, or the one behind `step`.
    fn first_open(&self, step: u32, scratch: &Scratch) -> u32 {
        let waves = scratch.waves.iter();
        let open = waves.flat_map(|waves| waves.low.ids().iter().chain(waves.high.ids()));
        let steps_back = open.map(|&id| {
            let slot = id as u32 >> self.room.trailing_zeros();
            step.wrapping_sub(slot) % MEMORY as u32
        });
        steps_back.max().map_or(step + 1, |back| step - back)
    }

    /// Colours steps from `from` to before `to`; gives where to go on.
    #[inline(always)]
    fn shade(
        &self,
        shader: &Shader<'_>,
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
        from: u32,
        to: u32,
    ) -> u32 {
        for step in from..to {
            let lanes = scratch.lanes[step as usize % MEMORY];
            for first in (lanes[0]..lanes[1]).step_by(CHUNK) {
                let count = (lanes[1] - first).min(CHUNK as i32) as usize;
                let at = self.slot(step) + MARGIN + first as usize;
                let numbers = at..at + count.next_multiple_of(LANES);
                let around = |there: bool, step: u32| {
                    let from = self.slot(step) + MARGIN + first as usize - 1;
                    let numbers = from..from + count.next_multiple_of(LANES) + 2;
                    let lanes = if there {
                        scratch.lanes[step as usize % MEMORY]
                    } else {
                        [first; 2]
                    };
                    Around {
                        lanes: lanes.map(|lane| lane - first),
                        reached: &scratch.reached[numbers.clone()],
                        advance: &scratch.advance[numbers],
                    }
                };
                let chunk = Chunk {
                    around: [
                        around(step > 0, step.wrapping_sub(1)),
                        around(true, step),
                        around(step + 1 < self.sector.steps, step + 1),
                    ],
                    step,
                    first,
                    count,
                    directions: &self.directions,
                    reached: &scratch.reached[numbers.clone()],
                    advance: &scratch.advance[numbers.clone()],
                    slope: &scratch.slope[numbers],
                };
                let (colours, depths) = scratch.pixels.lanes_mut(step, first);
                shader.shade(self.l, &chunk, &mut scratch.shading, colours, depths);
            }
            scratch
                .pixels
                .finish_step(self.l, canvas, self.sector, step, lanes);
        }
        to.max(from)
    }

    /// Leads a chunk's rays that set out low through their first cells.
    fn depart(&self, step: u32, lanes: [i32; 2], scratch: &mut Scratch) {
        let Waves { low, high } = &mut scratch.waves[0];
        depart(
            self.l,
            &self.fields[0],
            &scratch.departure,
            &Step {
                first: self.slot(step) + MARGIN + lanes[0] as usize,
                count: (lanes[1] - lanes[0]) as usize,
                advance: &scratch.advance,
                slope: &scratch.slope,
            },
            low,
            high,
            &mut scratch.passage,
            &mut scratch.reached,
        );
    }

    /// Leads rays on until no more than `unfinished` of them are on their way low, and as many
    /// high.
    fn go_on<T: Tally>(&self, scratch: &mut Scratch, unfinished: usize, tally: &mut T) {
        let l = self.l;
        while let Some((level, climbs)) = self.next_wave(scratch, unfinished) {
            let (waves, behind) = scratch.waves[level..].split_at_mut(1);
            let Waves { low, high } = &mut waves[0];
            let coarser = self.fields.get(level + 1).zip(behind.first_mut());
            let coarser = coarser.map(|(field, waves)| Coarser {
                field,
                low: &mut waves.low,
                high: &mut waves.high,
                is_last: level + 2 == self.fields.len(),
            });
            tally.cells(if climbs { high.ids() } else { low.ids() });
            let field = &self.fields[level];
            if climbs {
                l.vectorize(
                    #[inline(always)]
                    || climb(l, field, high, low, coarser),
                );
            } else {
                let passage = &mut scratch.passage;
                walk(l, field, low, high, passage, &mut scratch.reached, coarser);
            }
        }
        if unfinished > 0 {
            l.vectorize(
                #[inline(always)]
                || {
                    for (waves, field) in scratch.waves.iter().zip(&self.fields) {
                        for wave in [&waves.low, &waves.high] {
                            for at in (0..wave.len()).step_by(LANES) {
                                let mask = l.mask(wave.mask(at));
                                let ray = wave.ray(l, at);
                                let clear = l.mul(wave.t(l, at), l.splat(field.scale));
                                let clear = l.max(clear, l.splat(f32::MIN_POSITIVE));
                                let clear = l.sub(l.splat(0.0), clear);
                                l.scatter(mask, ray.id, clear, &mut scratch.reached);
                            }
                        }
                    }
                },
            );
        }
    }

    /// The resolution that most rays are on their way over, and whether most of these skip blocks;
    /// `None` where so few are left that they may wait.
    fn next_wave(&self, scratch: &Scratch, unfinished: usize) -> Option<(usize, bool)> {
        let waves = &scratch.waves[..self.fields.len()];
        let (level, fullest) = if let [only] = waves {
            (0, only)
        } else {
            let left: usize = waves.iter().map(Waves::len).sum();
            if left <= 2 * unfinished {
                return None;
            }
            let fullest = |waves: &&Waves| waves.low.len().max(waves.high.len());
            let by_level = waves.iter().enumerate();
            by_level.max_by_key(|(_, waves)| fullest(waves))?
        };
        let (low, high) = (fullest.low.len(), fullest.high.len());
        if waves.len() == 1 && low <= unfinished && high <= unfinished {
            return None;
        }
        Some((level, high > low && (high > unfinished || waves.len() > 1)))
    }

    /// Sets up the rays of a step and finds where they begin; parks those that begin high.
    #[inline(always)]
    fn set_out<T: Tally>(
        &self,
        step: u32,
        lanes: [i32; 2],
        canvas: &Canvas<'_>,
        scratch: &mut Scratch,
        tally: &mut T,
    ) {
        let l = self.l;
        let zero = l.splat(0.0);
        let one = l.splat(1.0);
        let iota = l.load(&std::array::from_fn(|k| k as f32));
        let lane_numbers = l.load_i(&std::array::from_fn(|k| k as i32));
        let v = self.directions.lane;
        // A ray straight down has a little of the major axis, too little to be seen.
        let steep = l.splat(1e-10 * self.frame.rays.first.length() as f32);
        let v_major = l.mul(l.splat(v.x as f32), iota);
        let v_minor = l.mul(l.splat(v.y as f32), iota);
        let v_up = l.mul(l.splat(v.z as f32), iota);
        let [[major_begin, major_end], [minor_begin, minor_end]] = self.bounds;
        let eye = self.fields[0].eye_height;
        let above = eye > self.fields[0].highest;
        let top = self.fields[0].highest - eye;
        let near_limit = l.splat(self.frame.near);
        let inverse_near = l.splat(1.0 / self.frame.near);
        let highest_level = l.splat_i(TOP as i32);
        let towards = self.towards(step);
        // Along a step a ray's minor part changes, over its major one's square, by this much.
        let across = self.frame.detail.as_ref().map(|detail| {
            let d = self.directions.at(step, 0);
            (f64::from(detail.cell) * (v.y * d.x - v.x * d.y).abs()) as f32
        });
        let slot = self.slot(step);
        let waves = &mut scratch.waves[..self.fields.len()];
        let (mut low_end, mut high_end) = (waves[0].low.len(), waves[0].high.len());
        // Below 0 even where there is no ground at all.
        let tiny = l.splat(f32::MIN_POSITIVE);
        let mut shared = None;
        for first in (lanes[0]..lanes[1]).step_by(LANES) {
            let at = slot + MARGIN + first as usize;
            let count = (lanes[1] - first).min(LANES as i32);
            let all = l.mask(first_lanes(count));
            // A few lines a group, long before they are written: many at once are waited for.
            let pixels = [first, first + count];
            scratch
                .pixels
                .prefetch(l, canvas, self.sector, step, pixels);
            let d = self.directions.at(step, first);
            let major = l.max(l.add(l.splat(d.x as f32), v_major), steep);
            let minor = l.max(l.add(l.splat(d.y as f32), v_minor), zero);
            let up = l.add(l.splat(d.z as f32), v_up);
            let scale = l.div(one, major);
            let advance = l.mul(minor, scale);
            let slope = l.mul(up, scale);
            let inverse = l.div(one, advance);
            let mut leave = l.min(l.splat(major_end), l.mul(l.splat(minor_end), inverse));
            let mut ok = l.and(all, l.lt(zero, leave));
            if above {
                ok = l.and(ok, l.lt(slope, zero));
            } else if l.bits(l.lt(zero, slope)) != 0 {
                let over = l.div(l.splat(top), slope);
                leave = l.select(l.lt(zero, slope), l.min(leave, over), leave);
            }
            let mut enter = l.splat(major_begin.max(0.0));
            if minor_begin > 0.0 {
                enter = l.max(enter, l.mul(l.splat(minor_begin), inverse));
            }
            ok = l.and(ok, l.lt(enter, leave));
            l.store(advance, group_mut(&mut scratch.advance, at));
            l.store(slope, group_mut(&mut scratch.slope, at));
            // Until something is found: the ray has left the ground.
            let nothing = l.sub(zero, l.max(leave, tiny));
            l.store(nothing, group_mut(&mut scratch.reached, at));
            let in_chunk = (first - lanes[0]) as usize;
            scratch.departure.clear(in_chunk);
            let ray = Ray {
                advance,
                inverse,
                slope,
                leave,
                id: l.add_i(lane_numbers, l.splat_i(at as i32)),
            };
            // How many cells a pixel covers across its ray, for each 1 of t.
            let mut width = None;
            if let Some(across) = across {
                let turned = l.sqrt(l.add(one, l.mul(advance, advance)));
                width = Some(l.div(l.mul(l.splat(across), l.mul(scale, scale)), turned));
            }
            let mut fresh = ok;
            let mut departed = 0;
            if across.is_none() && in_chunk.is_multiple_of(SHARED as usize) {
                let ends = [first, lanes[1].min(first + SHARED) - 1];
                shared = self.predecessor(step, towards, ends, self.steepest[0], 1);
            }
            let before = shared.or_else(
                #[inline(always)]
                || {
                    let ends = [first, first + count - 1];
                    let steepest = match across {
                        Some(across) => self.steepest_near(&scratch.reached, step, ends, across),
                        None => self.steepest[0],
                    };
                    self.predecessor(step, towards, ends, steepest, MEMORY - 1)
                },
            );
            if let Some(before) = before {
                let before_step = step - before.steps as u32;
                let lanes = scratch.lanes[before_step as usize % MEMORY];
                // Those whose predecessors are the sector's.
                let from = (lanes[0] - before.lanes - first).clamp(0, LANES as i32);
                let to = (lanes[1] - before.lanes - first).clamp(from, LANES as i32);
                let known = l.mask(first_lanes(to) & !first_lanes(from));
                let before_at = (self.slot(before_step) + MARGIN) as i32 + first + before.lanes;
                let start = l.abs(l.load(group(&scratch.reached, before_at as usize)));
                let start = l.max(start, enter);
                let known = l.and(known, ok);
                fresh = l.and_not(ok, known);
                let known = l.and(known, l.lt(start, leave));
                let cell = self.fields[0].cell_at(l, start, advance);
                let over = l.mul(start, l.splat(before.rise as f32));
                if let Some(width) = width {
                    self.begin(waves, known, &ray, start, over, width);
                } else {
                    let Waves {
                        low: near,
                        high: far,
                    } = &mut waves[0];
                    let high = l.and(known, l.lt(near_limit, over));
                    let low = l.and_not(known, high);
                    if l.bits(low).count_ones() >= MANY {
                        scratch.departure.put(l, in_chunk, low, &ray, start, cell);
                        departed = l.bits(low);
                    } else {
                        low_end = near.put(l, low_end, low, &ray, start, cell);
                    }
                    if l.bits(high) != 0 {
                        let level = level_for(l, l.mul(over, inverse_near));
                        high_end = far.put_at_level(l, high_end, high, &ray, start, cell, level);
                    }
                }
            }
            if l.bits(fresh) != 0 {
                let mut start = enter;
                if above {
                    start = l.max(start, l.div(l.splat(top), slope));
                }
                let fresh = l.and(fresh, l.lt(start, leave));
                if let Some(width) = width {
                    self.begin(waves, fresh, &ray, start, l.splat(f32::MAX), width);
                } else {
                    let cell = self.fields[0].cell_at(l, start, advance);
                    let high = &mut waves[0].high;
                    high_end =
                        high.put_at_level(l, high_end, fresh, &ray, start, cell, highest_level);
                }
            }
            for _ in 0..count {
                tally.ray();
            }
            for lane in (0..LANES).filter(|lane| departed >> lane & 1 != 0) {
                tally.cells(&[(at + lane) as i32]);
            }
        }
        if self.frame.detail.is_none() {
            waves[0].low.truncate(low_end);
            waves[0].high.truncate(high_end);
        }
    }

    /// Puts rays on their way that are clear up to `start` and more than `over` metres over the
    /// ground there, each at the resolution that suits its `width`: how many cells a pixel covers
    /// across the ray for each 1 of t.
    #[inline(always)]
    fn begin(
        &self,
        waves: &mut [Waves],
        mask: L::M,
        ray: &Ray<L>,
        start: L::F,
        over: L::F,
        width: L::F,
    ) {
        let l = self.l;
        let coarsest = self.fields.len() as i32 - 1;
        let covered = l.max(l.mul(start, width), l.splat(1.0));
        let level = l.min_i(l.exponent(covered), l.splat_i(coarsest));
        let mut levels = [0; LANES];
        l.store_i(level, &mut levels);
        // Where a pixel comes to cover two cells: as far away, in cells, at all resolutions.
        let limit = l.div(l.splat(2.0), width);
        let mut left = l.bits(mask);
        while left != 0 {
            let number = levels[left.trailing_zeros() as usize];
            let these = l.and(l.mask(left), l.eq_i(level, l.splat_i(number)));
            left &= !l.bits(these);
            let (field, waves) = (&self.fields[number as usize], &mut waves[number as usize]);
            let (scale, inverse_scale) = (l.splat(field.scale), l.splat(1.0 / field.scale));
            let t = l.mul(start, inverse_scale);
            let leave = l.mul(ray.leave, inverse_scale);
            let ray = Ray {
                slope: l.mul(ray.slope, scale),
                leave: if number < coarsest {
                    l.min(leave, limit)
                } else {
                    leave
                },
                ..*ray
            };
            let cell = field.cell_at(l, t, ray.advance);
            let high = l.and(these, l.lt(l.splat(field.near), over));
            let low = l.and_not(these, high);
            let end = waves.low.len();
            let end = waves.low.put(l, end, low, &ray, t, cell);
            waves.low.truncate(end);
            if l.bits(high) != 0 {
                let level = level_for(l, l.mul(over, l.splat(1.0 / field.near)));
                let end = waves.high.len();
                let end = waves.high.put_at_level(l, end, high, &ray, t, cell, level);
                waves.high.truncate(end);
            }
        }
    }
}
