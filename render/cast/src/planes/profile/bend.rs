//! How profiles go on from a line of posts to the next one.

use super::PlaneGroup;
use super::crossing::{Crossing, Texels};
use super::halves::{between, either, parts};
use crate::lanes::Lanes;

/// A place of each plane between two neighbouring lines of posts. From there to either of these its
/// profile is straight, or nearly so: it is where the plane goes from one cell to the next along the minor
/// axis, or else half-way, where what bends is the cell's surface alone.
pub(in crate::planes) struct Bend<L: Lanes> {
    /// How much of the way from line to line it is to there.
    pub(in crate::planes) share: L::F,
    /// Which planes go from one cell to the next.
    pub(super) crosses: L::M,
    /// How far into its cell the place lies along the minor axis, of the cell that the plane comes from, and
    /// of the one that it goes to.
    aside: [L::F; 2],
}

/// The colours of a bent profile: where its two pieces begin and end, and of each piece, which is a parabola
/// where its cell is twisted, the middle point of the parabola's control polygon.
pub(in crate::planes) struct BentColours<L: Lanes> {
    pub(in crate::planes) ends: [[L::I; 2]; 3],
    pub(in crate::planes) controls: [[L::I; 2]; 2],
}

impl<L: Lanes> Bend<L> {
    /// Between a line and the next one, or two of as many places in between as there are `to_a_cell`.
    #[inline(always)]
    pub(in crate::planes) fn new(
        l: L,
        planes: &PlaneGroup<L>,
        [before, behind]: [&Crossing<L>; 2],
        to_a_cell: f32,
    ) -> Self {
        let (zero, half, one) = (l.splat(0.0), l.splat(0.5), l.splat(1.0));
        let crosses = l.gt_i(behind.cell, before.cell);
        let there = l.mul(l.sub(one, before.share), planes.per_advance);
        let there = l.mul(there, l.splat(to_a_cell));
        let there = l.max(l.min(there, one), zero);
        let middle = l.mul(l.add(before.share, behind.share), half);
        Self {
            share: l.select(crosses, there, half),
            crosses,
            aside: [
                l.select(crosses, one, middle),
                l.select(crosses, zero, middle),
            ],
        }
    }

    /// The ground's height there over the eye, of which the posts of both lines are known.
    #[inline(always)]
    pub(in crate::planes) fn heights(&self, l: L, before: [L::F; 2], behind: [L::F; 2]) -> L::F {
        // A line of the minor axis leads from the far post of the one line to the near one of the other.
        let first = l.select(self.crosses, before[1], before[0]);
        let near = l.add(first, l.mul(l.sub(behind[0], first), self.share));
        let far = l.add(before[1], l.mul(l.sub(behind[1], before[1]), self.share));
        l.add(near, l.mul(l.sub(far, near), self.aside[1]))
    }

    /// The colours of both pieces, of the posts around `before` and `behind` and what lies between them there.
    #[inline(always)]
    pub(in crate::planes) fn colours(
        &self,
        l: L,
        [before, behind]: [&Crossing<L>; 2],
        [from, to]: [&Texels<L>; 2],
    ) -> BentColours<L> {
        let half = parts(l, l.splat(0.5));
        let share = parts(l, self.share);
        let begin = before.mixed(l, from[1], from[2]);
        let end = behind.mixed(l, to[1], to[2]);
        // The bend's places along the minor axis, on both lines.
        let near = between(l, from[1], from[2], parts(l, self.aside[0]));
        let far = between(l, to[1], to[2], parts(l, self.aside[1]));
        // A piece's polygon has its middle between the two other corners of the rectangle around it.
        let across = before.mixed(
            l,
            either(l, self.crosses, to[0], to[1]),
            either(l, self.crosses, to[1], to[2]),
        );
        let first = between(l, near, between(l, begin, across, share), half);
        let across = behind.mixed(
            l,
            either(l, self.crosses, from[2], from[1]),
            either(l, self.crosses, from[3], from[2]),
        );
        let second = between(l, far, between(l, across, end, share), half);
        BentColours {
            ends: [begin, between(l, near, far, share), end],
            controls: [first, second],
        }
    }
}
