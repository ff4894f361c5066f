//! Planes side by side: the ground's profiles, line of posts by line.

use super::super::March;
use super::super::scratch::Scratch;
use super::fan::Fan;
use super::rays::Rays;
use super::sight::{Outlook, SAME, Sight};
use crate::lanes::{LANES, Lanes};
use crate::planes::field::Field;
use crate::planes::profile::{PASSED, ceiling};

/// Planes that are led at once: a processor does one half's work while it waits for the other's.
pub(super) const PLANES: usize = 2 * LANES;

/// How many cells of the finest level a pixel may cover before the next one is taken; of the others
/// it is two. Where pixels are hardly wider than posts, these are nearer to the truth than anything
/// that is made of them.
const FINEST: f32 = 2.6;

/// In which of the ground's resolutions planes are: in the one that suits a plane in their midst.
struct Resolution {
    plane: usize,
    /// Pixels to a cell, at most, and how wide a pixel is for each 1 of t, times that.
    cell: f64,
    width: f32,
    coarsest: usize,
    level: usize,
    /// The t up to which it suits.
    limit: f32,
}

impl Resolution {
    fn suiting(&self, t: f32) -> usize {
        let covered = t * self.width;
        if covered < FINEST {
            0
        } else {
            (((covered.to_bits() >> 23) - 127) as usize).min(self.coarsest)
        }
    }

    fn limit(&self) -> f32 {
        if self.level == self.coarsest {
            f32::INFINITY
        } else if self.level == 0 {
            FINEST / self.width
        } else {
            (2 << self.level) as f32 / self.width
        }
    }
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
    #[inline(always)]
    pub(super) fn march(
        &self,
        fan: &Fan,
        first: usize,
        scratch: &Scratch,
        seen: &mut [[i32; 2]],
    ) -> u32 {
        let l = self.l;
        let rays = [
            self.plane_rays(fan, first, scratch),
            self.plane_rays(fan, first + LANES, scratch),
        ];
        let steep = self.steep() as f32;
        let mut left = Sight::new(l, &rays[0], steep, fan.room());
        let mut right = Sight::new(l, &rays[1], steep, fan.room());
        if rays[0].live != 0 || rays[1].live != 0 {
            self.go_along(fan, first, &rays, [&mut left, &mut right], seen);
        }
        let mut skies = [[0; LANES]; 2];
        l.store_i(left.end(l, seen), &mut skies[0]);
        l.store_i(right.end(l, seen), &mut skies[1]);
        fan.clear_skies(first, &skies, seen)
    }

    #[inline(always)]
    fn go_along(
        &self,
        fan: &Fan,
        first: usize,
        rays: &[Rays; 2],
        [left, right]: [&mut Sight<L>; 2],
        seen: &mut [[i32; 2]],
    ) {
        let l = self.l;
        let is_left = rays[0].live != 0;
        let among = if is_left { rays[0].live } else { rays[1].live };
        let lane = among.trailing_zeros() as usize;
        let plane = first + lane + if is_left { 0 } else { LANES };
        let cell = f64::from(self.frame.detail.as_ref().map_or(1.0, |detail| detail.cell));
        let start = rays[0].start.min(rays[1].start);
        let mut at = Resolution {
            plane,
            cell,
            width: self.width_at(fan, plane, cell, 0.0),
            coarsest: self.fields.len() - 1,
            level: 0,
            limit: 0.0,
        };
        at.level = at.suiting(start);
        at.limit = at.limit();
        let same = 1.0 + SAME * at.width / cell as f32;
        let mut field = &self.fields[at.level];
        let line = (start / field.scale + field.major.fraction) as i32;
        let mut line = line.max(field.major.cells[0]);
        let mut t = (line as f32 - field.major.fraction) * field.scale;
        // Whether what lies before this line has not been looked at, so that its heights are not known;
        // and whether nothing was seen since the last blocks began.
        let mut has_skipped = true;
        let mut is_idle = true;
        while l.bits(l.or(left.live, right.live)) != 0 {
            if t >= at.limit {
                let mut done = [0.0; LANES];
                l.store(if is_left { left.border } else { right.border }, &mut done);
                at.width = self.width_at(fan, at.plane, at.cell, done[lane]);
                let coarser = at.suiting(t);
                if coarser > at.level {
                    at.level = coarser;
                    field = &self.fields[at.level];
                    line = (t / field.scale + field.major.fraction + 1e-3) as i32;
                }
                at.limit = at.limit().max(t * 1.001);
            }
            if field.major.is_block(line) {
                if is_idle {
                    // Apart, and made for the instruction set: it is seldom asked for. It gets copies, as
                    // what it might reach would have to lie in memory, all of the time.
                    let (outlooks, limit) = ([left.outlook(), right.outlook()], at.limit);
                    let passed = l.vectorize(
                        #[inline(always)]
                        move || passed(l, field, outlooks, line, t, limit),
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
                is_idle = true;
            }
            if has_skipped {
                left.skip_to(l, field, line, t);
                right.skip_to(l, field, line, t);
                has_skipped = false;
            }
            line += 1;
            if line > field.major.cells[1] + 1 {
                break;
            }
            let end = (line as f32 - field.major.fraction) * field.scale;
            let mut piece = left.piece(l, field, line, [t, end]);
            let mut other = right.piece(l, field, line, [t, end]);
            if l.bits(l.or(piece.visible, other.visible)) != 0 {
                is_idle = false;
                let mut paint = left.paint(l, field, &piece);
                let mut other_paint = right.paint(l, field, &other);
                if L::IS_ONE_REGISTER {
                    loop {
                        let over = left.over(l, &piece);
                        let other_over = right.over(l, &other);
                        if l.bits(l.or(over, other_over)) == 0 {
                            break;
                        }
                        left.finish(l, over, &mut piece, &mut paint, same, seen);
                        right.finish(l, other_over, &mut other, &mut other_paint, same, seen);
                    }
                } else {
                    // Sixteen are enough to do at once, and seldom have as many borders to pass as the others.
                    left.finish_all(l, &mut piece, &mut paint, same, seen);
                    right.finish_all(l, &mut other, &mut other_paint, same, seen);
                }
                left.add(l, &piece, &paint);
                right.add(l, &other, &other_paint);
            }
            left.leave_behind(&piece);
            right.leave_behind(&other);
            t = end;
        }
    }
}

/// Behind which line planes are that pass, at the mirrored line `line` in `t`, the largest blocks
/// that end before `limit` and whose ground is hidden from all of them.
#[inline(always)]
fn passed<L: Lanes>(
    l: L,
    field: &Field<'_>,
    [left, right]: [Outlook<L>; 2],
    line: i32,
    t: f32,
    limit: f32,
) -> Option<i32> {
    for level in PASSED {
        let behind = line + (1 << level);
        let end = (behind as f32 - field.major.fraction) * field.scale;
        if end <= limit
            && let Some(ceiling) = ceiling(field, [left.outer, right.outer], line, level)
            && left.hides(l, ceiling, [t, end])
            && right.hides(l, ceiling, [t, end])
        {
            return Some(behind);
        }
    }
    None
}
