//! A hand as a VRPN server tells it: channels that say how far fingers are bent, and buttons that
//! say which touch something.

use crate::hand::{BentFinger, SensorCalibration};
use crate::{Contacts, Fingers, HandState};
use sandtable_config::VrpnGlove;

/// One hand, and what is known of it.
#[derive(Clone, Debug)]
pub(super) struct VrpnHand {
    sensor: u32,
    /// Each finger's channel, the thumb's first.
    fingers: [Option<(usize, BentFinger)>; 5],
    /// Each finger's button, the thumb's first.
    touching: [Option<u32>; 5],
    hand: HandState,
}

impl VrpnHand {
    /// The hand of a rig's VRPN glove, of which nothing is known yet.
    pub(super) fn new(glove: &VrpnGlove) -> Self {
        let fingers = glove.fingers.map(|finger| {
            let finger = finger?;
            let (grows, least) = (glove.auto_calibration, glove.least_range);
            let calibration = SensorCalibration::new(finger.range, grows, least);
            Some((
                finger.channel,
                BentFinger::new(finger.inverted, calibration),
            ))
        });
        Self {
            sensor: glove.sensor,
            fingers,
            touching: glove.touching,
            hand: HandState::default(),
        }
    }

    /// The sensor that it is told of.
    pub(super) fn sensor(&self) -> u32 {
        self.sensor
    }

    /// Takes all channels; gives the hand, or `None` where none of them is a finger's.
    ///
    /// A finger whose channel is not among them is unknown.
    pub(super) fn bend(&mut self, channels: &[f64]) -> Option<HandState> {
        if self.fingers.iter().all(Option::is_none) {
            return None;
        }
        self.hand.flexion = self.fingers.each_mut().map(|finger| {
            let (channel, finger) = finger.as_mut()?;
            finger.flexion(*channels.get(*channel)?)
        });
        Some(self.hand)
    }

    /// Takes all buttons, bit n for button n; gives the hand, or `None` where none is a finger's.
    pub(super) fn touch(&mut self, pressed: u64) -> Option<HandState> {
        if self.touching.iter().all(Option::is_none) {
            return None;
        }
        let fingers = self.touching.iter().enumerate();
        let touching = fingers.filter_map(|(finger, button)| {
            let down = pressed.checked_shr((*button)?)? & 1 == 1;
            down.then(|| Fingers::number(finger))
        });
        let touching = touching.fold(Fingers::default(), Fingers::with);
        self.hand.contacts = Some(joined(touching));
        Some(self.hand)
    }

    /// Forgets how the hand was, as where its server is connected to anew; what was learnt of its
    /// ranges stays.
    pub(super) fn restart(&mut self) {
        self.hand = HandState::default();
    }

    /// Forgets what was learnt of its ranges.
    pub(super) fn reset_calibration(&mut self) {
        for (_, finger) in self.fingers.iter_mut().flatten() {
            finger.reset();
        }
    }

    /// What was learnt of its ranges.
    pub(super) fn calibration(&self) -> Option<String> {
        let fingers = self.fingers.each_ref();
        BentFinger::ranges(fingers.map(|finger| finger.as_ref().map(|(_, finger)| finger)))
    }
}

