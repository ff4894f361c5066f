//! Measurements: from a record's words to metres and a unit quaternion.
//!
//! Inches, degrees, full scales and the sign of the quaternion end here.

use super::format::{Attitude, Coding};
use super::record::{Words, share_from_word, word_from_share};
use glam::{DMat3, DQuat, DVec3, EulerRot};
use sandtable_config::{Flock, QuaternionSign, Range, RecordFormat};
use sandtable_pose::Rigid;
use std::f64::consts::PI;

/// How the words on the line are meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// What a record holds.
    pub format: RecordFormat,
    /// The position's full scale, in metres.
    pub full_scale: f64,
    /// The quaternion's sign.
    pub quaternion: QuaternionSign,
}

impl Scale {
    /// How far the length of a quaternion or of a matrix's row may be from 1, and two rows from
    /// being square: 14 bits leave them within 0.0003.
    pub const NORM_TOLERANCE: f64 = 0.02;

    /// The scale of a rig's Flock.
    #[must_use]
    pub fn of(flock: &Flock) -> Self {
        Self {
            format: flock.format,
            full_scale: flock.range.metres(),
            quaternion: flock.quaternion,
        }
    }

    /// The scale of a range and a format.
    #[must_use]
    pub fn new(range: Range, format: RecordFormat) -> Self {
        Self {
            format,
            full_scale: range.metres(),
            quaternion: QuaternionSign::Conjugate,
        }
    }

    /// `tracker_from_sensor` in metres, or `None` where the words are not a record's of this
    /// format, as a quaternion that has not length 1. What the format does not hold is zero: no
    /// way, no turn.
    #[must_use]
    pub fn pose(&self, words: &Words) -> Option<Rigid> {
        let coding = Coding::of(self.format);
        if words.len() != coding.words() {
            return None;
        }
        let mut shares = words.iter().map(|&word| share_from_word(word));
        let mut next = || shares.next().unwrap_or_default();
        let translation = if coding.position {
            DVec3::new(next(), next(), next()) * self.full_scale
        } else {
            DVec3::ZERO
        };
        let rotation = match coding.attitude {
            None => DQuat::IDENTITY,
            Some(Attitude::Angles) => {
                let [azimuth, elevation, roll] = [next(), next(), next()];
                // A quarter turn up or down is the most, and a step more is rounding.
                if elevation.abs() > 0.5 + 1e-3 {
                    return None;
                }
                DQuat::from_euler(EulerRot::ZYX, azimuth * PI, elevation * PI, roll * PI)
            }
            Some(Attitude::Matrix) => {
                // As they come, the nine words are the rows of transmitter-from-sensor.
                let rows = [(); 3].map(|()| DVec3::new(next(), next(), next()));
                rotation_of_rows(rows)?
            }
            Some(Attitude::Quaternion) => {
                let [w, x, y, z] = [next(), next(), next(), next()];
                let sent = DQuat::from_xyzw(x, y, z, w);
                let length = sent.length();
                if (length - 1.0).abs() > Self::NORM_TOLERANCE {
                    return None;
                }
                let unit = sent * length.recip();
                match self.quaternion {
                    QuaternionSign::Conjugate => unit.conjugate(),
                    QuaternionSign::AsSent => unit,
                }
            }
        };
        Some(Rigid::new(rotation, translation))
    }

    /// The words that the device would send for `tracker_from_sensor`.
    #[must_use]
    pub fn words(&self, tracker_from_sensor: &Rigid) -> Words {
        let coding = Coding::of(self.format);
        let mut words = [0; 12];
        let mut places = words.iter_mut();
        let mut put = |shares: &[f64]| {
            // Shares first: what ends first must take no place.
            for (share, place) in shares.iter().zip(places.by_ref()) {
                // The line cuts the low two bits.
                *place = word_from_share(*share) & !3;
            }
        };
        if coding.position {
            put(&(tracker_from_sensor.translation / self.full_scale).to_array());
        }
        let rotation = tracker_from_sensor.rotation;
        match coding.attitude {
            None => {}
            Some(Attitude::Angles) => {
                let (azimuth, elevation, roll) = rotation.to_euler(EulerRot::ZYX);
                put(&[azimuth, elevation, roll].map(|angle| angle / PI));
            }
            // The device sends the transpose column by column, which is this row by row.
            Some(Attitude::Matrix) => {
                put(&DMat3::from_quat(rotation).transpose().to_cols_array());
            }
            // It derives its quaternion from that transpose, too: the conjugate.
            Some(Attitude::Quaternion) => {
                let sent = match self.quaternion {
                    QuaternionSign::Conjugate => rotation.conjugate(),
                    QuaternionSign::AsSent => rotation,
                };
                put(&[sent.w, sent.x, sent.y, sent.z]);
            }
        }
        Words::new(&words[..coding.words()])
    }
}

