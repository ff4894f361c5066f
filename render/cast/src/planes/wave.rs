//! The rays that are on their way, closed up, so that groups of lanes are always full.

use crate::lanes::{LANES, Lanes, group, group_mut};
use bytemuck::cast_mut;

/// Rays that a wave holds at most: a chunk of a step, what is left of earlier ones, and a group.
pub(super) const CAPACITY: usize = CHUNK + 16 * LANES;

/// Rays that set out at once at most.
pub(super) const CHUNK: usize = 1024;

/// The first `count` lanes of a group, or all where there are more.
pub(super) fn first_lanes(count: i32) -> u16 {
    if count >= LANES as i32 {
        u16::MAX
    } else {
        (1 << count) - 1
    }
}

/// Those of the sixteen lanes from `first` on that are of `lanes`.
pub(super) fn same_lanes(lanes: [i32; 2], first: i32) -> u16 {
    let from = (lanes[0] - first).clamp(0, LANES as i32);
    let to = (lanes[1] - first).clamp(from, LANES as i32);
    first_lanes(to) & !first_lanes(from)
}

/// One number of each ray.
pub(super) type Column<T> = [T; CAPACITY];

/// Sixteen rays, all running up the major axis by a cell for each 1 of their parameter t.
pub(super) struct Ray<L: Lanes> {
    /// Cells along the minor axis for each 1 of t, not below 0; and one over it.
    pub(super) advance: L::F,
    pub(super) inverse: L::F,
    /// Metres upwards for each 1 of t.
    pub(super) slope: L::F,
    /// The t at which the ray has left all ground.
    pub(super) leave: L::F,
    /// Where its result goes.
    pub(super) id: L::I,
}

/// Rays on their way. Beside what a [`Ray`] is, each has its t and the mirrored cell that it is in
/// there; and a level of blocks, where it skips blocks.
// On a page's border, as `Numbers` are.
#[repr(align(4096))]
pub(super) struct Wave {
    len: usize,
    advance: Column<f32>,
    inverse: Column<f32>,
    slope: Column<f32>,
    leave: Column<f32>,
    id: Column<i32>,
    t: Column<f32>,
    major: Column<i32>,
    minor: Column<i32>,
    level: Column<i32>,
}

impl Default for Wave {
    fn default() -> Self {
        Self {
            len: 0,
            advance: [0.0; CAPACITY],
            inverse: [0.0; CAPACITY],
            slope: [0.0; CAPACITY],
            leave: [0.0; CAPACITY],
            id: [0; CAPACITY],
            t: [0.0; CAPACITY],
            major: [0; CAPACITY],
            minor: [0; CAPACITY],
            level: [0; CAPACITY],
        }
    }
}

impl Wave {
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Leaves only the first `len` rays.
    #[inline(always)]
    pub(super) fn truncate(&mut self, len: usize) {
        self.len = len;
    }

    /// Which lanes of the group that begins at ray `at` are rays.
    #[inline(always)]
    pub(super) fn mask(&self, at: usize) -> u16 {
        first_lanes((self.len - at) as i32)
    }

    #[inline(always)]
    pub(super) fn ray<L: Lanes>(&self, l: L, at: usize) -> Ray<L> {
        Ray {
            advance: l.load(group(&self.advance, at)),
            inverse: l.load(group(&self.inverse, at)),
            slope: l.load(group(&self.slope, at)),
            leave: l.load(group(&self.leave, at)),
            id: l.load_i(group(&self.id, at)),
        }
    }

    #[inline(always)]
    pub(super) fn t<L: Lanes>(&self, l: L, at: usize) -> L::F {
        l.load(group(&self.t, at))
    }

    /// The mirrored cell that each ray is in.
    #[inline(always)]
    pub(super) fn cell<L: Lanes>(&self, l: L, at: usize) -> [L::I; 2] {
        [
            l.load_i(group(&self.major, at)),
            l.load_i(group(&self.minor, at)),
        ]
    }

    /// Moves a group's rays to t in a cell.
    #[inline(always)]
    pub(super) fn set_place<L: Lanes>(&mut self, l: L, at: usize, t: L::F, cell: [L::I; 2]) {
        l.store(t, group_mut(&mut self.t, at));
        self.set_cell(l, at, cell);
    }

    #[inline(always)]
    pub(super) fn set_cell<L: Lanes>(&mut self, l: L, at: usize, [major, minor]: [L::I; 2]) {
        l.store_i(major, group_mut(&mut self.major, at));
        l.store_i(minor, group_mut(&mut self.minor, at));
    }

