//! Planes side by side: the ground's profiles, line of posts by line.

use super::super::March;
use super::super::scratch::Scratch;
use super::fan::Fan;
use super::rays::Rays;
use super::resolution::Resolution;
use super::sight::{SAME, Sight, Start};
use crate::lanes::{LANES, Lanes};
use crate::planes::profile::{Mark, parts_between, passed};

/// Planes that are led at once: a processor does one half's work while it waits for the other's.
pub(super) const PLANES: usize = 2 * LANES;

/// By how much of a pixel the ground may lie beside a bent profile, which is straight where a twisted cell is a
/// parabola: where it lies farther, profiles are looked at between lines, too, in up to 2 ^ [`MOST_PARTS`] parts
/// of a cell.
const ASIDE: f32 = 0.75;
const MOST_PARTS: u32 = 6;

/// How many pixels planes may see of the way from one line to the next.
const TALL: f32 = 4.0;

/// For how many lines nothing has been seen before it is asked whether blocks may be passed.
const IDLE: u32 = 4;

/// How far planes have been led.
struct Way {
    at: Resolution,
    /// Cells along the minor axis for each one along the major axis, of the first plane and of the last one.
    outer: [f32; 2],
    /// As [`Sight::look`] has it.
    same: f32,
    /// The plane in their midst: its lane, and whether that is one of the first sixteen.
    lane: usize,
    is_left: bool,
    /// The last line, and its t.
    line: i32,
    t: f32,
    /// Whether what lies before this line has not been looked at, so that its heights are not known;
    /// and for how many lines nothing has been seen.
    has_skipped: bool,
    idle: u32,
}

