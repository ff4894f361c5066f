//! Step by step away from the vanishing point of the vertical: one sector's rays.

mod carry;
mod directions;
mod extrapolate;
mod fans;
mod left;
mod look_back;
mod predecessor;
mod recolour;
mod scratch;
mod set_out;
mod sky;
mod strips;
mod survey;

pub(super) use directions::Directions;
pub(super) use recolour::{reaches, recolour_sector};
pub(super) use scratch::{BLOCK, Scratch};
pub(super) use survey::{begins, looks};

use self::carry::Carrying;
use self::directions::STEEP;
use self::left::Share;
use self::scratch::{MARGIN, MEMORY};
use super::climb::climb;
use super::coarser::Coarser;
use super::depart::{Step, depart};
use super::field::{Axis, Field};
use super::footprint::Around;
use super::frame::Frame;
use super::patches::Patches;
use super::sectors::{AHEAD, Sector};
use super::shade::{Chunk, Shader};
use super::strips::Strips;
use super::walk::walk;
use super::wave::{CHUNK, Waves};
use crate::canvas::Canvas;
use crate::lanes::{LANES, Lanes};
use crate::tally::Tally;

/// Rays that may stay on their way while the next step begins, low and high ones each: of grounds that
/// fit the processor's nearer caches, and of larger ones, over which a wave that is short waits for
/// memory.
const UNFINISHED: usize = LANES;
const UNFINISHED_OVER_LARGE: usize = 2 * LANES;

/// How many cells a ray goes down for each one along the major axis that is straight down, as far as
/// directions in 32 bits tell.
const STRAIGHT_DOWN: f32 = 4e6;

