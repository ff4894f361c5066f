//! Gestures: what a hand means by its fingers.

use super::posture::{FingerPosture, Posture};
use super::settling::Settling;
use crate::{Contacts, Fingers, HandState};
use sandtable_config::{Gesture, Gestures};
use sandtable_pose::Nanos;

/// The gesture of a posture and of contacts, as they are at one time.
///
/// By contacts: a thumb that touches the index finger of its own hand pinches, one that touches
/// the middle finger too grabs, and one that touches none is open. By flexion, which needs the
/// four fingers: all closed grab, all open are open, the index finger alone open points, and the
/// index finger alone closed with the thumb pinches. Where a glove tells both, a contact that
/// pinches or grabs counts more, as a touch is sure, and then flexion.
#[must_use]
pub fn gesture_of(posture: &Posture, contacts: Option<&Contacts>) -> Option<Gesture> {
    let thumb = contacts.map(|contacts| contacts.own[0]);
    by_touch(thumb).or_else(|| by_flexion(posture)).or_else(|| {
        let flexion = posture.fingers.iter().any(Option::is_some);
        let free = thumb.is_some_and(Fingers::is_empty);
        (!flexion && free).then_some(Gesture::Open)
    })
}

fn by_touch(thumb: Option<Fingers>) -> Option<Gesture> {
    let thumb = thumb?;
    let index = thumb.contains(Fingers::INDEX);
    match thumb.contains(Fingers::MIDDLE) {
        true if index => Some(Gesture::Grab),
        false if index => Some(Gesture::Pinch),
        _ => None,
    }
}

fn by_flexion(posture: &Posture) -> Option<Gesture> {
    use FingerPosture::{Closed, Open};
    let [thumb, index, middle, ring, little] = posture.fingers;
    match [index?, middle?, ring?, little?] {
        [Closed, Closed, Closed, Closed] => Some(Gesture::Grab),
        [Open, Closed, Closed, Closed] => Some(Gesture::Point),
        [Open, Open, Open, Open] => Some(Gesture::Open),
        [Closed, Open, Open, Open] if thumb == Some(Closed) => Some(Gesture::Pinch),
        _ => None,
    }
}

/// Follows one hand's gestures over time.
///
/// A gesture counts once it has lasted for the rig's `settle`, and until another one has; a hand
/// of which nothing is known means nothing at once, so that a lost glove holds nothing.
#[derive(Clone, Debug)]
pub struct GestureRecogniser {
    settings: Gestures,
    posture: Posture,
    gesture: Settling<Option<Gesture>>,
}

impl GestureRecogniser {
    /// A recogniser by a glove's settings, which has seen nothing yet.
    #[must_use]
    pub fn new(settings: Gestures) -> Self {
        Self {
            settings,
            posture: Posture::default(),
            gesture: Settling::default(),
        }
    }

    /// Takes the hand as it is at `time`, at each frame or for each sample, whether it has changed
    /// or not; gives the gesture that counts now. Time never goes back.
    pub fn update(&mut self, time: Nanos, hand: Option<&HandState>) -> Option<Gesture> {
        let Some(hand) = hand.filter(|hand| **hand != HandState::default()) else {
            self.restart();
            return None;
        };
        self.posture.update(hand, &self.settings);
        let seen = gesture_of(&self.posture, hand.contacts.as_ref());
        self.gesture.update(time, seen, self.settings.settle)
    }

    /// Forgets all that it has seen.
    pub fn restart(&mut self) {
        self.posture = Posture::default();
        self.gesture = Settling::default();
    }

