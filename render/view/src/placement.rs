//! The placement: how the world lies on the table.

use crate::Screen;
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

/// `world_from_table`: rotation about z, uniform scale, translation, vertical exaggeration.
///
/// Eyes and screens are built in table metres and mapped by it, so that eye separation and screen
/// grow with the scale and the picture on the glass stays true.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// The world point that lies at the table's origin, in world metres.
    pub anchor: DVec3,
    /// Heading of the table's y axis: radians from north, clockwise seen from above.
    pub yaw: f64,
    /// World metres per table metre along the ground.
    pub scale: f64,
    /// How many times relief is stretched on the table: 1 keeps its true shape.
    pub exaggeration: f64,
}

impl Placement {
    /// A table point in world metres.
    #[must_use]
    pub fn world_from_table(&self, table: DVec3) -> DVec3 {
        self.anchor + self.world_vector_from_table(table)
    }

    /// A table vector in world metres.
    #[must_use]
    pub fn world_vector_from_table(&self, table: DVec3) -> DVec3 {
        let (s, c) = self.yaw.sin_cos();
        let DVec3 { x, y, z } = table * self.scale;
        DVec3::new(c * x + s * y, c * y - s * x, z / self.exaggeration)
    }

    /// A world point in table metres.
    #[must_use]
    pub fn table_from_world(&self, world: DVec3) -> DVec3 {
        let (s, c) = self.yaw.sin_cos();
        let DVec3 { x, y, z } = world - self.anchor;
        DVec3::new(c * x - s * y, s * x + c * y, z * self.exaggeration) / self.scale
    }

    /// Lays a ground of `extent` metres (east, north), whose heights run over `heights`, on
    /// `glass` so that all of it is just covered by the glass, north away from the user, and its
    /// lowest height lies in the glass.
    ///
    /// `margin` is the share of the glass left free on each side, in [0, ½).
    #[must_use]
    pub fn fitted(
        extent: DVec2,
        heights: [f64; 2],
        glass: &Screen,
        margin: f64,
        exaggeration: f64,
    ) -> Self {
        let usable = (1.0 - 2.0 * margin).max(1e-3);
        let glass_size = DVec2::new(glass.across().length(), glass.upwards().length()) * usable;
        let ratio = extent / glass_size;
        Self {
            anchor: DVec3::new(0.5 * extent.x, 0.5 * extent.y, heights[0]),
            yaw: 0.0,
            scale: ratio.x.max(ratio.y).max(f64::MIN_POSITIVE),
            exaggeration,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_and_world_are_each_others_inverse() {
        let placement = Placement {
            anchor: DVec3::new(5000.0, 4000.0, 900.0),
            yaw: 0.7,
            scale: 12_000.0,
            exaggeration: 2.5,
        };
        let p = DVec3::new(0.31, -0.42, 0.17);
        assert!((placement.table_from_world(placement.world_from_table(p)) - p).length() < 1e-12);
    }

    #[test]
    fn a_turned_table_looks_along_its_yaw() {
        let placement = Placement {
            anchor: DVec3::ZERO,
            yaw: std::f64::consts::FRAC_PI_2,
            scale: 10.0,
            exaggeration: 2.0,
        };
        // Away from the user is east; up is halved, so that relief shows doubled.
        assert!(
            (placement.world_from_table(DVec3::Y) - DVec3::new(10.0, 0.0, 0.0)).length() < 1e-12
        );
        assert!(
            (placement.world_from_table(DVec3::Z) - DVec3::new(0.0, 0.0, 5.0)).length() < 1e-12
        );
    }

    #[test]
    fn a_fitted_ground_lies_within_the_glass() {
        let glass = Screen::horizontal(1.8, 1.1);
        for extent in [DVec2::new(30_000.0, 9_000.0), DVec2::new(9_000.0, 30_000.0)] {
            let placement = Placement::fitted(extent, [236.0, 1076.0], &glass, 0.05, 1.0);
            let low = placement.table_from_world(DVec3::new(0.0, 0.0, 236.0));
            let high = placement.table_from_world(extent.extend(1076.0));
            assert!(low.x >= -0.81 - 1e-12 && low.y >= -0.495 - 1e-12);
            assert!(high.x <= 0.81 + 1e-12 && high.y <= 0.495 + 1e-12);
            assert!(low.z.abs() < 1e-12 && high.z > 0.0);
            // One of the two directions is used in full.
            assert!((high.x - 0.81).abs() < 1e-9 || (high.y - 0.495).abs() < 1e-9);
        }
    }
}
