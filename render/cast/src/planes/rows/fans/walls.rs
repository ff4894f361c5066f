//! The ground's walls, below the border where planes come over it.

use super::super::March;
use super::rays::Rays;
use crate::lanes::{LANES, Lanes};
use crate::planes::profile::Border;

/// How many times as far away rays around a plane may have met a wall as the plane does.
const SLACK: f32 = 1.02;

/// The walls that sixteen planes meet, where the eye lies beside the ground.
///
/// A wall has the colours of the border over it, and what a plane stands for of it is as long as planes lie apart
/// there: many posts, where it runs almost along them. So a plane sees the mean of these; the place itself would be
/// chance, and another one in the next fan.
#[derive(Default)]
pub(super) struct Walls {
    pub(super) colours: [i32; LANES],
    /// Which planes may see one.
    pub(super) seen: u16,
}

impl<L: Lanes> March<'_, L> {
    /// The walls that planes with these rays may see.
    pub(super) fn walls(&self, rays: &Rays) -> Walls {
        let mut walls = Walls::default();
        for k in 0..LANES {
            let enter = rays.enter[k];
            let is_seen = 0.0 < enter && rays.begin[k] <= enter * SLACK;
            if is_seen && rays.live & 1 << k != 0 {
                walls.seen |= 1 << k;
                walls.colours[k] = i32::from_le_bytes(self.wall_colour(rays, k));
            }
        }
        walls
    }

    /// The colour of the wall that a plane sees, half-way to its neighbours.
    fn wall_colour(&self, rays: &Rays, plane: usize) -> [u8; 4] {
        let around = [plane.saturating_sub(1), (plane + 1).min(LANES - 1)];
        let [before, behind] = around.map(|plane| rays.advance[plane]);
        let half = 0.5 * (behind - before).abs() / (around[1] - around[0]) as f32;
        let advance = rays.advance[plane];
        let advances = [(advance - half).max(0.0), advance + half];
        let [[major, major_end], [minor, _]] = self.bounds;
        let (border, stretch) = if major * advance >= minor {
            let stretch = advances.map(|advance| (major * advance).max(minor));
            (Border::Front, stretch)
        } else {
            let [far, near] = advances.map(|advance| (minor / advance).max(major).min(major_end));
            (Border::Side, [near, far])
        };
        border.mean_colour(&self.fields, [major, minor], stretch)
    }
}
