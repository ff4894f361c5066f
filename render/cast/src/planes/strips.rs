//! The ground in strips: between the vertical planes of rays that are neighbours in a step.

use super::field::Field;
use super::patches::Patch;
use super::walk::{Crossing, corners};
use super::wave::Ray;
use crate::lanes::{LANES, Lanes, group_mut};

/// How many cells wide strips may be in which rays look at one grid line, and at three.
pub(super) const NARROW: f32 = 1.0;
pub(super) const WIDE: f32 = 3.0;

/// How wide strips are.
#[derive(Clone, Copy, Default)]
pub(super) struct StripWidths {
    /// At most, in cells along the minor axis for each 1 of t.
    pub(super) by_t: f32,
    /// Up to how many cells they are looked at: [`NARROW`] or [`WIDE`].
    pub(super) most: f32,
}

impl StripWidths {
    /// Up to which t they are looked at.
    #[inline(always)]
    pub(super) fn farthest(&self) -> f32 {
        self.most / self.by_t
    }

    /// Of rays of `mask`, on their way from one t to another, those whose strips are looked at though they come to
    /// be wider than a cell.
    #[inline(always)]
    pub(super) fn are_wide<L: Lanes>(&self, l: L, mask: L::M, [t, next]: [L::F; 2]) -> L::M {
        let width = l.splat(self.by_t);
        let is_kept = l.lt(l.mul(t, width), l.splat(self.most));
        let is_wide = l.lt(l.splat(NARROW), l.mul(next, width));
        l.and(mask, l.and(is_wide, is_kept))
    }
}

/// What rays keep of the strips beside them.
///
/// A ray's strip lies on that side of it on which rays advance less, so that where both come over the
/// ground from its side, the ray does so first.
pub(super) struct Strips<'a> {
    pub(super) widths: StripWidths,
    /// For each ray, up to which t no ground inside its strip has risen over it.
    pub(super) clear: &'a mut [f32],
}

impl Strips<'_> {
    /// Beside which rays, on their way through their cells from t on, ground inside their strips rises over them.
    ///
    /// Along the minor axis ground is straight from grid line to grid line. So what is over a ray
    /// there though neither side of its strip is has its top on a line between both. Where strips are no wider than
    /// a cell, that is the line before the ray's own cell; else it may be one of the two before that.
    #[inline(always)]
    #[allow(
        clippy::too_many_arguments,
        reason = "where rays are, and what they meet"
    )]
    pub(super) fn rises<L: Lanes>(
        &self,
        l: L,
        field: &Field<'_>,
        mask: L::M,
        ray: &Ray<L>,
        t: L::F,
        [major, minor]: [L::I; 2],
        crossing: &Crossing<L>,
        patch: &Patch<L>,
    ) -> L::M {
        let way = Way {
            slants: [ray.advance, ray.inverse, ray.slope],
            ends: [t, crossing.next],
            to_major: l.add(l.to_float(major), l.splat(1.0 - field.major.fraction)),
            width: self.widths.by_t,
        };
        let away = l.sub(l.to_float(minor), l.splat(field.minor.fraction));
        let rises = way.passes_under(l, &Line::before(l, patch, away));
        let may_be_wide = self.widths.most > NARROW;
        if !may_be_wide || l.bits(self.widths.are_wide(l, mask, way.ends)) == 0 {
            return l.and(mask, rises);
        }
        let before = l.max_i(
            l.sub_i(minor, l.splat_i(2)),
            l.splat_i(field.minor.cells[0]),
        );
        let place = field.heights.only(l, mask, field.place(l, [major, before]));
        let mut places = [0; LANES];
        l.store_i(place, &mut places);
        let posts = l.cells(&field.heights.items, &places, field.heights.stride);
        let over_eye = |post: L::F| {
            l.sub(
                l.sub(post, l.splat(field.eye_height)),
                l.splat(field.eye_rest),
            )
        };
        let [near, far_major, far_minor, both] = corners::<L>(field, posts);
        let away = l.sub(l.to_float(before), l.splat(field.minor.fraction));
        let second = Line {
            far_end: over_eye(far_major),
            fall: l.sub(near, far_major),
            away,
        };
        let first = Line {
            far_end: over_eye(both),
            fall: l.sub(far_minor, both),
            away: l.add(away, l.splat(1.0)),
        };
        // At the ground's border there may be none of these before the ray's own one.
        let there = l.gt_i(minor, before);
        let first = l.and(there, way.passes_under(l, &first));
        let rises = l.or(rises, l.or(first, way.passes_under(l, &second)));
        l.and(mask, rises)
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

/// Rays' way through a cell.
pub(super) struct Way<L: Lanes> {
    /// Their advance, inverse and slope, as a [`Ray`] has them.
    pub(super) slants: [L::F; 3],
    /// The t before and behind it.
    pub(super) ends: [L::F; 2],
    /// How far the line across the major axis behind the cell is from the eye.
    pub(super) to_major: L::F,
    /// Of strips, as [`StripWidths`] has it.
    pub(super) width: f32,
}

/// A grid line along the major axis, beside a cell.
pub(super) struct Line<L: Lanes> {
    /// Metres over the eye where it meets the line behind the cell, and how much higher it is a cell before.
    far_end: L::F,
    fall: L::F,
    /// How many cells it is from the eye, along the minor axis.
    away: L::F,
}

impl<L: Lanes> Line<L> {
    /// The one that rays come over into a cell with a known ground, so many cells `away`.
    #[inline(always)]
    pub(super) fn before(l: L, patch: &Patch<L>, away: L::F) -> Self {
        Self {
            far_end: l.add(patch.corner, patch.by_major),
            fall: l.add(patch.by_minor, patch.twist),
            away,
        }
    }
}

impl<L: Lanes> Way<L> {
    /// Where a line that rays have behind them is higher than they are while it lies in their strips.
    #[inline(always)]
    pub(super) fn passes_under(&self, l: L, line: &Line<L>) -> L::M {
        let Self {
            slants: [advance, inverse, slope],
            ends: [t, next],
            ..
        } = *self;
        let over = |t: L::F| {
            let height = l.add(line.far_end, l.mul(line.fall, l.sub(self.to_major, t)));
            l.sub(l.mul(t, slope), height)
        };
        // The ray comes over the line at `from`, and all of its strip at `to`: 1 / (1 − share) is no more than
        // 1 + share + 2 share² up to a half.
        let share = l.mul(l.splat(self.width), inverse);
        let from = l.mul(line.away, inverse);
        let more = l.add(share, l.mul(l.add(share, share), share));
        let to = l.min(next, l.add(from, l.mul(from, more)));
        let to = l.select(l.lt(share, l.splat(0.5)), to, next);
        let least = l.min(over(t), over(to));
        let advance = l.sub(advance, l.splat(self.width));
        let side = l.min(l.mul(t, advance), l.mul(next, advance));
        l.and(l.lt(side, line.away), l.lt(least, l.splat(0.0)))
    }
}
