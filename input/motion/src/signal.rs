//! Signals: what can be filtered, and what a difference of two of its values is.

use glam::{DQuat, DVec3};
use sandtable_pose::Rigid;
use std::fmt::Debug;
use std::ops::{Add, Mul};

/// A value that filters work on: a number, a position in metres, or an attitude.
///
/// Filters need sums of values, which attitudes do not have. They have differences: a rotation
/// vector leads from one to the other. The two operations here are the ⊟ and ⊞ of Hertzberg,
/// Wagner, Frese and Schröder (2013), so that one filter serves all three kinds.
pub trait Signal: Copy + Debug + sealed::Sealed {
    /// What lies between two values: a number, metres by axis, or a rotation vector in radians in
    /// the axes of the frame that the attitudes are given in.
    type Difference: Copy
        + Debug
        + Default
        + Add<Output = Self::Difference>
        + Mul<f64, Output = Self::Difference>;

    /// The difference that leads from `from` to this value; for attitudes the shorter way round,
    /// so that q and −q are the same.
    fn difference_from(self, from: Self) -> Self::Difference;

    /// The value that `difference` leads to.
    #[must_use]
    fn moved_by(self, difference: Self::Difference) -> Self;

    /// The length of a difference: an absolute value, metres, or radians.
    fn magnitude(difference: Self::Difference) -> f64;

    /// The value as filters take it, or `None` where it is not finite, is larger than [`LARGEST`],
    /// or is no rotation.
    fn usable(self) -> Option<Self>;
}

/// The largest number that a filter takes: with it no difference, rate or square of one overflows.
pub const LARGEST: f64 = 1e100;

/// How far a quaternion's squared length may be from one. Single precision is off by 1e-6, what is
/// no rotation by far more.
const UNIT_TOLERANCE: f64 = 1e-3;

impl Signal for f64 {
    type Difference = f64;

    fn difference_from(self, from: Self) -> f64 {
        self - from
    }

    fn moved_by(self, difference: f64) -> Self {
        self + difference
    }

    fn magnitude(difference: f64) -> f64 {
        difference.abs()
    }

    fn usable(self) -> Option<Self> {
        (self.abs() <= LARGEST).then_some(self)
    }
}

impl Signal for DVec3 {
    type Difference = DVec3;

    fn difference_from(self, from: Self) -> DVec3 {
        self - from
    }

    fn moved_by(self, difference: DVec3) -> Self {
        self + difference
    }

    fn magnitude(difference: DVec3) -> f64 {
        difference.length()
    }

    fn usable(self) -> Option<Self> {
        self.to_array()
            .iter()
            .all(|x| x.abs() <= LARGEST)
            .then_some(self)
    }
}

impl Signal for DQuat {
    type Difference = DVec3;

    fn difference_from(self, from: Self) -> DVec3 {
        let turn = self * from.conjugate();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        let axis = turn.xyz();
        let sine = axis.length();
        if sine > 0.0 {
            axis * (2.0 * sine.atan2(turn.w) / sine)
        } else {
            DVec3::ZERO
        }
    }

    fn moved_by(self, difference: DVec3) -> Self {
        // Rounding would add up over a session.
        (DQuat::from_scaled_axis(difference) * self).normalize()
    }

    fn magnitude(difference: DVec3) -> f64 {
        difference.length()
    }

    fn usable(self) -> Option<Self> {
        // Written so that NaN is refused too.
        ((self.length_squared() - 1.0).abs() <= UNIT_TOLERANCE).then(|| self.normalize())
    }
}

/// A pose as filters take it, or `None` where a part of it is not usable.
pub(crate) fn usable_pose(frame_from_body: &Rigid) -> Option<Rigid> {
    Some(Rigid::new(
        frame_from_body.rotation.usable()?,
        frame_from_body.translation.usable()?,
    ))
}

mod sealed {
    use glam::{DQuat, DVec3};

    /// Filters are proved against overflow for these three only.
    pub trait Sealed {}

    impl Sealed for f64 {}
    impl Sealed for DVec3 {}
    impl Sealed for DQuat {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_leads_from_one_attitude_to_the_other_the_shorter_way() {
        let from = DQuat::from_scaled_axis(DVec3::new(0.3, -0.2, 1.1));
        for vector in [
            DVec3::ZERO,
            DVec3::new(1e-12, 0.0, 0.0),
            DVec3::new(0.0, 1e-170, 0.0),
            DVec3::new(0.2, -0.1, 0.4),
            DVec3::new(0.0, 3.1, 0.0),
        ] {
            let to = from.moved_by(vector);
            for (from, to) in [(from, to), (-from, to), (from, -to)] {
                let found = to.difference_from(from);
                assert!((found - vector).length() < 1e-14, "{found} for {vector}");
            }
        }
        // 4 radians one way are 2π − 4 the other.
        let long = from
            .moved_by(DVec3::new(0.0, 4.0, 0.0))
            .difference_from(from);
        assert!((long.y - (4.0 - std::f64::consts::TAU)).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_number_no_place_or_no_rotation_is_not_usable() {
        assert_eq!(f64::NAN.usable(), None);
        assert_eq!(1e101.usable(), None);
        assert_eq!(DVec3::new(0.0, f64::INFINITY, 0.0).usable(), None);
        assert_eq!(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0).usable(), None);
        assert_eq!(DQuat::from_xyzw(0.0, f64::NAN, 0.0, 1.0).usable(), None);
        assert_eq!(DQuat::from_xyzw(1e200, 0.0, 0.0, 0.0).usable(), None);
        let nearly = DQuat::from_xyzw(0.0, 0.0, 0.0, 1.0 + 1e-6);
        assert_eq!(nearly.usable(), Some(DQuat::IDENTITY));
    }
}
