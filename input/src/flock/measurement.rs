//! Measurements: from a record's words to metres and a unit quaternion.
//!
//! Inches, full scales and the sign of the quaternion end here.

use super::record::{Words, share_from_word, word_from_share};
use glam::{DQuat, DVec3};
use sandtable_config::{Flock, QuaternionSign, Range};
use sandtable_pose::Rigid;

/// How the words on the line are meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The position's full scale, in metres.
    pub full_scale: f64,
    /// The quaternion's sign.
    pub quaternion: QuaternionSign,
}

impl Scale {
    /// How far a quaternion's length may be from 1: 14 bits leave it within 0.0003.
    pub const NORM_TOLERANCE: f64 = 0.02;

    /// The scale of a rig's Flock.
    #[must_use]
    pub fn of(flock: &Flock) -> Self {
        Self::new(flock.range, flock.quaternion)
    }

    /// A range's scale.
    #[must_use]
    pub fn new(range: Range, quaternion: QuaternionSign) -> Self {
        Self {
            full_scale: range.metres(),
            quaternion,
        }
    }

    /// `tracker_from_sensor` in metres, or `None` where the quaternion is none.
    #[must_use]
    pub fn pose(&self, words: &Words) -> Option<Rigid> {
        let position = words.position.map(share_from_word);
        let [w, x, y, z] = words.quaternion.map(share_from_word);
        let sent = DQuat::from_xyzw(x, y, z, w);
        let length = sent.length();
        if (length - 1.0).abs() > Self::NORM_TOLERANCE {
            return None;
        }
        let unit = sent * length.recip();
        Some(Rigid::new(
            match self.quaternion {
                QuaternionSign::Conjugate => unit.conjugate(),
                QuaternionSign::AsSent => unit,
            },
            DVec3::from_array(position) * self.full_scale,
        ))
    }

    /// The words that the device would send for `tracker_from_sensor`.
    #[must_use]
    pub fn words(&self, tracker_from_sensor: &Rigid) -> Words {
        let position = tracker_from_sensor.translation / self.full_scale;
        let rotation = match self.quaternion {
            QuaternionSign::Conjugate => tracker_from_sensor.rotation.conjugate(),
            QuaternionSign::AsSent => tracker_from_sensor.rotation,
        };
        // The line cuts the low two bits.
        let word = |share: f64| word_from_share(share) & !3;
        Words {
            position: position.to_array().map(word),
            quaternion: [rotation.w, rotation.x, rotation.y, rotation.z].map(word),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::EulerRot;

    fn worked() -> Rigid {
        let turn = DQuat::from_euler(
            EulerRot::ZYX,
            30f64.to_radians(),
            20f64.to_radians(),
            10f64.to_radians(),
        );
        Rigid::new(turn, DVec3::new(12.0, 3.0, -5.0) * 0.0254)
    }

    const SCALE: Scale = Scale {
        full_scale: 36.0 * 0.0254,
        quaternion: QuaternionSign::Conjugate,
    };

    #[test]
    fn the_worked_pose_has_the_worked_words() {
        let words = SCALE.words(&worked());
        assert_eq!(words.position, [10920, 2728, -4552]);
        assert_eq!(words.quaternion, [31180, -1252, -6204, -7844]);
        let wide = Scale::new(Range::Inches72, QuaternionSign::Conjugate);
        assert_eq!(wide.words(&worked()).position, [5460, 1364, -2276]);
    }

    #[test]
    fn the_worked_words_are_metres_to_the_tenth_of_a_millimetre() {
        let pose = SCALE.pose(&SCALE.words(&worked())).unwrap();
        let expected = DVec3::new(304.726, 76.126, -127.025) * 1e-3;
        assert!((pose.translation - expected).length() < 1e-6);
        assert!((pose.translation - worked().translation).length() < 2e-4);
        assert!(pose.rotation.angle_between(worked().rotation) < 1e-3);
        // Azimuth 90 turns the sensor's x to the transmitter's y.
        let quarter = Rigid::new(
            DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            DVec3::ZERO,
        );
        assert_eq!(SCALE.words(&quarter).quaternion, [23168, 0, 0, -23172]);
        let back = SCALE.pose(&SCALE.words(&quarter)).unwrap();
        assert!((back.direction(DVec3::X) - DVec3::Y).length() < 1e-3);
    }

    #[test]
    fn one_as_14_bits_is_renormalised() {
        let words = Words {
            position: [0; 3],
            quaternion: [0x7FFC, 0, 0, 0],
        };
        assert_eq!(
            SCALE.pose(&words).unwrap().rotation,
            DQuat::from_xyzw(-0.0, -0.0, -0.0, 1.0)
        );
    }

    #[test]
    fn what_is_no_unit_quaternion_is_no_pose() {
        for quaternion in [[0; 4], [32000, 0, 0, 0], [32764, 8000, 0, 0], [-32768; 4]] {
            let words = Words {
                position: [0; 3],
                quaternion,
            };
            assert_eq!(SCALE.pose(&words), None, "{quaternion:?}");
        }
    }
}