    #[inline(always)]
    pub(super) fn set_level<L: Lanes>(&mut self, l: L, at: usize, level: L::I) {
        l.store_i(level, group_mut(&mut self.level, at));
    }

    #[inline(always)]
    pub(super) fn level<L: Lanes>(&self, l: L, at: usize) -> L::I {
        l.load_i(group(&self.level, at))
    }

    pub(super) fn ids(&self) -> &[i32] {
        &self.id[..self.len]
    }

    /// Writes the rays of `mask`, closed up, at `to`; gives where the next go.
    #[inline(always)]
    pub(super) fn put<L: Lanes>(
        &mut self,
        l: L,
        to: usize,
        mask: L::M,
        ray: &Ray<L>,
        t: L::F,
        [major, minor]: [L::I; 2],
    ) -> usize {
        if l.bits(mask) == u16::MAX {
            // All of them: the usual case for rays that set out, and it needs no closing up.
            l.store(ray.advance, group_mut(&mut self.advance, to));
            l.store(ray.inverse, group_mut(&mut self.inverse, to));
            l.store(ray.slope, group_mut(&mut self.slope, to));
            l.store(ray.leave, group_mut(&mut self.leave, to));
            l.store_i(ray.id, group_mut(&mut self.id, to));
            l.store(t, group_mut(&mut self.t, to));
            l.store_i(major, group_mut(&mut self.major, to));
            l.store_i(minor, group_mut(&mut self.minor, to));
            return to + LANES;
        }
        self.close_up(l, to, mask, ray, t, [major, minor])
    }

    /// As `put`, for where it is not foreseen whether rays stay together: then asking takes longer than
    /// closing up.
    #[inline(always)]
    pub(super) fn close_up<L: Lanes>(
        &mut self,
        l: L,
        to: usize,
        mask: L::M,
        ray: &Ray<L>,
        t: L::F,
        [major, minor]: [L::I; 2],
    ) -> usize {
        let values = [
            l.bits_of_float(ray.advance),
            l.bits_of_float(ray.inverse),
            l.bits_of_float(ray.slope),
            l.bits_of_float(ray.leave),
            ray.id,
            l.bits_of_float(t),
            major,
            minor,
        ];
        let columns = [
            cast_mut(group_mut(&mut self.advance, to)),
            cast_mut(group_mut(&mut self.inverse, to)),
            cast_mut(group_mut(&mut self.slope, to)),
            cast_mut(group_mut(&mut self.leave, to)),
            group_mut(&mut self.id, to),
            cast_mut(group_mut(&mut self.t, to)),
            group_mut(&mut self.major, to),
            group_mut(&mut self.minor, to),
        ];
        l.compress_all(mask, values, columns);
        to + l.bits(mask).count_ones() as usize
    }

    /// As `put`, with a level of blocks.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "what a ray is made of")]
    pub(super) fn put_at_level<L: Lanes>(
        &mut self,
        l: L,
        to: usize,
        mask: L::M,
        ray: &Ray<L>,
        t: L::F,
        cell: [L::I; 2],
        level: L::I,
    ) -> usize {
        self.close_up_levels(l, to, mask, level);
        self.put(l, to, mask, ray, t, cell)
    }

    /// Closes up levels of blocks, as `close_up` does with the rays that have them.
    #[inline(always)]
    pub(super) fn close_up_levels<L: Lanes>(&mut self, l: L, to: usize, mask: L::M, level: L::I) {
        l.compress_i(mask, level, group_mut(&mut self.level, to));
    }

    /// Adds the rays of `mask`.
    #[inline(always)]
    pub(super) fn push<L: Lanes>(
        &mut self,
        l: L,
        mask: L::M,
        ray: &Ray<L>,
        t: L::F,
        cell: [L::I; 2],
    ) {
        self.len = self.put(l, self.len, mask, ray, t, cell);
    }

    /// As `push`, with a level of blocks.
    #[inline(always)]
    pub(super) fn push_at_level<L: Lanes>(
        &mut self,
        l: L,
        mask: L::M,
        ray: &Ray<L>,
        t: L::F,
        cell: [L::I; 2],
        level: L::I,
    ) {
        self.len = self.put_at_level(l, self.len, mask, ray, t, cell, level);
    }
}

/// Rays over one resolution: those that go from cell to cell, and those that skip blocks.
#[derive(Default)]
pub(super) struct Waves {
    pub(super) low: Box<Wave>,
    pub(super) high: Box<Wave>,
}

impl Waves {
    pub(super) fn len(&self) -> usize {
        self.low.len() + self.high.len()
    }
}
