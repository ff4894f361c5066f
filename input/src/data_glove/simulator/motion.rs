//! Motions: how far simulated fingers are bent, as pure functions of time.

use crate::simulator::mixed;
use std::time::Duration;

/// How a simulated hand's fingers are bent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Holds its fingers so, the thumb first, 0 straight to 1 as far as they go.
    Hold([f64; 5]),
    /// Opens, closes, and then makes one gesture after another, as the seed has it.
    Played(u64),
}

const OPEN: [f64; 5] = [0.0; 5];
const FIST: [f64; 5] = [1.0; 5];
const POINT: [f64; 5] = [1.0, 0.0, 1.0, 1.0, 1.0];
const PINCH: [f64; 5] = [0.9, 0.8, 0.1, 0.1, 0.1];

/// From one played posture to the next.
const PLAYED_EVERY: Duration = Duration::from_secs(1);

/// How long the fingers are under way from one to the next.
const UNDER_WAY: Duration = Duration::from_millis(250);

impl Motion {
    /// The names that [`Motion::named`] knows.
    pub const NAMES: [&'static str; 5] = ["open", "fist", "point", "pinch", "play"];

    /// A motion by its name, or `None` where it is not one of [`Motion::NAMES`]; `seed` is that of
    /// what is played.
    #[must_use]
    pub fn named(name: &str, seed: u64) -> Option<Self> {
        match name {
            "open" => Some(Self::Hold(OPEN)),
            "fist" => Some(Self::Hold(FIST)),
            "point" => Some(Self::Hold(POINT)),
            "pinch" => Some(Self::Hold(PINCH)),
            "play" => Some(Self::Played(seed)),
            _ => None,
        }
    }

    /// How far each finger is bent at this time after the motion's begin, the thumb first.
    #[must_use]
    pub fn flexion(&self, time: Duration) -> [f64; 5] {
        match self {
            Self::Hold(fingers) => fingers.map(|bent| bent.clamp(0.0, 1.0)),
            Self::Played(seed) => {
                let number = (time.as_nanos() / PLAYED_EVERY.as_nanos()) as u64;
                let since =
                    Duration::from_nanos((time.as_nanos() % PLAYED_EVERY.as_nanos()) as u64);
                let to = played(*seed, number);
                let from = number
                    .checked_sub(1)
                    .map_or(to, |before| played(*seed, before));
                let way = (since.as_secs_f64() / UNDER_WAY.as_secs_f64()).min(1.0);
                std::array::from_fn(|finger| from[finger] + way * (to[finger] - from[finger]))
            }
        }
    }
}

/// The posture with this number. The first two let whoever reads it learn its ranges.
fn played(seed: u64, number: u64) -> [f64; 5] {
    match number {
        0 => OPEN,
        1 => FIST,
        _ => {
            let random = mixed(seed.wrapping_add(number.wrapping_mul(0x9E37_79B9_7F4A_7C15)));
            [OPEN, FIST, POINT, PINCH][(random % 4) as usize]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_a_motion() {
        for name in Motion::NAMES {
            assert!(Motion::named(name, 0).is_some());
        }
        assert_eq!(Motion::named("dance", 0), None);
    }

    #[test]
    fn a_played_hand_opens_and_closes_and_then_does_everything() {
        let at = |seed, ms| Motion::Played(seed).flexion(Duration::from_millis(ms));
        assert_eq!([at(1, 0), at(1, 999)], [OPEN; 2]);
        assert_eq!(at(1, 1125), [0.5; 5]);
        assert_eq!([at(1, 1250), at(1, 1999)], [FIST; 2]);
        let postures = |seed: u64| -> Vec<[f64; 5]> {
            (0..100)
                .map(|second| at(seed, 1000 * second + 900))
                .collect()
        };
        assert_eq!(postures(3), postures(3));
        assert_ne!(postures(3), postures(4));
        for posture in [OPEN, FIST, POINT, PINCH] {
            assert!(postures(3)[2..].contains(&posture));
        }
        // Nothing jumps: a quarter of a second from end to end, a hundredth of one here.
        for ms in (0..60_000).step_by(10) {
            let (before, after) = (at(3, ms), at(3, ms + 10));
            for (before, after) in before.iter().zip(after) {
                assert!((before - after).abs() < 0.041, "{ms}");
            }
        }
    }
}
