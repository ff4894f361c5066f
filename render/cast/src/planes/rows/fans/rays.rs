//! The rays of sixteen planes: where their pixels' borders are, and where they may meet ground.

use super::super::March;
use super::super::scratch::{MARGIN, MEMORY, Scratch};
use super::fan::Fan;
use crate::lanes::{LANES, Lanes};

/// One number a plane.
pub(super) type Each = [f32; LANES];

/// In how many parts light is added up to a pixel's: the sum of 8 bits times all of them has 16.
pub(super) const PARTS: f32 = 256.0;

/// Planes' rays: those between pixels, of which the first is the lower border of the first pixel in
/// which their plane is seen; and where they begin and end.
pub(super) struct Rays {
    /// Directions as affine functions of the border's number: metres up, and cells along the major
    /// axis.
    pub(super) up: [Each; 2],
    pub(super) major: [Each; 2],
    /// From one border to the next their slope (up for each 1 of the major axis) grows by 1 / (this
    /// · one's major · the other's), times [`PARTS`].
    pub(super) parts: Each,
    /// The slope up to which the ground has been seen, or is not to be looked at.
    pub(super) horizon: Each,
    /// Cells along the minor axis for each one along the major axis.
    pub(super) advance: Each,
    /// The t at which planes come over the ground and leave it.
    pub(super) enter: Each,
    pub(super) leave: Each,
    /// The t from which on planes may meet ground: nearer ground is seen below them.
    pub(super) begin: Each,
    /// In how many steps planes are seen, and where among what is seen the first one goes.
    pub(super) steps: Each,
    pub(super) place: [i32; LANES],
    /// Which of the planes may meet ground, and from which t on some do.
    pub(super) live: u16,
    pub(super) start: f32,
}

impl Rays {
    /// The t from which on all planes are over the ground, and the one up to which they are.
    pub(super) fn over_ground(&self) -> [f32; 2] {
        [
            self.enter.iter().copied().fold(0.0, f32::max),
            self.leave.iter().copied().fold(f32::INFINITY, f32::min),
        ]
    }
}

impl<L: Lanes> March<'_, L> {
    /// The rays of sixteen planes.
    pub(super) fn plane_rays(&self, fan: &Fan, first: usize, scratch: &Scratch) -> Rays {
        let steep = self.steep();
        let [[major_begin, major_end], [minor_begin, minor_end]] = self.bounds;
        let top = self.fields[0].highest - self.fields[0].eye_height;
        let is_needle = fan.from > 0 && self.is_needle(fan.from - 1);
        let mut rays = Rays {
            up: [[0.0; LANES]; 2],
            major: [[0.0; LANES]; 2],
            parts: [0.0; LANES],
            horizon: [0.0; LANES],
            advance: [0.0; LANES],
            enter: [0.0; LANES],
            begin: [0.0; LANES],
            leave: [0.0; LANES],
            steps: [0.0; LANES],
            place: [0; LANES],
            live: 0,
            start: f32::INFINITY,
        };
        for k in 0..LANES {
            let plane = first + k;
            let [begin, end] = fan.seen(plane);
            let is_seen = begin < end;
            let (begin, end) = if is_seen {
                (begin, end)
            } else {
                (fan.from, fan.to)
            };
            let lane = fan.lane(begin, plane);
            let d = self.directions.at_place(begin, lane);
            let step = self.directions.step - fan.back(plane) * self.directions.lane;
            let far = d + f64::from(end - begin) * step;
            let advance = (far.y.max(0.0) / far.x.max(steep)).min(1.0) as f32;
            let border = d - 0.5 * step;
            rays.up[0][k] = border.z as f32;
            rays.up[1][k] = step.z as f32;
            rays.major[0][k] = border.x as f32;
            rays.major[1][k] = step.x as f32;
            rays.parts[k] = (f64::from(PARTS) / (step.z * d.x - d.z * step.x)) as f32;
            let before = d - step;
            let horizon = before.z / before.x.max(steep);
            rays.horizon[k] = horizon as f32;
            rays.advance[k] = advance;
            let mut start = major_begin.max(0.0);
            if minor_begin > 0.0 {
                start = start.max(minor_begin / advance);
            }
            let leave = major_end.min(minor_end / advance);
            rays.enter[k] = start;
            rays.leave[k] = leave;
            if !is_seen {
                continue;
            }
            rays.steps[k] = (end - begin) as f32;
            rays.place[k] = fan.place(begin, plane) as i32;
            if top < 0.0 {
                if horizon >= 0.0 {
                    continue;
                }
                start = start.max(top / horizon as f32);
            }
            // Rays may pass a needle on both sides.
            if begin == fan.from && begin > 0 && !is_needle {
                match self.seen_before(fan, plane, scratch) {
                    Some(t) if t < 0.0 => continue,
                    Some(t) => start = start.max(t),
                    None => {}
                }
            }
            rays.begin[k] = start;
            if start < leave {
                rays.live |= 1 << k;
                rays.start = rays.start.min(start);
            }
        }
        rays
    }

    /// How far the rays around a plane of a fan reach in the step before, at least: all that are higher see
    /// nothing nearer. Less than 0 where they meet nothing. `None` where there are no such rays, and where
    /// they lie so far apart, beside the vanishing point, that all of the ground may lie between them.
    ///
    /// Two on either side are asked, where there are, as rays may be those of the last fan's planes: a pixel's is
    /// that of the plane which is nearer to it, so that at an edge two alone might all be of its one side.
    fn seen_before(&self, fan: &Fan, plane: usize, scratch: &Scratch) -> Option<f32> {
        /// Planes from a ray to the next.
        const MOST: f64 = 2.0;
        let step = fan.from - 1;
        if fan.planes_to_lane(step) > MOST {
            return None;
        }
        let [from, to] = scratch.lanes[step as usize % MEMORY];
        let lane = fan.lane(step, plane).floor() as i32;
        if lane < from || to <= lane + 1 {
            // One ray alone may come over the ground later than the plane.
            return None;
        }
        let at = self.slot(step) + MARGIN;
        let around = (lane - 1).max(from) as usize..=(lane + 2).min(to - 1) as usize;
        let reached = around.map(|lane| scratch.reached[at + lane]);
        Some(reached.fold(-1.0, |least, t| {
            if t < 0.0 || (0.0..t).contains(&least) {
                least
            } else {
                t
            }
        }))
    }
}
