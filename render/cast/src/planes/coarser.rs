//! From one resolution of the ground to the next.

use super::field::Field;
use super::roofs::FINEST;
use super::wave::{Ray, Waves};
use crate::lanes::Lanes;

/// Where rays go that are too far for the resolution that they are in.
pub(super) struct Coarser<'a> {
    /// The ground at half the resolution, and the rays on their way over it. Behind the coarsest resolution
    /// there is none, and rays end.
    next: Option<(&'a Field<'a>, &'a mut Waves)>,
    /// Whether there is a coarser resolution still.
    is_last: bool,
}

impl<'a> Coarser<'a> {
    /// What comes behind the resolution numbered `level` of `fields`, of which `waves` are on
    /// their way over coarser ones; `None` where the ground has its own resolution only.
    #[inline(always)]
    pub(super) fn behind(
        fields: &'a [Field<'a>],
        level: usize,
        waves: &'a mut [Waves],
    ) -> Option<Self> {
        if fields.len() == 1 {
            return None;
        }
        Some(Self {
            next: fields.get(level + 1).zip(waves.first_mut()),
            is_last: level + 2 == fields.len(),
        })
    }

    /// Takes over the rays of `mask`, which have come to `t` and leave the ground at `leave`. Those
    /// that skipped blocks of `level` go on so.
    #[inline(always)]
    pub(super) fn take<L: Lanes>(
        &mut self,
        l: L,
        mask: L::M,
        ray: &Ray<L>,
        t: L::F,
        leave: L::F,
        level: Option<L::I>,
    ) {
        let Some((field, waves)) = &mut self.next else {
            return;
        };
        if l.bits(mask) == 0 {
            return;
        }
        let half = l.splat(0.5);
        let t = l.mul(t, half);
        let leave = l.min(l.mul(leave, half), field.end(l, ray.inverse));
        // Rays that pass have come to where their resolution ends: in cells, each one's ends as far
        // away as the one's before.
        let leave = if self.is_last {
            leave
        } else {
            l.min(leave, ray.leave)
        };
        let ray = Ray {
            slope: l.add(ray.slope, ray.slope),
            leave,
            ..*ray
        };
        let cell = field.cell_at(l, t, ray.advance);
        if let Some(level) = level {
            let level = l.max_i(l.sub_i(level, l.splat_i(1)), l.splat_i(FINEST as i32));
            waves.high.push_at_level(l, mask, &ray, t, cell, level);
        } else {
            waves.low.push(l, mask, &ray, t, cell);
        }
    }
}
