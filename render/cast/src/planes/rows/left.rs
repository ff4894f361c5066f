//! What is left of a step's rays when most of them have been told where they meet the ground: closed up, and
//! put on its way.

use super::March;
use super::scratch::{MARGIN, Scratch};
use crate::lanes::{LANES, Lanes, group, group_mut};
use crate::planes::wave::{CHUNK, Ray, first_lanes};
use bytemuck::cast_mut;

/// Added to the number of a ray that has passed the cell that was looked at.
const PASSED: i32 = 1 << 30;

/// Up to where rays are clear of which no ray before tells: in no cell.
pub(super) const UNKNOWN: f32 = -2.0;

/// The most rays that wait to be put on their way.
const MOST: usize = CHUNK + LANES;

/// What tells a chunk's rays where they meet the ground, group by group; and rays that do so elsewhere, closed up: a
/// number a ray.
// On a page's border, as `Numbers` are.
#[repr(align(4096))]
pub(in crate::planes) struct Left {
    /// Of each group of a chunk, the first ray's direction, component by component; and for how much more of the
    /// way rays are clear than those before them came, as a [`Predecessor`](super::predecessor::Predecessor) has it.
    pub(super) directions: [[f32; CHUNK / LANES]; 3],
    pub(super) further: [f32; CHUNK / LANES],
    /// Of each group of a chunk, which rays are left, and which have passed the cells that were looked at, or end in
    /// them.
    pub(super) masks: [u16; CHUNK / LANES],
    pub(super) passed: [u16; CHUNK / LANES],
    len: usize,
    /// Where its result goes, and [`PASSED`] where it has passed the cell that was looked at: then it stands on a line
    /// behind that.
    id: [i32; MOST],
    advance: [f32; MOST],
    slope: [f32; MOST],
    /// Up to where it is clear. Negative where no ray before it tells; or, if it has passed, where that
    /// line is one of the minor axis, along which it is this far then.
    start: [f32; MOST],
}

impl Default for Left {
    fn default() -> Self {
        Self {
            directions: [[0.0; CHUNK / LANES]; 3],
            further: [0.0; CHUNK / LANES],
            masks: [0; CHUNK / LANES],
            passed: [0; CHUNK / LANES],
            len: 0,
            id: [0; MOST],
            advance: [0.0; MOST],
            slope: [0.0; MOST],
            start: [0.0; MOST],
        }
    }
}

impl<L: Lanes> March<'_, L> {
    /// Which of a chunk's rays have been told what they meet: groups, by their first ray's number, and a bit a ray.
    pub(super) fn told(
        &self,
        step: u32,
        [first, behind]: [i32; 2],
        scratch: &Scratch,
    ) -> impl Iterator<Item = (usize, u16)> {
        let at = self.slot(step) + MARGIN;
        let groups = (first..behind).step_by(LANES).zip(&scratch.left.masks);
        groups.map(move |(lane, left)| (at + lane as usize, first_lanes(behind - lane) & !left))
    }

    /// Closes up the rays that are left of a chunk.
    pub(super) fn close_up(&self, step: u32, [first, behind]: [i32; 2], scratch: &mut Scratch) {
        let l = self.l;
        l.vectorize(
            #[inline(always)]
            || {
                let left = &mut *scratch.left;
                let mut len = 0;
                for lane in (first..behind).step_by(LANES) {
                    let number = (lane - first) as usize / LANES;
                    let mask = l.mask(left.masks[number]);
                    let passed = l.mask(left.passed[number]);
                    let at = self.slot(step) + MARGIN + lane as usize;
                    let bits = |numbers: &[f32]| l.bits_of_float(l.load(group(numbers, at)));
                    let values = [
                        l.add_i_where(passed, self.ids(at), l.splat_i(PASSED)),
                        bits(&scratch.advance),
                        bits(&scratch.slope),
                        bits(&scratch.reached),
                    ];
                    let columns = [
                        group_mut(&mut left.id, len),
                        cast_mut(group_mut(&mut left.advance, len)),
                        cast_mut(group_mut(&mut left.slope, len)),
                        cast_mut(group_mut(&mut left.start, len)),
                    ];
                    l.compress_all(mask, values, columns);
                    len += l.bits(mask).count_ones() as usize;
                }
                left.len = len;
            },
        );
    }

    /// Puts the rays of a chunk on their way that are left; gives how many of those that meet ground
    /// they are, about.
    pub(super) fn send_left(&self, chunk: [i32; 2], scratch: &mut Scratch) -> Share {
        let l = self.l;
        l.vectorize(
            #[inline(always)]
            || {
                let field = &self.fields[0];
                let (zero, one) = (l.splat(0.0), l.splat(1.0));
                let mut near_ground = 0;
                for at in (0..scratch.left.len).step_by(LANES) {
                    let all = l.mask(first_lanes((scratch.left.len - at) as i32));
                    let left = &scratch.left;
                    let id_and_passed = l.load_i(group(&left.id, at));
                    let id = l.and_i(id_and_passed, l.splat_i(PASSED - 1));
                    let advance = l.load(group(&left.advance, at));
                    let slope = l.load(group(&left.slope, at));
                    let start = l.load(group(&left.start, at));
                    let inverse = l.div(one, advance);
                    let stay = self.stay(all, inverse, slope);
                    let ray = Ray {
                        advance,
                        inverse,
                        slope,
                        leave: stay.leave,
                        id,
                    };
                    l.scatter(all, id, stay.nothing(l), &mut scratch.reached);
                    // Those that passed a cell stand on a line of the one or the other axis.
                    let passed = l.gt_i(id_and_passed, l.splat_i(PASSED - 1));
                    let crosses_major = l.le(zero, start);
                    let known = l.and(stay.ok, l.or(passed, crosses_major));
                    let fresh = l.and_not(stay.ok, known);
                    let crosses_minor = l.and_not(passed, crosses_major);
                    let crosses_major = l.and(passed, crosses_major);
                    let on_minor = l.mul(l.sub(zero, start), inverse);
                    let start = l.select(crosses_minor, on_minor, start);
                    let near = l.and(known, l.lt(start, stay.leave));
                    let cell = field.cell_behind(l, start, advance, [crosses_major, crosses_minor]);
                    scratch.waves[0].low.push(l, near, &ray, start, cell);
                    near_ground += l.bits(near).count_ones() as usize;
                    if l.bits(fresh) != 0 {
                        self.begin_fresh(scratch, fresh, &ray, &stay);
                    }
                }
                Share {
                    part: near_ground,
                    all: (chunk[1] - chunk[0]) as usize - scratch.left.len + near_ground,
                }
            },
        )
    }
}

/// So many of all.
#[derive(Clone, Copy, Default)]
pub(super) struct Share {
    pub(super) part: usize,
    pub(super) all: usize,
}

impl std::ops::AddAssign for Share {
    fn add_assign(&mut self, other: Self) {
        self.part += other.part;
        self.all += other.all;
    }
}

impl Share {
    pub(super) fn of(self) -> f32 {
        self.part as f32 / self.all as f32
    }
}
