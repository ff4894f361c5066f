//! Where the ground ends to a side, at the edge of two walls.

use super::super::March;
use super::fan::Fan;
use crate::lanes::Lanes;

/// How many lanes around a corner pixels are looked at: more than half a pixel, and than from plane to plane.
const AROUND: f64 = 2.0;

/// An edge of the ground's walls beyond which there is none, as an eye beside the ground sees it.
///
/// It lies in one vertical plane, so those of a fan see all of it or nothing; how much of a pixel is ground follows
/// from where the edge lies between them.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    /// The plane in which it lies, counted as the fan's are.
    plane: f64,
    /// Whether the ground lies on the planes before it.
    is_last: bool,
    /// Lanes from plane to plane.
    apart: f64,
    /// The first and the last plane that is seen in the step.
    seen: [f64; 2],
    /// The lanes of which a part may be beside the ground, or take what is seen elsewhere, from the first to the one
    /// behind the last.
    lanes: [i32; 2],
}

impl<L: Lanes> March<'_, L> {
    /// The corners that there may be in a step of a fan.
    pub(super) fn corners(&self, fan: &Fan, step: u32) -> [Option<Corner>; 2] {
        let planes = fan.planes_of(step);
        self.corner_lanes(step).map(|corner| {
            corner.map(|(lane, is_last)| Corner {
                plane: fan.plane(step, lane),
                is_last,
                apart: 1.0 / fan.planes_to_lane(step),
                seen: [planes.start as f64, planes.end.saturating_sub(1) as f64],
                lanes: [
                    (lane - AROUND).floor() as i32,
                    (lane + AROUND).ceil() as i32,
                ],
            })
        })
    }

    /// Whether all of the ground that a step may see lies between so few lanes that rays may pass it on both
    /// sides, though it is wider in later steps.
    pub(super) fn is_needle(&self, step: u32) -> bool {
        const LANES: f64 = 4.0;
        match self.corner_lanes(step) {
            [Some((one, _)), Some((other, _))] => (one - other).abs() < LANES,
            _ => false,
        }
    }

    /// The lanes at which a step sees the ground's corners, and whether the ground lies on the lanes before them.
    fn corner_lanes(&self, step: u32) -> [Option<(f64, bool)>; 2] {
        let [[major_begin, major_end], [minor_begin, minor_end]] =
            self.bounds.map(|ends| ends.map(f64::from));
        let d = self.directions.at_place(step, 0.0);
        let v = self.directions.lane;
        // Whether lanes further on run more along the minor axis.
        let turns = v.y * d.x - v.x * d.y > 0.0;
        let lane = |major: f64, minor: f64| {
            let lane = (d.x * minor - d.y * major) / (v.y * major - v.x * minor);
            let is_ahead = (d.x + lane * v.x) * major + (d.y + lane * v.y) * minor > 0.0;
            (major > 0.0 && minor > 0.0 && is_ahead).then_some(lane)
        };
        // Those that lie least and most along the minor axis, where there is no ground beyond them.
        let least = (minor_begin > 0.0).then(|| lane(major_end, minor_begin));
        let most = (major_begin > 0.0).then(|| lane(major_begin, minor_end));
        [(least, !turns), (most, turns)].map(|(lane, is_last)| Some((lane.flatten()?, is_last)))
    }
}

impl Corner {
    /// Whether it is to be regarded in some of so many lanes from the first on.
    pub(super) fn is_among(self, first: i32, count: i32) -> bool {
        let [from, to] = self.lanes;
        from < first + count && first < to
    }

    /// The outermost plane that sees ground, of those of the step.
    fn outermost(self) -> f64 {
        /// Of a plane that is as near to the edge there is no telling whether it does.
        const NEAR: f64 = 0.01;
        let outermost = if self.is_last {
            (self.plane - NEAR).floor()
        } else {
            (self.plane + NEAR).ceil()
        };
        outermost.clamp(self.seen[0], self.seen[1])
    }

    /// The first of `plane` and of the planes that are to be asked there.
    pub(super) fn first_asked(self, plane: f64) -> f64 {
        plane.min(self.outermost())
    }

    /// Where among planes, counted from plane `base` on, pixels are to take what is seen that lie at `plane`.
    #[inline(always)]
    pub(super) fn asked<L: Lanes>(self, l: L, base: usize, plane: L::F) -> L::F {
        let outermost = l.splat((self.outermost() - base as f64) as f32);
        if self.is_last {
            l.min(plane, outermost)
        } else {
            l.max(plane, outermost)
        }
    }

    /// How much is ground of pixels at `plane`, counted likewise: below 0 where none is, over 1 where all is.
    #[inline(always)]
    pub(super) fn covered<L: Lanes>(self, l: L, base: usize, plane: L::F) -> L::F {
        let edge = l.splat((self.plane - base as f64) as f32);
        let inside = if self.is_last {
            l.sub(edge, plane)
        } else {
            l.sub(plane, edge)
        };
        l.add(l.mul(inside, l.splat(self.apart as f32)), l.splat(0.5))
    }
}
