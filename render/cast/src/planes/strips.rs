//! The ground in strips: between the vertical planes of rays that are neighbours in a step.

use super::field::Field;
use super::patches::Patch;
use super::walk::Crossing;
use super::wave::Ray;
use crate::lanes::{Lanes, group_mut};

/// What rays keep of the strips beside them.
///
/// A ray's strip lies on that side of it on which rays advance less, so that where both come over the
/// ground from its side, the ray does so first.
pub(super) struct Strips<'a> {
    /// How wide they are at most, in cells along the minor axis for each 1 of t.
    pub(super) width: f32,
    /// For each ray, up to which t no ground inside its strip has risen over it.
    pub(super) clear: &'a mut [f32],
}

impl Strips<'_> {
    /// Beside which rays, on their way through their cells, ground inside their strips rises over them.
    ///
    /// Along the minor axis ground is straight from grid line to grid line. So what is over a ray
    /// there though neither side of its strip is has its top on a line between both; and as long as strips are
    /// no wider than a cell, that is the line before the ray's own cell.
    #[inline(always)]
    #[allow(
        clippy::too_many_arguments,
        reason = "where rays are, and what they meet"
    )]
    pub(super) fn rises<L: Lanes>(
        &self,
        l: L,
        field: &Field<'_>,
        ray: &Ray<L>,
        t: L::F,
        [major, minor]: [L::I; 2],
        crossing: &Crossing<L>,
        patch: &Patch<L>,
    ) -> L::M {
        let to_major = l.add(l.to_float(major), l.splat(1.0 - field.major.fraction));
        let to_line = l.sub(l.to_float(minor), l.splat(field.minor.fraction));
        let advance = l.sub(ray.advance, l.splat(self.width));
        let far_end = l.add(patch.corner, patch.by_major);
        let fall = l.add(patch.by_minor, patch.twist);
        let over = |t: L::F| {
            let line = l.add(far_end, l.mul(fall, l.sub(to_major, t)));
            l.sub(l.mul(t, ray.slope), line)
        };
        let least = l.min(over(t), over(crossing.next));
        let side = l.min(l.mul(t, advance), l.mul(crossing.next, advance));
        let is_inside = l.lt(side, to_line);
        l.and(is_inside, l.lt(least, l.splat(0.0)))
    }

    /// Takes note that beside rays of `mask`, which are at `t`, ground rises.
    #[inline(always)]
    pub(super) fn end<L: Lanes>(&mut self, l: L, mask: L::M, id: L::I, t: L::F) {
        if l.bits(mask) == 0 {
            return;
        }
        // It may have done so before.
        let before = l.look_up(bytemuck::cast_slice(self.clear), id);
        let first = l.lt(t, l.float_of_bits(before));
        l.scatter(l.and(mask, first), id, t, self.clear);
    }

    /// As `end`, of the group of rays that begins with number `first`, which have just set out.
    #[inline(always)]
    pub(super) fn end_first<L: Lanes>(&mut self, l: L, mask: L::M, first: usize, t: L::F) {
        l.store_where(mask, t, group_mut(self.clear, first));
    }
}
