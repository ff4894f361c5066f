//! Sixteen planes at a time: the ground's profiles, line of posts by line, against the rays of each
//! plane.

use super::super::March;
use super::super::scratch::{MARGIN, MEMORY, Scratch};
use super::fan::Fan;
use crate::lanes::{LANES, Lanes};
use crate::planes::profile::{PASSED, PlaneGroup, ceiling, heights};

/// One number a plane.
type Each = [f32; LANES];

/// Planes' rays: directions as affine functions of how many steps they lie behind the first one in
/// which their plane is seen; and where they begin and end.
struct Rays {
    /// Metres up, and cells along the major axis.
    up: [Each; 2],
    major: [Each; 2],
    /// As [`PlaneGroup`] has it.
    advance: Each,
    /// The t at which planes come over the ground and leave it.
    enter: Each,
    leave: Each,
    /// In how many steps planes are seen, and where among the hits the first one goes.
    steps: Each,
    place: [i32; LANES],
    /// Which of the planes may meet ground, and from which t on.
    live: u16,
    start: f32,
}

impl Rays {
    /// The t from which on all planes are over the ground, and the one up to which they are.
    fn over_ground(&self) -> [f32; 2] {
        [
            self.enter.iter().copied().fold(0.0, f32::max),
            self.leave.iter().copied().fold(f32::INFINITY, f32::min),
        ]
    }
}

