//! 5DT's table of gestures: 16 of them, a bit for each finger but the thumb.

use crate::hand::{FingerPosture, Posture};

/// The gesture's number in the maker's table: a finger that is open adds 1 for the index, 2 for
/// the middle, 4 for the ring and 8 for the little finger. `None` where one of them is neither
/// open nor closed, which the maker calls −1.
///
/// With [`Posture::of`] it is the maker's own rule, sample by sample; a posture that is kept and
/// updated does not fall to `None` each time that a finger lies between the thresholds.
#[must_use]
pub fn gesture_code(posture: &Posture) -> Option<u8> {
    let [_, fingers @ ..] = posture.fingers;
    fingers
        .iter()
        .zip([1, 2, 4, 8])
        .try_fold(0, |code, (finger, bit)| {
            Some(match (*finger)? {
                FingerPosture::Open => code | bit,
                FingerPosture::Closed => code,
            })
        })
}

/// What the maker calls a gesture, where it has a name.
#[must_use]
pub fn gesture_name(code: u8) -> Option<&'static str> {
    Some(match code {
        0 => "fist",
        1 => "index finger point",
        3 => "two fingers",
        7 => "three fingers",
        8 => "little finger point",
        15 => "flat hand",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use FingerPosture::{Closed, Open};

    #[test]
    fn each_open_finger_has_its_bit_and_the_thumb_has_none() {
        for code in 0..16u8 {
            let finger = |bit: u8| Some(if code & bit == 0 { Closed } else { Open });
            let four = [1, 2, 4, 8].map(finger);
            for thumb in [None, Some(Open), Some(Closed)] {
                let [index, middle, ring, little] = four;
                let fingers = [thumb, index, middle, ring, little];
                assert_eq!(gesture_code(&Posture { fingers }), Some(code));
            }
            for unknown in 1..5 {
                let mut fingers = [Some(Open); 5];
                fingers[unknown] = None;
                assert_eq!(gesture_code(&Posture { fingers }), None);
            }
        }
        assert_eq!(gesture_name(15), Some("flat hand"));
        assert_eq!(gesture_name(2), None);
    }
}
