//! Postures: which fingers are open and which are closed.

use crate::{Flexion, HandState};
use sandtable_config::Gestures;

/// What a finger counts as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FingerPosture {
    /// It is straight.
    Open,
    /// It is bent.
    Closed,
}

/// What each finger counts as, the thumb first; `None` while that cannot be told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Posture {
    /// The fingers.
    pub fingers: [Option<FingerPosture>; 5],
}

impl Posture {
    /// The posture of a hand of which nothing was known before, by 5DT's rule: a finger is closed
    /// where its higher joint is above the upper threshold, else open where its lower joint is
    /// below the lower one, else neither.
    #[must_use]
    pub fn of(hand: &HandState, thresholds: &Gestures) -> Self {
        let mut posture = Self::default();
        posture.update(hand, thresholds);
        posture
    }

    /// Takes the hand as it is now.
    ///
    /// Beyond 5DT's rule a finger stays what it was until its higher joint has passed the other
    /// threshold; a joint that trembles at one of them would change it at each sample otherwise.
    /// A finger of which nothing is known is nothing.
    pub fn update(&mut self, hand: &HandState, thresholds: &Gestures) {
        for (posture, flexion) in self.fingers.iter_mut().zip(&hand.flexion) {
            *posture = flexion.and_then(|flexion| judge(*posture, flexion, thresholds));
        }
    }
}

fn judge(
    before: Option<FingerPosture>,
    flexion: Flexion,
    thresholds: &Gestures,
) -> Option<FingerPosture> {
    if flexion.higher() > thresholds.closed_above {
        Some(FingerPosture::Closed)
    } else if flexion.higher() < thresholds.open_below
        || before.is_none() && flexion.lower() < thresholds.open_below
    {
        Some(FingerPosture::Open)
    } else {
        before
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use FingerPosture::{Closed, Open};

    fn hand(near: f64, far: f64) -> HandState {
        HandState {
            flexion: [Some(Flexion { near, far }); 5],
            contacts: None,
        }
    }

    #[test]
    fn a_hand_seen_first_is_judged_by_the_makers_rule() {
        let of = |near, far| Posture::of(&hand(near, far), &Gestures::default()).fingers[1];
        assert_eq!(of(0.61, 0.61), Some(Closed));
        assert_eq!(of(0.39, 0.39), Some(Open));
        assert_eq!(of(0.5, 0.5), None);
        assert_eq!([of(0.6, 0.6), of(0.4, 0.4)], [None; 2]);
        // Closed wins: one joint is bent, the other straight.
        assert_eq!([of(0.7, 0.1), of(0.1, 0.7)], [Some(Closed); 2]);
        assert_eq!([of(0.5, 0.1), of(0.1, 0.5)], [Some(Open); 2]);
    }

    #[test]
    fn a_finger_stays_what_it_was_between_the_thresholds() {
        let settings = Gestures::default();
        let mut posture = Posture::default();
        let mut then = |near, far| {
            posture.update(&hand(near, far), &settings);
            posture.fingers[1]
        };
        assert_eq!(then(0.5, 0.5), None);
        assert_eq!(then(0.7, 0.1), Some(Closed));
        assert_eq!(then(0.45, 0.1), Some(Closed));
        assert_eq!(then(0.39, 0.1), Some(Open));
        assert_eq!(then(0.59, 0.5), Some(Open));
        assert_eq!(then(0.61, 0.5), Some(Closed));
        let nothing = HandState::default();
        posture.update(&nothing, &settings);
        assert_eq!(posture, Posture::default());
    }

    #[test]
    fn a_joint_that_trembles_at_a_threshold_changes_its_finger_once() {
        let settings = Gestures::default();
        for (threshold, other) in [(0.6, 0.1), (0.4, 0.1), (0.6, 0.6), (0.4, 0.4)] {
            let mut posture = Posture::default();
            let mut changes = 0;
            for step in 0..1000 {
                let tremble = if step % 2 == 0 { 0.01 } else { -0.01 };
                let before = posture;
                posture.update(&hand(threshold + tremble, other), &settings);
                changes += usize::from(posture != before);
            }
            assert!(changes <= 2, "{changes} at {threshold} beside {other}");
        }
    }
}
