//! The rays that are on their way, closed up, so that groups of lanes are always full.

use crate::lanes::{LANES, Lanes};

/// One number of each ray.
#[derive(Default)]
pub(super) struct Column<T>(Vec<T>);

impl<T: Copy + Default> Column<T> {
    /// The numbers of the group that begins at ray `at`.
    #[inline(always)]
    pub(super) fn group(&self, at: usize) -> &[T; LANES] {
        self.0[at..].first_chunk().expect("room was made")
    }

    #[inline(always)]
    pub(super) fn group_mut(&mut self, at: usize) -> &mut [T; LANES] {
        self.0[at..].first_chunk_mut().expect("room was made")
    }

    pub(super) fn make_room(&mut self, rays: usize) {
        if self.0.len() < rays {
            self.0.resize(rays, T::default());
        }
    }
}

/// Sixteen rays, all running up the major axis by a cell for each 1 of their parameter t.
pub(super) struct Ray<L: Lanes> {
    /// Cells along the minor axis for each 1 of t, in [0, 1]; and one over it.
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
#[derive(Default)]
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

impl Wave {
    pub(super) fn make_room(&mut self, rays: usize) {
        let rays = rays + 2 * LANES;
        for column in [
            &mut self.advance,
            &mut self.inverse,
            &mut self.slope,
            &mut self.leave,
            &mut self.t,
        ] {
            column.make_room(rays);
        }
        for column in [
            &mut self.id,
            &mut self.major,
            &mut self.minor,
            &mut self.level,
        ] {
            column.make_room(rays);
        }
    }

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
        let left = self.len - at;
        if left >= LANES {
            u16::MAX
        } else {
            (1 << left) - 1
        }
    }

    #[inline(always)]
    pub(super) fn ray<L: Lanes>(&self, l: L, at: usize) -> Ray<L> {
        Ray {
            advance: l.load(self.advance.group(at)),
            inverse: l.load(self.inverse.group(at)),
            slope: l.load(self.slope.group(at)),
            leave: l.load(self.leave.group(at)),
            id: l.load_i(self.id.group(at)),
        }
    }

    #[inline(always)]
    pub(super) fn t<L: Lanes>(&self, l: L, at: usize) -> L::F {
        l.load(self.t.group(at))
    }

    #[inline(always)]
    pub(super) fn advance<L: Lanes>(&self, l: L, at: usize) -> L::F {
        l.load(self.advance.group(at))
    }

    #[inline(always)]
    pub(super) fn inverse<L: Lanes>(&self, l: L, at: usize) -> L::F {
        l.load(self.inverse.group(at))
    }

    #[inline(always)]
    pub(super) fn leave<L: Lanes>(&self, l: L, at: usize) -> L::F {
        l.load(self.leave.group(at))
    }

    /// The mirrored cell that each ray is in.
    #[inline(always)]
    pub(super) fn cell<L: Lanes>(&self, l: L, at: usize) -> [L::I; 2] {
        [
            l.load_i(self.major.group(at)),
            l.load_i(self.minor.group(at)),
        ]
    }

    #[inline(always)]
    pub(super) fn level<L: Lanes>(&self, l: L, at: usize) -> L::I {
        l.load_i(self.level.group(at))
    }

    pub(super) fn ids(&self) -> &[i32] {
        &self.id.0[..self.len]
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
        l.compress(mask, ray.advance, self.advance.group_mut(to));
        l.compress(mask, ray.inverse, self.inverse.group_mut(to));
        l.compress(mask, ray.slope, self.slope.group_mut(to));
        l.compress(mask, ray.leave, self.leave.group_mut(to));
        l.compress_i(mask, ray.id, self.id.group_mut(to));
        l.compress(mask, t, self.t.group_mut(to));
        l.compress_i(mask, major, self.major.group_mut(to));
        l.compress_i(mask, minor, self.minor.group_mut(to));
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
        l.compress_i(mask, level, self.level.group_mut(to));
        self.put(l, to, mask, ray, t, cell)
    }
}