/// All that one sector's cast knows.
struct March<'a, L: Lanes> {
    l: L,
    sector: &'a Sector,
    frame: &'a Frame<'a>,
    /// Numbers a step in the scratch.
    room: usize,
    /// The ground at its own resolution, and at coarser ones; and, for planes, at finer ones.
    fields: Vec<Field<'a>>,
    /// The number of its own resolution.
    native: usize,
    directions: Directions,
    /// A cell's side along the minor axis, over the one along the major axis.
    oblong: f64,
    /// The vanishing point of the vertical in steps and lanes of the sector.
    vertical: [f64; 3],
    /// Metres a cell of the ground, along the minor axis, that each of its resolutions is steep at
    /// most.
    steepest: Vec<f64>,
    /// Where the ground begins and ends, in cells from the eye along major and minor axis.
    bounds: [[f32; 2]; 2],
    /// The slope, metres for each 1 of t, of rays that cannot be told from one straight down.
    straight_down: f32,
    /// Rays with no more than this along the major axis are cast as if they had that much, all with one slope.
    least_major: f64,
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
    // Else rays cannot be told in which cells they end.
    let can_name = !frame.coarsens && Patches::can_name(&march.fields[0]);
    let unfinished = if march.fields[0].ahead.is_some() {
        UNFINISHED_OVER_LARGE
    } else {
        UNFINISHED
    };
    let mut shaded = 0;
    let mut carrying = Carrying::default();
    let mut lanes_ahead = [[0; 2]; AHEAD];
    let mut befores = scratch.take_befores(frame, sector);
    for step in 0..sector.steps {
        if step > 0 && frame.coarsens && march.is_far(step - 1, scratch) {
            march.go_on(scratch, 0, tally);
            scratch.far_from = step;
            march.shade(&shader, canvas, scratch, shaded, step);
            for _ in 0..march.cast_fans(step, &shader, canvas, scratch) {
                tally.ray();
            }
            scratch.pixels.finish(l, canvas, sector);
            scratch.befores = befores;
            return;
        }
        // The step whose place this one takes must be done.
        if step as usize >= MEMORY && shaded + MEMORY as u32 <= step + 2 * lag {
            march.go_on(scratch, 0, tally);
            shaded = march.shade(&shader, canvas, scratch, shaded, step - lag);
        }
        if step.is_multiple_of(AHEAD as u32) {
            lanes_ahead = l.vectorize(
                #[inline(always)]
                || sector.lanes_from(step),
            );
        }
        let lanes = lanes_ahead[step as usize % AHEAD];
        scratch.lanes[step as usize % MEMORY] = lanes;
        march.look_around(step, &mut scratch.steepest);
        if !frame.coarsens {
            march.look_at_strips(step, scratch);
        }
        let keeps_strips = scratch.strips.are_kept();
        if scratch.strips.begin_in(step) {
            // No rays have kept theirs yet, between which this step's might begin.
            carrying = Carrying::default();
        }
        let may_carry = can_name && !scratch.strips.are_wide();
        let carries = may_carry && carrying.begin(&march, step, scratch);
        scratch.patches.set_step(step);
        let mut left = Share::default();
        for first in (lanes[0]..lanes[1]).step_by(CHUNK) {
            let chunk = [first, lanes[1].min(first + CHUNK as i32)];
            let mut led = chunk;
            if !frame.coarsens {
                if !keeps_strips {
                    led = march.led(step, chunk, shaded, scratch);
                }
                *scratch.led(step, first - lanes[0]) = led;
                for sky in [[first, led[0]], [led[1], chunk[1]]] {
                    if sky[0] < sky[1] {
                        march.ask_for_pixels(step, sky, canvas, scratch);
                        tally.rays(step, sky[0], sky[1] - sky[0]);
                    }
                }
                if led[0] == led[1] {
                    continue;
                }
            }
            let before = &mut befores[(first - lanes[0]) as usize / CHUNK];
            if !keeps_strips {
                let ahead = &lanes_ahead[step as usize % AHEAD..];
                march.look_back(step, led, ahead, scratch, before);
            }
            tally.rays(step, led[0], led[1] - led[0]);
            // Those before rays that carry on keep what ground they meet.
            let are_foretold = step > 1
                && can_name
                && !keeps_strips
                && !scratch.keeps_patches
                && before.foretells((led[1] - led[0]) as usize);
            if carries || are_foretold {
                if carries {
                    march.carry(step, led, before, canvas, scratch);
                } else {
                    march.extrapolate(step, led, before, canvas, scratch);
                }
                for (at, rays) in march.told(step, led, scratch) {
                    tally.cells_of(at as i32, rays);
                }
                march.close_up(step, led, scratch);
                left += march.send_left(led, scratch);
            } else {
                if keeps_strips {
                    march.set_out::<true>(step, led, before, canvas, scratch);
                } else {
                    march.set_out::<false>(step, led, before, canvas, scratch);
                }
                march.depart((led[1] - led[0]) as usize, scratch, tally);
            }
            march.go_on(scratch, unfinished, tally);
        }
        if carries {
            carrying.end(left, lanes[1] - lanes[0], step, scratch);
        }
        let done = march.first_open(step, scratch).saturating_sub(lag);
        shaded = march.shade(&shader, canvas, scratch, shaded, done);
    }
    march.go_on(scratch, 0, tally);
    march.shade(&shader, canvas, scratch, shaded, sector.steps);
    scratch.pixels.finish(l, canvas, sector);
    scratch.befores = befores;
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
                roofs: &ground.roofs,
                colours: ground.colours.as_ref(),
                major,
                minor,
                major_axis: sector.major,
                eye_height: frame.eye.z as f32,
                eye_rest: (frame.eye.z - f64::from(frame.eye.z as f32)) as f32,
                highest: frame.highest + frame.rounding,
                rounding: frame.rounding,
                scale: scale as f32,
                ground_rise: frame.ground_rise * scale as f32,
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
        let bounds = [major, minor].map(|axis| [axis.begin, axis.line(axis.cells[1] + 1)]);
        let steepest = frame.levels.iter().zip(&fields);
        let steepest = steepest
            .map(|(level, field)| f64::from(level.steepest[1 - sector.major] / field.scale))
            .collect();
        for field in &mut fields {
            // Coarser cells may reach out over the ground's border: it ends where it ends; but no later, however
            // that is rounded, than at the last line, behind which there are no cells.
            let scale = field.scale;
            let end = |axis: &Axis, end: f32| (end / scale).min(axis.line(axis.cells[1] + 1));
            field.ends = [
                end(&field.major, bounds[0][1]),
                end(&field.minor, bounds[1][1]),
            ];
        }
        let spacing = frame.ground.grid().spacing.to_array();
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
            native: frame.detail.as_ref().map_or(0, |detail| detail.native),
            directions: Directions::new(frame, sector),
            oblong: spacing[1 - sector.major] / spacing[sector.major],
            vertical,
            steepest,
            bounds,
            straight_down: -STRAIGHT_DOWN * spacing[sector.major] as f32,
            least_major: 1.001 * STEEP * frame.rays.first.length(),
        }
    }

    /// Where a step's numbers begin in the scratch; lane 0 comes `MARGIN` later.
    fn slot(&self, step: u32) -> usize {
        step as usize % MEMORY * self.room
    }

    /// The first step of which rays are still on their way, or the one behind `step`.
    fn first_open(&self, step: u32, scratch: &Scratch) -> u32 {
        let shift = self.room.trailing_zeros();
        let mut back = None;
        self.l.vectorize(
            #[inline(always)]
            || {
                for waves in &scratch.waves {
                    for wave in [&waves.low, &waves.high] {
                        let steps_back =
                            |&id: &i32| step.wrapping_sub(id as u32 >> shift) % MEMORY as u32;
                        back = back.max(wave.ids().iter().map(steps_back).max());
                    }
                }
            },
        );
        back.map_or(step + 1, |back| step - back)
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
            scratch.sky[step as usize % MEMORY].clear();
            for first in (lanes[0]..lanes[1]).step_by(CHUNK) {
                let chunk = [first, lanes[1].min(first + CHUNK as i32)];
                let led = *scratch.led(step, first - lanes[0]);
                let led = led.map(|lane| lane.clamp(chunk[0], chunk[1]));
                for sky in [[first, led[0]], [led[1], chunk[1]]] {
                    if sky[0] < sky[1] {
                        let (colours, depths) = scratch.pixels.lanes_mut(step, sky[0]);
                        let directions = &self.directions;
                        let shading = &mut scratch.shading;
                        shader.shade_sky(self.l, directions, step, sky, shading, colours, depths);
                    }
                }
                let mut sees_sky = led != chunk;
                if led[0] < led[1] {
                    sees_sky |= self.shade_led(shader, step, led, scratch);
                }
                if sees_sky && !self.frame.coarsens {
                    let sky = &mut scratch.sky[step as usize % MEMORY];
                    sky.put((first - lanes[0]) as usize, chunk, led, &scratch.shading);
                }
            }
            scratch
                .pixels
                .finish_step(self.l, canvas, self.sector, step, lanes);
        }
        to.max(from)
    }

    /// Colours lanes of a step; gives whether some see the sky.
    #[inline(always)]
    fn shade_led(
        &self,
        shader: &Shader<'_>,
        step: u32,
        [first, behind]: [i32; 2],
        scratch: &mut Scratch,
    ) -> bool {
        let count = (behind - first) as usize;
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
                around(step + 1 < scratch.far_from.min(self.sector.steps), step + 1),
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
        shader.shade(self.l, &chunk, &mut scratch.shading, colours, depths)
    }

    /// Leads a chunk's rays that set out side by side on their first way.
    fn depart<T: Tally>(&self, count: usize, scratch: &mut Scratch, tally: &mut T) {
        // Only where they are of use, rays keep what ground they meet.
        match [scratch.keeps_patches, scratch.strips.are_kept()] {
            [false, false] => self.lead::<false, false>(count, scratch),
            [true, false] => self.lead::<true, false>(count, scratch),
            [false, true] => self.lead::<false, true>(count, scratch),
            [true, true] => self.lead::<true, true>(count, scratch),
        }
        for (at, led) in scratch.departure.led(count) {
            for rays in led {
                tally.cells_of(at as i32, rays);
            }
        }
    }

    #[inline(always)]
    fn lead<const KEEPS: bool, const STRIPS: bool>(&self, count: usize, scratch: &mut Scratch) {
        depart::<L, KEEPS, STRIPS>(
            self.l,
            &self.fields,
            &mut scratch.departure,
            &Step {
                count,
                advance: &scratch.advance,
                slope: &scratch.slope,
            },
            &mut scratch.waves,
            &mut scratch.passage,
            &mut scratch.reached,
            &mut scratch.patches,
            Strips {
                widths: scratch.strips.widths(),
                clear: &mut scratch.clear,
            },
        );
    }

    /// Leads rays on until no more than `unfinished` of them are on their way low, and as many
    /// high.
    fn go_on<T: Tally>(&self, scratch: &mut Scratch, unfinished: usize, tally: &mut T) {
        let l = self.l;
        let keeps_strips = scratch.strips.are_kept();
        let widths = scratch.strips.widths();
        while let Some((level, climbs)) = self.next_wave(scratch, unfinished) {
            let (waves, behind) = scratch.waves[level..].split_at_mut(1);
            let Waves { low, high } = &mut waves[0];
            let coarser = Coarser::behind(&self.fields, level, behind);
            tally.cells(if climbs { high.ids() } else { low.ids() });
            let field = &self.fields[level];
            let passage = &mut scratch.passage;
            if climbs {
                let climb = if keeps_strips {
                    climb::<L, true>
                } else {
                    climb::<L, false>
                };
                climb(l, field, high, low, passage, widths, coarser);
            } else {
                let (reached, patches) = (&mut scratch.reached, &mut scratch.patches);
                let strips = Strips {
                    widths,
                    clear: &mut scratch.clear,
                };
                let walk = match [scratch.keeps_patches, keeps_strips] {
                    [false, false] => walk::<L, false, false>,
                    [true, false] => walk::<L, true, false>,
                    [false, true] => walk::<L, false, true>,
                    [true, true] => walk::<L, true, true>,
                };
                walk(
                    l, field, low, high, passage, reached, patches, strips, coarser,
                );
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
}