    /// The posture that it goes by.
    #[must_use]
    pub fn posture(&self) -> &Posture {
        &self.posture
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Flexion;
    use std::time::Duration;

    fn bent(fingers: [f64; 5]) -> HandState {
        HandState {
            flexion: fingers.map(|bent| Some(Flexion::of_one_sensor(bent))),
            contacts: None,
        }
    }

    fn touching(thumb: Fingers) -> HandState {
        let mut contacts = Contacts::default();
        contacts.own[0] = thumb;
        HandState {
            contacts: Some(contacts),
            ..HandState::default()
        }
    }

    fn seen(hand: &HandState) -> Option<Gesture> {
        let posture = Posture::of(hand, &Gestures::default());
        gesture_of(&posture, hand.contacts.as_ref())
    }

    fn ms(ms: u64) -> Nanos {
        Nanos(ms * 1_000_000)
    }

    #[test]
    fn bent_fingers_are_gestures() {
        for (fingers, gesture) in [
            ([0.9, 0.9, 0.9, 0.9, 0.9], Some(Gesture::Grab)),
            ([0.1, 0.9, 0.9, 0.9, 0.9], Some(Gesture::Grab)),
            ([0.9, 0.1, 0.9, 0.9, 0.9], Some(Gesture::Point)),
            ([0.9, 0.9, 0.1, 0.1, 0.1], Some(Gesture::Pinch)),
            ([0.1, 0.9, 0.1, 0.1, 0.1], None),
            ([0.9, 0.1, 0.1, 0.1, 0.1], Some(Gesture::Open)),
            ([0.1, 0.1, 0.1, 0.9, 0.9], None),
            ([0.9, 0.9, 0.9, 0.9, 0.5], None),
        ] {
            assert_eq!(seen(&bent(fingers)), gesture, "{fingers:?}");
        }
        // A finger that the glove does not measure is not taken for an open one.
        let mut hand = bent([0.1; 5]);
        hand.flexion[2] = None;
        assert_eq!(seen(&hand), None);
    }

    #[test]
    fn touching_fingers_are_gestures() {
        let (index, middle) = (Fingers::INDEX, Fingers::MIDDLE);
        for (thumb, gesture) in [
            (index, Some(Gesture::Pinch)),
            (index.with(Fingers::LITTLE), Some(Gesture::Pinch)),
            (index.with(middle), Some(Gesture::Grab)),
            (Fingers::ALL.without(Fingers::THUMB), Some(Gesture::Grab)),
            (middle, None),
            (Fingers(0), Some(Gesture::Open)),
        ] {
            assert_eq!(seen(&touching(thumb)), gesture, "{thumb:?}");
        }
        // A glove that tells both: a touch is sure, and without one the fingers tell.
        let both = |fingers, thumb| HandState {
            contacts: touching(thumb).contacts,
            ..bent(fingers)
        };
        assert_eq!(seen(&both([0.1; 5], index)), Some(Gesture::Pinch));
        assert_eq!(seen(&both([0.9; 5], Fingers(0))), Some(Gesture::Grab));
        assert_eq!(seen(&both([0.9, 0.9, 0.9, 0.1, 0.1], Fingers(0))), None);
    }

    #[test]
    fn a_gesture_counts_once_it_has_lasted() {
        let mut hand = GestureRecogniser::new(Gestures::default());
        let (open, pinch) = (touching(Fingers(0)), touching(Fingers::INDEX));
        assert_eq!(hand.update(ms(0), Some(&open)), None);
        assert_eq!(hand.update(ms(49), Some(&open)), None);
        assert_eq!(hand.update(ms(50), Some(&open)), Some(Gesture::Open));
        assert_eq!(hand.update(ms(100), Some(&pinch)), Some(Gesture::Open));
        // A contact that bounces begins anew.
        assert_eq!(hand.update(ms(120), Some(&open)), Some(Gesture::Open));
        assert_eq!(hand.update(ms(130), Some(&pinch)), Some(Gesture::Open));
        assert_eq!(hand.update(ms(179), Some(&pinch)), Some(Gesture::Open));
        assert_eq!(hand.update(ms(180), Some(&pinch)), Some(Gesture::Pinch));
        // So does one that ends.
        assert_eq!(hand.update(ms(200), Some(&open)), Some(Gesture::Pinch));
        assert_eq!(hand.update(ms(210), Some(&pinch)), Some(Gesture::Pinch));
        assert_eq!(hand.update(ms(240), Some(&open)), Some(Gesture::Pinch));
        assert_eq!(hand.update(ms(290), Some(&open)), Some(Gesture::Open));
    }

    #[test]
    fn a_hand_of_which_nothing_is_known_means_nothing_at_once() {
        for lost in [None, Some(HandState::default())] {
            let mut hand = GestureRecogniser::new(Gestures::default());
            let grab = bent([0.9; 5]);
            hand.update(ms(0), Some(&grab));
            assert_eq!(hand.update(ms(50), Some(&grab)), Some(Gesture::Grab));
            assert_eq!(hand.update(ms(51), lost.as_ref()), None);
            // And it has to last again, from nothing on: no finger stays closed for having been.
            assert_eq!(hand.update(ms(52), Some(&bent([0.5; 5]))), None);
            assert_eq!(hand.posture(), &Posture::default());
            assert_eq!(hand.update(ms(60), Some(&grab)), None);
            assert_eq!(hand.update(ms(110), Some(&grab)), Some(Gesture::Grab));
        }
    }

    #[test]
    fn a_hand_that_trembles_at_a_threshold_does_not_flicker() {
        for settle in [Duration::ZERO, Duration::from_millis(50)] {
            for threshold in [0.4, 0.6] {
                let settings = Gestures {
                    settle,
                    ..Gestures::default()
                };
                let mut hand = GestureRecogniser::new(settings);
                let mut told = Vec::new();
                for step in 0..1000u64 {
                    // About the threshold by a hundredth, as noise would be.
                    let noise = ((step * 7919) % 21) as f64 / 1000.0 - 0.01;
                    let gesture = hand.update(ms(10 * step), Some(&bent([threshold + noise; 5])));
                    if told.last() != Some(&gesture) {
                        told.push(gesture);
                    }
                }
                // From nothing to one gesture, and that for good.
                assert!(told.len() <= 2, "{threshold}: {told:?}");
                assert!(told.last().is_some_and(Option::is_some), "{told:?}");
            }
        }
    }
}