/// The rotation whose matrix has these rows, or `None` where they are not those of one.
fn rotation_of_rows(rows: [DVec3; 3]) -> Option<DQuat> {
    let [x, y, z] = rows;
    let tolerance = Scale::NORM_TOLERANCE;
    let lengths = rows
        .iter()
        .all(|row| (row.length() - 1.0).abs() <= tolerance);
    let square = [x.dot(y), y.dot(z), z.dot(x)]
        .iter()
        .all(|dot| dot.abs() <= tolerance);
    if !lengths || !square || x.cross(y).dot(z) <= 0.0 {
        return None;
    }
    let matrix = DMat3::from_cols(x, y, z).transpose();
    Some(DQuat::from_mat3(&matrix).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flock::record::encode_words;
    use proptest::prelude::*;

    fn turned(degrees: [f64; 3]) -> DQuat {
        let [azimuth, elevation, roll] = degrees.map(f64::to_radians);
        DQuat::from_euler(EulerRot::ZYX, azimuth, elevation, roll)
    }

    fn pose(inches: [f64; 3], degrees: [f64; 3]) -> Rigid {
        Rigid::new(turned(degrees), DVec3::from(inches) * 0.0254)
    }

    /// The pose of all worked examples but those that name another.
    fn worked() -> Rigid {
        pose([12.0, 3.0, -5.0], [30.0, 20.0, 10.0])
    }

    const SCALE: Scale = Scale {
        format: RecordFormat::PositionQuaternion,
        full_scale: 36.0 * 0.0254,
        quaternion: QuaternionSign::Conjugate,
    };

    #[test]
    fn every_worked_example_holds_both_ways() {
        use RecordFormat::{
            Angles, Matrix, Position, PositionAngles, PositionQuaternion, Quaternion,
        };
        let (p, a) = ([12.0, 3.0, -5.0], [30.0, 20.0, 10.0]);
        let (far, none) = ([36.0, -36.0, 18.0], [0.0; 3]);
        // Format, range, inches, degrees, bytes, and inches and degrees as decoded.
        let cases = [
            (Position, 36.0, none, none, "80 00 00 00 00 00", none, none),
            (
                Position,
                36.0,
                p,
                none,
                "AA 15 2A 05 0E 77",
                [11.99707, 2.99707, -5.00098],
                none,
            ),
            (
                Position,
                72.0,
                p,
                none,
                "D5 0A 55 02 47 7B",
                [11.99707, 2.99707, -5.00098],
                none,
            ),
            (
                Position,
                36.0,
                far,
                none,
                "FF 3F 00 40 00 20",
                [35.99561, -36.0, 18.0],
                none,
            ),
            (
                Angles,
                36.0,
                none,
                a,
                "D5 0A 0E 07 47 03",
                none,
                [29.9927, 19.9951, 9.9976],
            ),
            (
                PositionAngles,
                36.0,
                p,
                a,
                "AA 15 2A 05 0E 77 55 0A 0E 07 47 03",
                [11.99707, 2.99707, -5.00098],
                [29.9927, 19.9951, 9.9976],
            ),
            (
                Matrix,
                36.0,
                none,
                a,
                "8A 34 63 63 1C 18 09 1E 3E 38 13 01 0E 6A 38 0A 1D 3B",
                none,
                a,
            ),
            (
                Quaternion,
                36.0,
                none,
                [90.0, 0.0, 0.0],
                "A0 2D 00 00 00 00 5F 52",
                none,
                [90.0, 0.0, 0.0],
            ),
            (
                PositionQuaternion,
                36.0,
                p,
                a,
                "AA 15 2A 05 0E 77 73 3C 47 7D 71 73 57 70",
                [11.99707, 2.99707, -5.00098],
                a,
            ),
            (
                PositionQuaternion,
                36.0,
                none,
                none,
                "80 00 00 00 00 00 7F 3F 00 00 00 00 00 00",
                none,
                none,
            ),
        ];
        for (format, inches, position, degrees, hex, wanted, turn) in cases {
            let scale = Scale {
                format,
                full_scale: inches * 0.0254,
                ..SCALE
            };
            let words = scale.words(&pose(position, degrees));
            let mut bytes = Vec::new();
            encode_words(&words, &mut bytes);
            let expected: Vec<u8> = hex
                .split(' ')
                .map(|byte| u8::from_str_radix(byte, 16).unwrap())
                .collect();
            assert_eq!(bytes, expected, "{format:?}");
            let found = scale.pose(&words).unwrap();
            let wanted = DVec3::from(wanted) * 0.0254;
            assert!(
                (found.translation - wanted).length() < 1e-6,
                "{format:?}: {found:?}"
            );
            // A step of a quaternion's smallest element is a hundredth of a degree.
            assert!(
                found.rotation.angle_between(turned(turn)) < 3e-4,
                "{format:?}: {found:?}"
            );
        }
    }

    #[test]
    fn angles_at_their_ends_hold_both_ways() {
        let scale = Scale {
            format: RecordFormat::Angles,
            ..SCALE
        };
        let words = Words::new(&[32764, -16384, -32768]);
        let found = scale.pose(&words).unwrap().rotation;
        assert!(found.angle_between(turned([179.978, -90.0, -180.0])) < 1e-4);
        assert_eq!(scale.pose(&Words::new(&[0, 20000, 0])), None);
    }

    #[test]
    fn the_worked_words_are_metres_to_the_tenth_of_a_millimetre() {
        let pose = SCALE.pose(&SCALE.words(&worked())).unwrap();
        let expected = DVec3::new(304.726, 76.126, -127.025) * 1e-3;
        assert!((pose.translation - expected).length() < 1e-6);
        assert!((pose.translation - worked().translation).length() < 2e-4);
        assert!(pose.rotation.angle_between(worked().rotation) < 1e-3);
        // Azimuth 90 turns the sensor's x to the transmitter's y.
        let quarter = Rigid::new(turned([90.0, 0.0, 0.0]), DVec3::ZERO);
        let back = SCALE.pose(&SCALE.words(&quarter)).unwrap();
        assert!((back.direction(DVec3::X) - DVec3::Y).length() < 1e-3);
        // With an Extended Range Controller a step is four times as wide.
        let wide = Scale::new(Range::Inches144, RecordFormat::PositionQuaternion);
        let pose = wide.pose(&wide.words(&worked())).unwrap();
        assert!((pose.translation - worked().translation).length() < 8e-4);
    }

    #[test]
    fn one_as_14_bits_is_renormalised() {
        let words = Words::new(&[0, 0, 0, 0x7FFC, 0, 0, 0]);
        assert_eq!(
            SCALE.pose(&words).unwrap().rotation,
            DQuat::from_xyzw(-0.0, -0.0, -0.0, 1.0)
        );
    }

    #[test]
    fn what_is_no_rotation_is_no_pose() {
        for quaternion in [[0; 4], [32000, 0, 0, 0], [32764, 8000, 0, 0], [-32768; 4]] {
            let words: Vec<_> = [0; 3].into_iter().chain(quaternion).collect();
            assert_eq!(SCALE.pose(&Words::new(&words)), None, "{quaternion:?}");
        }
        let matrix = Scale {
            format: RecordFormat::Matrix,
            ..SCALE
        };
        const ONE: i16 = 32764;
        let mirror = [ONE, 0, 0, 0, ONE, 0, 0, 0, -ONE];
        let skew = [ONE, 0, 0, ONE, 0, 0, 0, 0, ONE];
        let short = [ONE, 0, 0, 0, ONE, 0, 0, 0, 30000];
        for words in [[0; 9], mirror, skew, short] {
            assert_eq!(matrix.pose(&Words::new(&words)), None, "{words:?}");
        }
        assert_eq!(matrix.pose(&SCALE.words(&worked())), None);
    }

    proptest! {
        #[test]
        fn poses_come_back_within_a_step(
            inches in proptest::array::uniform3(-35.9..35.9f64),
            azimuth in -179.9..179.9f64,
            elevation in -89.0..89.0f64,
            roll in -179.9..179.9f64,
            range in 0usize..3,
            format in 0usize..7,
        ) {
            let format = RecordFormat::ALL[format];
            let range = [Range::Inches36, Range::Inches72, Range::Inches144][range];
            let scale = Scale::new(range, format);
            let sent = pose(inches, [azimuth, elevation, roll]);
            let words = scale.words(&sent);
            let found = scale.pose(&words).unwrap();
            let coding = Coding::of(format);
            if coding.position {
                let step = range.metres() * 4.0 / 32768.0;
                let off = (found.translation - sent.translation).abs().max_element();
                prop_assert!(off <= step, "{off}");
            }
            if coding.attitude.is_some() {
                let off = found.rotation.angle_between(sent.rotation);
                prop_assert!(off < 1.5e-3, "{off}");
            }
        }
    }
}