impl<L: Lanes> March<'_, L> {
    /// How wide a pixel is of a plane, as [`Resolution`] has it, some steps behind the first in which
    /// the plane is seen.
    fn width_at(&self, fan: &Fan, plane: usize, cell: f64, steps: f32) -> f32 {
        let step = (fan.seen(plane)[0] + steps as u32).min(fan.to - 1);
        (cell * self.pixel_width(step, fan.lane(step, plane))) as f32
    }

    /// Finds what [`PLANES`] planes see, the first of which is plane `first`. Gives the step from
    /// which on all of them see the sky, which is not written there.
    ///
    /// A pixel's colour is the mean of its plane's between the pixel's borders: of what of each piece
    /// of the profile rises over the horizon, in proportion to how much.
    ///
    /// Apart, as it is the longest of all kernels, and its caller is compiled for each `Tally`.
    pub(super) fn march(
        &self,
        fan: &Fan,
        first: usize,
        scratch: &Scratch,
        seen: &mut [[i32; 2]],
    ) -> u32 {
        let l = self.l;
        l.vectorize(
            #[inline(always)]
            || {
                let rays = [
                    self.plane_rays(fan, first, scratch),
                    self.plane_rays(fan, first + LANES, scratch),
                ];
                let start = Start {
                    steep: self.steep() as f32,
                    nearest: self.nearest_place(),
                    period: fan.room(),
                };
                let field = &self.fields[0];
                let walls = [self.walls(&rays[0]), self.walls(&rays[1])];
                let mut left = Sight::new(l, field, &rays[0], &walls[0], &start);
                let mut right = Sight::new(l, field, &rays[1], &walls[1], &start);
                if rays[0].live != 0 || rays[1].live != 0 {
                    let sights = [&mut left, &mut right];
                    let way = self.way(fan, first, &rays);
                    let way = if way.at.is_bent {
                        let way = self.go_along::<true>(fan, way, sights, seen);
                        left.straighten(l);
                        right.straighten(l);
                        way
                    } else {
                        Some(way)
                    };
                    if let Some(way) = way {
                        self.go_along::<false>(fan, way, [&mut left, &mut right], seen);
                    }
                }
                let mut skies = [[0; LANES]; 2];
                l.store_i(left.end(l, seen), &mut skies[0]);
                l.store_i(right.end(l, seen), &mut skies[1]);
                fan.clear_skies(first, &skies, seen)
            },
        )
    }

    /// The t as [`Start`] has it: the ten-thousandth part of the way down to the ground, as slopes of ground that
    /// planes come over there are ten thousand then, at most; or where the ground begins, from an eye beside it. But
    /// no more than a small part of a cell.
    fn nearest_place(&self) -> f32 {
        const MOST: f32 = 0.03125;
        let eye = self.frame.view.eye;
        let ground = self.frame.ground;
        let nearest = match ground.height_at(eye.x, eye.y) {
            Some(height) => (1e-4 * (eye.z - height) / ground.grid().cell_length()) as f32,
            None => self.bounds[0][0].max(self.bounds[1][0]),
        };
        nearest.clamp(1e-6, MOST)
    }

    /// Where planes begin, of which the first is plane `first`, and some may meet ground.
    fn way(&self, fan: &Fan, first: usize, rays: &[Rays; 2]) -> Way {
        let is_left = rays[0].live != 0;
        let among = if is_left { rays[0].live } else { rays[1].live };
        let lane = among.trailing_zeros() as usize;
        let plane = first + lane + if is_left { 0 } else { LANES };
        let cell = f64::from(self.frame.detail.as_ref().map_or(1.0, |detail| detail.cell));
        let start = rays[0].start.min(rays[1].start);
        let width = self.width_at(fan, plane, cell, 0.0);
        let outer = [rays[0].advance[0], rays[1].advance[LANES - 1]];
        let cell_length = self.frame.ground.grid().spacing.max_element() as f32;
        let mut at = Resolution {
            plane,
            cell,
            width,
            metres: cell_length / cell as f32,
            native: self.native,
            coarsest: self.fields.len() - 1,
            suited: 0,
            level: 0,
            is_bent: true,
            limit: 0.0,
            // A parabola lies as far beside its chord as a quarter of what the twist makes of its extent.
            twist: 4.0 * ASIDE * width / cell as f32 * cell_length
                / outer[0].max(outer[1]).max(f32::MIN_POSITIVE),
        };
        self.suit(&mut at, start, outer);
        let field = &self.fields[at.level];
        let line = (start / field.scale + field.major.fraction) as i32;
        let line = line.max(field.major.cells[0]);
        Way {
            outer,
            same: 1.0 + SAME * at.width / cell as f32,
            lane,
            is_left,
            line,
            t: (line as f32 - field.major.fraction) * field.scale,
            has_skipped: true,
            idle: IDLE,
            at,
        }
    }

    /// Leads planes on, from line to line, with profiles that are bent between these, or straight; gives
    /// where the first ones are to be led on as the others.
    #[inline(always)]
    fn go_along<const BENT: bool>(
        &self,
        fan: &Fan,
        way: Way,
        [left, right]: [&mut Sight<L>; 2],
        seen: &mut [[i32; 2]],
    ) -> Option<Way> {
        let l = self.l;
        let Way {
            mut at,
            outer,
            same,
            lane,
            is_left,
            mut line,
            mut t,
            mut has_skipped,
            mut idle,
        } = way;
        let mut field = &self.fields[at.level];
        while l.bits(l.or(left.live, right.live)) != 0 {
            if t >= at.limit {
                let mut done = [0.0; LANES];
                l.store(if is_left { left.border } else { right.border }, &mut done);
                at.width = self.width_at(fan, at.plane, at.cell, done[lane]);
                if self.suit(&mut at, t, outer) {
                    field = &self.fields[at.level];
                    line = (t / field.scale + field.major.fraction + 1e-3) as i32;
                    has_skipped |= BENT && at.is_bent;
                }
                if BENT && !at.is_bent {
                    return Some(Way {
                        at,
                        outer,
                        same,
                        lane,
                        is_left,
                        line,
                        t,
                        has_skipped,
                        idle,
                    });
                }
            }
            if idle >= IDLE && field.major.is_block(line) {
                // Apart, and made for the instruction set: it is seldom asked for. It gets copies, as
                // what it might reach would have to lie in memory, all of the time.
                let (outlooks, limit) = ([left.outlook(), right.outlook()], at.limit);
                let passed = l.vectorize(
                    #[inline(always)]
                    move || passed(l, field, outlooks, line, limit),
                );
                if let Some(behind) = passed {
                    line = behind;
                    t = (line as f32 - field.major.fraction) * field.scale;
                    left.stay_over_ground(l, t);
                    right.stay_over_ground(l, t);
                    has_skipped = true;
                    continue;
                }
            }
            if has_skipped {
                left.skip_to::<BENT>(l, field, line, t);
                right.skip_to::<BENT>(l, field, line, t);
                has_skipped = false;
            }
            line += 1;
            if line > field.major.cells[1] + 1 {
                break;
            }
            let end = (line as f32 - field.major.fraction) * field.scale;
            // Both are read before either is looked at.
            let here = left.line::<BENT>(l, field, line, end);
            let other_here = right.line::<BENT>(l, field, line, end);
            if at.may_be_closer() {
                // Apart as above.
                let rises = [left.rise(&here), right.rise(&other_here)];
                let is_tall = l.vectorize(
                    #[inline(always)]
                    move || rises[0].is_tall(l, TALL) || rises[1].is_tall(l, TALL),
                );
                if is_tall {
                    // Up to this line, with closer ones.
                    at.come_closer(end);
                    field = &self.fields[at.level];
                    line = (t / field.scale + field.major.fraction + 1e-3) as i32;
                    if BENT {
                        has_skipped = true;
                    } else {
                        left.recolour(l, field, line);
                        right.recolour(l, field, line);
                    }
                    continue;
                }
            }
            let (mut some_is_seen, mut to_a_cell) = (false, 1.0);
            if BENT && at.twist * t < self.frame.levels[0].twist {
                // Apart as above.
                let stretches = [left.stretch(&here), right.stretch(&other_here)];
                let allowed = at.twist * t;
                let parts = l.vectorize(
                    #[inline(always)]
                    move || parts_between(l, field, stretches, allowed, MOST_PARTS),
                );
                if parts > 1 {
                    to_a_cell = parts as f32;
                    for k in 1..parts {
                        let mark = Mark {
                            line: line - 1,
                            part: k as f32 / to_a_cell,
                        };
                        let place = (line - 1) as f32 - field.major.fraction + mark.part;
                        let between = [t, place * field.scale];
                        t = between[1];
                        let there = left.place(l, field, mark, t);
                        some_is_seen |=
                            left.look::<true>(l, field, there, between, to_a_cell, same, seen);
                        let there = right.place(l, field, mark, t);
                        some_is_seen |=
                            right.look::<true>(l, field, there, between, to_a_cell, same, seen);
                    }
                }
            }
            let between = [t, end];
            let is_seen = left.look::<BENT>(l, field, here, between, to_a_cell, same, seen);
            let other_is_seen =
                right.look::<BENT>(l, field, other_here, between, to_a_cell, same, seen);
            idle = if some_is_seen || is_seen || other_is_seen {
                0
            } else {
                idle + 1
            };
            t = end;
        }
        None
    }
}
