//! Motions: where simulated sensors are, as pure functions of the stream's time.

use glam::{DQuat, DVec3, EulerRot};
use sandtable_pose::Rigid;
use std::f64::consts::TAU;

/// How one simulated bird moves.
///
/// In the transmitter's frame: x forward, y right, z down, metres. Unless it is told a place, a bird
/// keeps to the one that fits the workbench rig: the first above the user's edge of the glass, the
/// second nearer to the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Rests at the bird's own place.
    Still,
    /// Holds a pose.
    Hold(Rigid),
    /// Goes round a horizontal circle and looks along it.
    Circle {
        /// In metres.
        radius: f64,
        /// Seconds once round.
        period: f64,
    },
    /// Rests, goes straight to the right at one speed, rests again.
    SwayRight {
        /// How far, in metres.
        distance: f64,
        /// Seconds of rest before.
        after: f64,
        /// Seconds under way.
        during: f64,
    },
}

impl Motion {
    /// The names that [`Motion::named`] knows.
    pub const NAMES: [&'static str; 3] = ["still", "circle", "sway-right"];

    /// A motion by its name, or `None` where it is not one of [`Motion::NAMES`].
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "still" => Some(Self::Still),
            "circle" => Some(Self::Circle {
                radius: 0.1,
                period: 4.0,
            }),
            "sway-right" => Some(Self::SwayRight {
                distance: 0.1,
                after: 1.0,
                during: 1.0,
            }),
            _ => None,
        }
    }

    /// Holds a pose as the device's own users write it: x, y, z in inches, azimuth, elevation and
    /// roll in degrees.
    #[must_use]
    pub fn hold(inches: [f64; 3], degrees: [f64; 3]) -> Self {
        let [azimuth, elevation, roll] = degrees.map(f64::to_radians);
        Self::Hold(Rigid::new(
            DQuat::from_euler(EulerRot::ZYX, azimuth, elevation, roll),
            DVec3::from_array(inches) * 0.0254,
        ))
    }

    /// `tracker_from_sensor` of bird `bird` (from 1), `seconds` after the stream began.
    #[must_use]
    pub fn pose(&self, bird: u32, seconds: f64) -> Rigid {
        let place = |offset| Rigid::new(DQuat::IDENTITY, own_place(bird) + offset);
        match *self {
            Self::Still => place(DVec3::ZERO),
            Self::Hold(pose) => pose,
            Self::Circle { radius, period } => {
                let (sin, cos) = (TAU * seconds / period).sin_cos();
                let offset = radius * DVec3::new(sin, cos, 0.0);
                Rigid::new(DQuat::from_rotation_z(0.2 * sin), own_place(bird) + offset)
            }
            Self::SwayRight {
                distance,
                after,
                during,
            } => {
                let share = ((seconds - after) / during.max(1e-9)).clamp(0.0, 1.0);
                place(DVec3::new(0.0, distance * share, 0.0))
            }
        }
    }
}

/// Where a bird is when it is told nothing.
fn own_place(bird: u32) -> DVec3 {
    match bird {
        1 => DVec3::new(-0.75, 0.0, -0.9),
        2 => DVec3::new(-0.45, 0.2, -0.55),
        3 => DVec3::new(-0.45, -0.2, -0.55),
        _ => DVec3::new(-0.2, 0.3, -0.5),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_motion() {
        for name in Motion::NAMES {
            assert!(Motion::named(name).is_some());
        }
        assert_eq!(Motion::named("dance"), None);
    }

    #[test]
    fn sway_right_moves_ten_centimetres_to_the_right_and_nothing_else() {
        let sway = Motion::named("sway-right").unwrap();
        let way = sway.pose(1, 9.0).translation - sway.pose(1, 0.0).translation;
        assert!((way - DVec3::new(0.0, 0.1, 0.0)).length() < 1e-12);
        let half = sway.pose(1, 1.5).translation - sway.pose(1, 0.0).translation;
        assert!((half.y - 0.05).abs() < 1e-12);
    }
}
