//! Rigid transforms: a rotation, then a translation.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::ops::Mul;

/// A rigid transform `target_from_source`: rotates, then translates. Metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rigid {
    /// Turns source axes into target axes; a unit quaternion.
    pub rotation: DQuat,
    /// The source's origin in the target's coordinates, in metres.
    pub translation: DVec3,
}

impl Rigid {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self {
        rotation: DQuat::IDENTITY,
        translation: DVec3::ZERO,
    };

    /// Builds a transform; `rotation` must be a unit quaternion.
    #[must_use]
    pub const fn new(rotation: DQuat, translation: DVec3) -> Self {
        Self {
            rotation,
            translation,
        }
    }

    /// A point's coordinates in the target frame.
    #[must_use]
    pub fn point(&self, source: DVec3) -> DVec3 {
        self.rotation * source + self.translation
    }

    /// A direction's coordinates in the target frame: turned, not moved.
    #[must_use]
    pub fn direction(&self, source: DVec3) -> DVec3 {
        self.rotation * source
    }

    /// `source_from_target`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self {
            rotation,
            translation: rotation * -self.translation,
        }
    }
}

impl Mul for Rigid {
    type Output = Self;

    /// `c_from_b * b_from_a = c_from_a`.
    fn mul(self, b_from_a: Self) -> Self {
        Self {
            rotation: self.rotation * b_from_a.rotation,
            translation: self.point(b_from_a.translation),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transform_times_its_inverse_is_the_identity() {
        let a = Rigid::new(
            DQuat::from_xyzw(0.11547, -0.34641, 0.46188, 0.80829).normalize(),
            DVec3::new(0.2, -0.4, 0.9),
        );
        let p = DVec3::new(0.3048, 0.0762, -0.127);
        assert!((a.inverse().point(a.point(p)) - p).length() < 1e-15);
        let i = a * a.inverse();
        assert!(i.translation.length() < 1e-15);
        assert!(i.rotation.angle_between(DQuat::IDENTITY) < 1e-7);
    }

    #[test]
    fn products_apply_the_right_factor_first() {
        let turn = Rigid::new(
            DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            DVec3::ZERO,
        );
        let shift = Rigid::new(DQuat::IDENTITY, DVec3::X);
        let p = (turn * shift).point(DVec3::ZERO);
        assert!((p - DVec3::Y).length() < 1e-15);
    }
}
