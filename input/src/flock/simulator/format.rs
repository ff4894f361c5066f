//! Record formats: the words that a bird sends for its pose in each of them.

use crate::flock::record::word_from_share;
use glam::{DMat3, EulerRot};
use sandtable_pose::Rigid;
use std::f64::consts::PI;

/// What a record holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Format {
    position: bool,
    attitude: Option<Attitude>,
    /// The format's number in a bird's status word.
    pub(crate) number: u16,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Attitude {
    Angles,
    Matrix,
    Quaternion,
}

impl Format {
    /// Position and angles: what a bird sends after power-up.
    pub(crate) const POWER_UP: Self = Self {
        position: true,
        attitude: Some(Attitude::Angles),
        number: 4,
    };

    /// The format that a command chooses, or `None` for any other command.
    pub(crate) fn of_command(command: u8) -> Option<Self> {
        let (position, attitude, number) = match command {
            b'V' => (true, None, 1),
            b'W' => (false, Some(Attitude::Angles), 2),
            b'X' => (false, Some(Attitude::Matrix), 3),
            b'Y' => return Some(Self::POWER_UP),
            b'Z' => (true, Some(Attitude::Matrix), 5),
            b'\\' => (false, Some(Attitude::Quaternion), 7),
            b']' => (true, Some(Attitude::Quaternion), 8),
            _ => return None,
        };
        Some(Self {
            position,
            attitude,
            number,
        })
    }

    /// The words for `tracker_from_sensor`; positions reach over `full_scale` metres.
    pub(crate) fn words(&self, tracker_from_sensor: &Rigid, full_scale: f64) -> Vec<i16> {
        let mut shares = Vec::with_capacity(12);
        if self.position {
            shares.extend((tracker_from_sensor.translation / full_scale).to_array());
        }
        let rotation = tracker_from_sensor.rotation;
        match self.attitude {
            None => {}
            Some(Attitude::Angles) => {
                let (azimuth, elevation, roll) = rotation.to_euler(EulerRot::ZYX);
                shares.extend([azimuth, elevation, roll].map(|angle| angle / PI));
            }
            // The device sends the transpose column by column, which is this row by row.
            Some(Attitude::Matrix) => {
                shares.extend(DMat3::from_quat(rotation).transpose().to_cols_array());
            }
            // It derives its quaternion from that transpose, too: the conjugate.
            Some(Attitude::Quaternion) => {
                shares.extend([rotation.w, -rotation.x, -rotation.y, -rotation.z]);
            }
        }
        shares.into_iter().map(word_from_share).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flock::record::encode_words;
    use crate::flock::simulator::Motion;

    fn bytes(command: u8, inches: [f64; 3], degrees: [f64; 3], range: f64) -> Vec<u8> {
        let pose = Motion::hold(inches, degrees).pose(1, 0.0);
        let words = Format::of_command(command)
            .unwrap()
            .words(&pose, range * 0.0254);
        let mut bytes = Vec::new();
        encode_words(&words, &mut bytes);
        bytes
    }

    #[test]
    fn every_worked_example_has_its_bytes() {
        let (p, a) = ([12.0, 3.0, -5.0], [30.0, 20.0, 10.0]);
        let hex = |text: &str| -> Vec<u8> {
            text.split(' ')
                .map(|byte| u8::from_str_radix(byte, 16).unwrap())
                .collect()
        };
        assert_eq!(
            bytes(b'V', [0.0; 3], [0.0; 3], 36.0),
            hex("80 00 00 00 00 00")
        );
        assert_eq!(bytes(b'V', p, a, 36.0), hex("AA 15 2A 05 0E 77"));
        assert_eq!(bytes(b'V', p, a, 72.0), hex("D5 0A 55 02 47 7B"));
        assert_eq!(
            bytes(b'V', [36.0, -36.0, 18.0], a, 36.0),
            hex("FF 3F 00 40 00 20")
        );
        assert_eq!(bytes(b'W', p, a, 36.0), hex("D5 0A 0E 07 47 03"));
        assert_eq!(
            bytes(b'Y', p, a, 36.0),
            hex("AA 15 2A 05 0E 77 55 0A 0E 07 47 03")
        );
        assert_eq!(
            bytes(b'X', p, a, 36.0),
            hex("8A 34 63 63 1C 18 09 1E 3E 38 13 01 0E 6A 38 0A 1D 3B")
        );
        assert_eq!(
            bytes(b'\\', p, [90.0, 0.0, 0.0], 36.0),
            hex("A0 2D 00 00 00 00 5F 52")
        );
        assert_eq!(
            bytes(b']', p, a, 36.0),
            hex("AA 15 2A 05 0E 77 73 3C 47 7D 71 73 57 70")
        );
    }
}
