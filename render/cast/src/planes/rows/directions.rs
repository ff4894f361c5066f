//! Where a sector's rays go.

use crate::lanes::Lanes;
use crate::planes::frame::Frame;
use crate::planes::sectors::Sector;
use glam::{DVec3, Vec3};

/// The rays of a sector: directions as an affine function of step and lane. Components are cells
/// along the major and the minor axis, both in the direction in which rays run, and metres up.
pub(in crate::planes) struct Directions {
    first: DVec3,
    pub(in crate::planes) step: DVec3,
    pub(in crate::planes) lane: DVec3,
}

impl Directions {
    pub(super) fn new(frame: &Frame<'_>, sector: &Sector) -> Self {
        let turned = |v: DVec3| {
            let (major, minor) = if sector.major == 0 {
                (v.x, v.y)
            } else {
                (v.y, v.x)
            };
            DVec3::new(
                major * f64::from(sector.signs[0]),
                minor * f64::from(sector.signs[1]),
                v.z,
            )
        };
        let rays = &frame.rays;
        let step = turned(rays.steps[sector.step_axis]);
        Self {
            first: turned(rays.first) + f64::from(sector.first_step) * step,
            step: f64::from(sector.direction) * step,
            lane: turned(rays.steps[1 - sector.step_axis]),
        }
    }

    pub(in crate::planes) fn at_place(&self, step: u32, lane: f64) -> DVec3 {
        self.first + f64::from(step) * self.step + lane * self.lane
    }

    pub(in crate::planes) fn at(&self, step: u32, lane: i32) -> DVec3 {
        self.first + f64::from(step) * self.step + f64::from(lane) * self.lane
    }
}

/// A ray straight down has a little of the major axis, too little to be seen: this, times the first
/// ray's length.
pub(super) const STEEP: f64 = 1e-10;

/// Sixteen neighbours of a step.
pub(super) struct Aimed<L: Lanes> {
    /// As a [`Ray`](crate::planes::wave::Ray) has them.
    pub(super) advance: L::F,
    pub(super) inverse: L::F,
    pub(super) slope: L::F,
    /// One over the directions' part along the major axis.
    pub(super) scale: L::F,
}

/// What neighbours' directions have in common.
pub(super) struct Aim<L: Lanes> {
    steep: L::F,
    major: L::F,
    minor: L::F,
    up: L::F,
}

impl<L: Lanes> Aim<L> {
    #[inline(always)]
    pub(super) fn new(l: L, frame: &Frame<'_>, lane: DVec3) -> Self {
        let iota = l.load(&std::array::from_fn(|k| k as f32));
        Self {
            steep: l.splat((STEEP * frame.rays.first.length()) as f32),
            major: l.mul(l.splat(lane.x as f32), iota),
            minor: l.mul(l.splat(lane.y as f32), iota),
            up: l.mul(l.splat(lane.z as f32), iota),
        }
    }

    /// The directions of the group of which the first has the direction `first`: along the major
    /// axis, along the minor one, and up.
    #[inline(always)]
    pub(super) fn directions(&self, l: L, first: Vec3) -> [L::F; 3] {
        [
            l.max(l.add(l.splat(first.x), self.major), self.steep),
            l.max(l.add(l.splat(first.y), self.minor), l.splat(0.0)),
            l.add(l.splat(first.z), self.up),
        ]
    }

    /// As [`Aim::directions`], for each 1 of the major axis.
    #[inline(always)]
    pub(super) fn at(&self, l: L, first: DVec3) -> Aimed<L> {
        let [major, minor, up] = self.directions(l, first.as_vec3());
        let scale = l.div(l.splat(1.0), major);
        Aimed {
            advance: l.mul(minor, scale),
            // Not one over the above: two divisions at once take as long as one.
            inverse: l.div(major, minor),
            slope: l.mul(up, scale),
            scale,
        }
    }
}