/// What the fingers of one hand touch where all that is known is that each touches something.
///
/// A thumb and other fingers are taken to be joined, all of them: so does a hand that pinches or
/// grabs. It may be wrong where both hands' fingers meet two by two. Without the thumb, and for a
/// thumb alone, it is not told what they touch: it may be the other hand's, or one another.
fn joined(touching: Fingers) -> Contacts {
    let mut contacts = Contacts::default();
    if touching.contains(Fingers::THUMB) {
        for finger in 0..5 {
            let this = Fingers::number(finger);
            if touching.contains(this) {
                contacts.own[finger] = touching.without(this);
            }
        }
    }
    contacts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Flexion;
    use crate::hand::{Posture, gesture_of};
    use sandtable_config::{Device, Gesture, Gestures, Rig};

    fn hand(lines: &str) -> VrpnHand {
        let text = format!(
            "name = 'g'\n[camera]\n[devices.g]\nkind = 'vrpn'\naddress = 'G@h'\n{lines}\n\
             table_from_tracker = {{ translation = [0.0, 0.0, 0.0] }}"
        );
        let rig = Rig::parse(&text, "g").unwrap();
        match &rig.devices["g"] {
            Device::Vrpn(vrpn) => VrpnHand::new(vrpn.glove.as_ref().unwrap()),
            _ => panic!("it is a VRPN device"),
        }
    }

    fn bent(hand: &HandState) -> [Option<f64>; 5] {
        hand.flexion.map(|flexion| flexion.map(Flexion::mean))
    }

    #[test]
    fn channels_are_fingers_and_those_that_are_not_there_are_unknown() {
        let mut glove = hand(
            "fingers = { thumb = { channel = 2, range = [0, 4] }, \
             ring = { channel = 0, range = [0, 1], inverted = true }, \
             little = { channel = 5, range = [0, 1] } }",
        );
        let told = glove.bend(&[0.25, 9.0, 1.0]).unwrap();
        assert_eq!(bent(&told), [Some(0.25), None, None, Some(0.75), None]);
        assert_eq!(told.contacts, None);
        assert_eq!(glove.touch(u64::MAX), None);
        let told = glove.bend(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.5]).unwrap();
        assert_eq!(bent(&told)[4], Some(0.5));
    }

    #[test]
    fn a_hand_that_opens_and_closes_is_calibrated() {
        let mut glove = hand("fingers = { index = 1 }");
        assert_eq!(glove.calibration(), None);
        assert_eq!(glove.bend(&[0.0, 0.25]), Some(HandState::default()));
        // Less than a hundredth is noise.
        assert_eq!(glove.bend(&[0.0, 0.2578125]), Some(HandState::default()));
        assert_eq!(bent(&glove.bend(&[0.0, 0.75]).unwrap())[1], Some(1.0));
        assert_eq!(bent(&glove.bend(&[0.0, 0.375]).unwrap())[1], Some(0.25));
        assert_eq!(
            glove.calibration().as_deref(),
            Some("index range = [0.25, 0.75]")
        );
        // A server that is connected to anew is the same glove.
        glove.restart();
        assert_eq!(bent(&glove.bend(&[0.0, 0.5]).unwrap())[1], Some(0.5));
        glove.reset_calibration();
        assert_eq!(bent(&glove.bend(&[0.0, 0.5]).unwrap()), [None; 5]);
    }

    #[test]
    fn a_thumb_and_others_are_joined_and_nothing_else_is_told() {
        // As VRPN's own server has the left hand of PINCH gloves.
        let mut glove =
            hand("touching = { thumb = 5, index = 6, middle = 7, ring = 8, little = 9 }");
        let (thumb, index) = (Fingers::THUMB, Fingers::INDEX);
        let mut own = |pressed: u64| glove.touch(pressed).unwrap().contacts.unwrap();
        let none = Fingers::default();
        assert_eq!(own(0b1_1111), Contacts::default());
        let pinch = own(0b00011 << 5 | 0b11);
        assert_eq!(pinch.own, [index, thumb, none, none, none]);
        assert_eq!(pinch.other, [none; 5]);
        let three = own(0b10011 << 5).own;
        assert_eq!(three[4], thumb.with(index));
        // The thumb alone, and fingers without it, touch something that is not known.
        assert_eq!(own(0b00001 << 5), Contacts::default());
        assert_eq!(own(0b11110 << 5), Contacts::default());
        for (pressed, gesture) in [
            (0b00011, Some(Gesture::Pinch)),
            (0b00111, Some(Gesture::Grab)),
            (0b00000, Some(Gesture::Open)),
            (0b10001, None),
        ] {
            let told = glove.touch(pressed << 5).unwrap();
            let posture = Posture::of(&told, &Gestures::default());
            assert_eq!(gesture_of(&posture, told.contacts.as_ref()), gesture);
        }
        glove.restart();
        assert_eq!(glove.hand, HandState::default());
    }

    #[test]
    fn what_channels_and_buttons_tell_is_one_hand() {
        let mut glove = hand(
            "fingers = { index = { channel = 0, range = [0, 1] } }\n\
             touching = { thumb = 0, index = 1 }",
        );
        assert_eq!(glove.bend(&[0.5]).unwrap().contacts, None);
        let both = glove.touch(0b11).unwrap();
        assert_eq!(bent(&both)[1], Some(0.5));
        let later = glove.bend(&[0.75]).unwrap();
        assert_eq!(
            (bent(&later)[1], later.contacts),
            (Some(0.75), both.contacts)
        );
    }
}