impl<L: Lanes> March<'_, L> {
    /// The rays of sixteen planes.
    fn plane_rays(&self, fan: &Fan, first: usize, scratch: &Scratch) -> Rays {
        let steep = self.steep();
        let [[major_begin, major_end], [minor_begin, minor_end]] = self.bounds;
        let top = self.fields[0].highest - self.fields[0].eye_height;
        let mut rays = Rays {
            up: [[0.0; LANES]; 2],
            major: [[0.0; LANES]; 2],
            advance: [0.0; LANES],
            enter: [0.0; LANES],
            leave: [0.0; LANES],
            steps: [0.0; LANES],
            place: [0; LANES],
            live: 0,
            start: f32::INFINITY,
        };
        for k in 0..LANES {
            let plane = first + k;
            let [begin, end] = fan.seen(plane);
            let is_seen = begin < end;
            let (begin, end) = if is_seen {
                (begin, end)
            } else {
                (fan.from, fan.to)
            };
            let lane = fan.lane(begin, plane);
            let d = self.directions.at_place(begin, lane);
            let step = self.directions.step - fan.back(plane) * self.directions.lane;
            let far = d + f64::from(end - begin) * step;
            let advance = (far.y.max(0.0) / far.x.max(steep)).min(1.0) as f32;
            rays.up[0][k] = d.z as f32;
            rays.up[1][k] = step.z as f32;
            rays.major[0][k] = d.x as f32;
            rays.major[1][k] = step.x as f32;
            rays.advance[k] = advance;
            let mut start = major_begin.max(0.0);
            if minor_begin > 0.0 {
                start = start.max(minor_begin / advance);
            }
            let leave = major_end.min(minor_end / advance);
            rays.enter[k] = start;
            rays.leave[k] = leave;
            if !is_seen {
                continue;
            }
            if top < 0.0 {
                let slope = (d.z / d.x.max(steep)) as f32;
                if slope >= 0.0 {
                    continue;
                }
                start = start.max(top / slope);
            }
            if begin == fan.from && begin > 0 {
                match self.seen_before(begin - 1, lane + fan.back(plane), scratch) {
                    Some(t) if t < 0.0 => continue,
                    Some(t) => start = start.max(t),
                    None => {}
                }
            }
            if start < leave {
                rays.live |= 1 << k;
                rays.start = rays.start.min(start);
                rays.steps[k] = (end - begin) as f32;
                rays.place[k] = ((begin - fan.from) as usize * fan.room() + plane) as i32;
            }
        }
        rays
    }

    /// How far the rays around a place in the step before a fan reach, at least: all that are
    /// higher see nothing nearer. Less than 0 where they meet nothing.
    fn seen_before(&self, step: u32, lane: f64, scratch: &Scratch) -> Option<f32> {
        let [from, to] = scratch.lanes[step as usize % MEMORY];
        if from >= to {
            return None;
        }
        let lane = lane.floor() as i32;
        let reached = [lane, lane + 1].map(|lane| {
            let lane = lane.clamp(from, to - 1) as usize;
            scratch.reached[self.slot(step) + MARGIN + lane]
        });
        let [least, most] = [reached[0].min(reached[1]), reached[0].max(reached[1])];
        Some(if least < 0.0 { most } else { least })
    }

    /// Finds how far the rays of sixteen planes reach, the first of which is plane `first`.
    #[inline(always)]
    pub(super) fn march(&self, fan: &Fan, first: usize, scratch: &Scratch, hits: &mut [f32]) {
        let l = self.l;
        let rays = self.plane_rays(fan, first, scratch);
        if rays.live == 0 {
            return;
        }
        let load = |numbers: &Each| l.load(numbers);
        let (up, up_step) = (load(&rays.up[0]), load(&rays.up[1]));
        let (major, major_step) = (load(&rays.major[0]), load(&rays.major[1]));
        let (enter, leave) = (load(&rays.enter), load(&rays.leave));
        let [last_enter, first_leave] = rays.over_ground();
        let planes = PlaneGroup {
            advance: load(&rays.advance),
            outer: [rays.advance[0], rays.advance[LANES - 1]],
        };
        let steps = load(&rays.steps);
        let (zero, one, tiny) = (l.splat(0.0), l.splat(1.0), l.splat(1e-30));
        let steep = l.splat(self.steep() as f32);
        let period = l.splat_i(fan.room() as i32);
        let (mut step, mut place) = (zero, l.load_i(&rays.place));
        let mut live = l.mask(rays.live);

        // All planes of a group are in one resolution, that which suits one of them.
        let middle = rays.live.trailing_zeros() as usize;
        let coarsest = self.fields.len() - 1;
        let cell = f64::from(self.frame.detail.as_ref().map_or(1.0, |detail| detail.cell));
        let width_at = |steps: f32| {
            let step = (fan.seen(first + middle)[0] + steps as u32).min(fan.to - 1);
            (cell * self.pixel_width(step, fan.lane(step, first + middle))) as f32
        };
        let level_at = |t: f32, width: f32| {
            let covered = (t * width).max(1.0);
            (((covered.to_bits() >> 23) - 127) as usize).min(coarsest)
        };
        let limit_of = |level: usize, width: f32| {
            if level < coarsest {
                (2 << level) as f32 / width
            } else {
                f32::INFINITY
            }
        };
        let width = width_at(0.0);
        let mut level = level_at(rays.start, width);
        let mut limit = limit_of(level, width);
        let mut field = &self.fields[level];
        let line = (rays.start / field.scale + field.major.fraction) as i32;
        let mut line = line.max(field.major.cells[0]);
        let mut t = line as f32 - field.major.fraction;
        let mut begin_height = heights(l, field, &planes, line, t);
        t *= field.scale;
        // Whether no ray has met ground since the last blocks began.
        let mut is_idle = true;
        loop {
            if t >= limit {
                let mut done = [0.0; LANES];
                l.store(step, &mut done);
                let width = width_at(done[middle]);
                let coarser = level_at(t, width);
                if coarser > level {
                    level = coarser;
                    field = &self.fields[level];
                    line = (t / field.scale + field.major.fraction + 1e-3) as i32;
                }
                limit = limit_of(level, width).max(t * 1.001);
            }
            if is_idle && field.major.is_block(line) {
                let rise = l.add(up, l.mul(step, up_step));
                let run = l.max(l.add(major, l.mul(step, major_step)), steep);
                let passes = |level: usize| {
                    let ceiling = ceiling(field, &planes, line, level)?;
                    let behind = line + (1 << level);
                    let end = (behind as f32 - field.major.fraction) * field.scale;
                    let ground = l.mul(l.splat(ceiling), run);
                    let below = l.and(
                        l.lt(ground, l.mul(rise, l.splat(t))),
                        l.lt(ground, l.mul(rise, l.splat(end))),
                    );
                    (end <= limit && l.bits(l.and_not(live, below)) == 0).then_some(behind)
                };
                if let Some(behind) = PASSED.into_iter().find_map(passes) {
                    line = behind;
                    t = line as f32 - field.major.fraction;
                    begin_height = heights(l, field, &planes, line, t);
                    t *= field.scale;
                    live = l.and(live, l.lt(l.splat(t), leave));
                    if l.bits(live) == 0 {
                        break;
                    }
                    continue;
                }
            }
            if field.major.is_block(line) {
                is_idle = true;
            }
            line += 1;
            if line > field.major.cells[1] + 1 {
                break;
            }
            let end = line as f32 - field.major.fraction;
            let end_height = heights(l, field, &planes, line, end);
            let end = end * field.scale;
            let (from, to) = (l.max(l.splat(t), enter), l.min(l.splat(end), leave));
            live = l.and(live, l.lt(from, leave));
            if l.bits(live) == 0 {
                break;
            }
            let mut here = l.and(live, l.lt(from, to));
            let (mut from_height, mut to_height) = (begin_height, end_height);
            if t < last_enter || first_leave < end {
                // The ground begins or ends between the lines.
                let rise = l.sub(end_height, begin_height);
                let rise = l.mul(rise, l.splat(1.0 / (end - t)));
                from_height = l.add(begin_height, l.mul(rise, l.sub(from, l.splat(t))));
                to_height = l.add(begin_height, l.mul(rise, l.sub(to, l.splat(t))));
            }
            loop {
                let rise = l.add(up, l.mul(step, up_step));
                let run = l.max(l.add(major, l.mul(step, major_step)), steep);
                let under = l.sub(l.mul(to_height, run), l.mul(rise, to));
                here = l.and(here, l.le(zero, under));
                if l.bits(here) == 0 {
                    break;
                }
                let over = l.max(l.sub(l.mul(rise, from), l.mul(from_height, run)), zero);
                let share = l.div(over, l.max(l.add(over, under), tiny));
                let hit = l.add(from, l.mul(l.sub(to, from), share));
                l.scatter(here, place, hit, hits);
                is_idle = false;
                place = l.add_i_where(here, place, period);
                step = l.select(here, l.add(step, one), step);
                here = l.and(here, l.lt(step, steps));
            }
            live = l.and(live, l.lt(step, steps));
            t = end;
            begin_height = end_height;
        }
    }
}
