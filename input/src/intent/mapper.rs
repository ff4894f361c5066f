//! The mapper: the rig's sources, read at a time.

use super::state::IntentState;
use crate::gamepad::beyond_dead_zone;
use crate::hand::{GestureRecogniser, Settling};
use crate::{Contacts, FlightAxes, GamepadState, HandState, Hub};
use sandtable_config::{
    Gesture, Gestures, Intent, IntentKind, Intents, KeyCode, MouseButton, Part, Rig, SensorName,
    Source, Touch,
};
use sandtable_pose::Nanos;
use std::collections::{BTreeMap, HashSet};
use std::time::Duration;

/// What is pressed and pushed at the desk, of which nobody keeps a history.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeskState {
    /// The keys that are down, or went down for a moment since the last update.
    pub keys: HashSet<KeyCode>,
    /// The mouse's left, right and middle button.
    pub mouse: [bool; 3],
    /// The gamepad, where there is one.
    pub gamepad: Option<GamepadState>,
}

/// How far something has to be pushed to be held, and how far back to be let go, so that a trigger
/// that trembles halfway does not flicker.
const HELD: [f64; 2] = [0.5, 0.4];

/// What counts of a gloved hand.
#[derive(Clone, Debug)]
struct GlovedHand {
    settle: Duration,
    recogniser: GestureRecogniser,
    gesture: Option<Gesture>,
    /// Of [`TOUCHES`].
    touches: [bool; TOUCHES.len()],
    settling: [Settling<bool>; TOUCHES.len()],
}

/// All that fingertips can touch.
const TOUCHES: [Touch; 5] = [
    Touch::Thumb(1),
    Touch::Thumb(2),
    Touch::Thumb(3),
    Touch::Thumb(4),
    Touch::OtherHand,
];

impl GlovedHand {
    fn new(settings: &Gestures) -> Self {
        Self {
            settle: settings.settle,
            recogniser: GestureRecogniser::new(settings.clone()),
            gesture: None,
            touches: [false; TOUCHES.len()],
            settling: Default::default(),
        }
    }

    /// Takes the hand as it is at `now`. One of which nothing is known touches nothing at once.
    fn update(&mut self, now: Nanos, hand: Option<&HandState>) {
        self.gesture = self.recogniser.update(now, hand);
        let contacts = hand.and_then(|hand| hand.contacts);
        if contacts.is_none() {
            self.settling = Default::default();
        }
        let contacts = contacts.unwrap_or_default();
        let settling = self.settling.iter_mut().zip(TOUCHES);
        for (counts, (settling, touch)) in self.touches.iter_mut().zip(settling) {
            *counts = settling.update(now, touches(&contacts, touch), self.settle);
        }
    }

    fn restart(&mut self) {
        self.recogniser.restart();
        self.settling = Default::default();
    }
}

/// Maps samples and what is pressed at the desk to intents, as the rig says.
#[derive(Clone, Debug)]
pub struct IntentMapper {
    intents: Intents,
    dead_zone: f64,
    head: Option<SensorName>,
    hand: Option<SensorName>,
    /// The gloved hands that sources name.
    hands: BTreeMap<SensorName, GlovedHand>,
    before: IntentState,
    updated: Nanos,
}

impl IntentMapper {
    /// The mapper of a rig, to which nothing has been said yet.
    #[must_use]
    pub fn new(rig: &Rig) -> Self {
        let gloved = |source: &Source| {
            let (Part::Gesture { sensor, .. } | Part::Touch { sensor, .. }) = &source.part else {
                return None;
            };
            let settings = rig.devices.get(&sensor.device)?.gestures()?;
            Some((sensor.clone(), GlovedHand::new(settings)))
        };
        let sources = rig.intents.iter().flat_map(|(_, sources)| sources);
        Self {
            hands: sources.filter_map(gloved).collect(),
            intents: rig.intents.clone(),
            dead_zone: rig.gamepad.dead_zone,
            head: rig.head.as_ref().and_then(|head| head.sensor.clone()),
            hand: rig.hand.as_ref().and_then(|hand| hand.sensor.clone()),
            before: IntentState::default(),
            updated: Nanos(0),
        }
    }

    /// What people mean at `now`, by what is known of the devices and of the desk. Time never goes
    /// back; where it does, as in a replay that begins anew, the hands are forgotten.
    pub fn update(&mut self, now: Nanos, hub: &Hub, desk: &DeskState) -> IntentState {
        if now < self.updated {
            self.hands.values_mut().for_each(GlovedHand::restart);
            self.updated = now;
        }
        for (sensor, hand) in &mut self.hands {
            hand.update(now, hub.hand_at(sensor, now).as_ref());
        }
        let pose = |sensor: &Option<SensorName>| hub.estimate_at(sensor.as_ref()?, now);
        let mut state = IntentState::default();
        state.look = pose(&self.head);
        state.reach = pose(&self.hand);
        state.flight = FlightAxes {
            right: self.axis(Intent::Right, now, hub, desk),
            forward: self.axis(Intent::Forward, now, hub, desk),
            up: self.axis(Intent::Up, now, hub, desk),
            yaw: self.axis(Intent::Yaw, now, hub, desk),
            pitch: self.axis(Intent::Pitch, now, hub, desk),
            roll: self.axis(Intent::Roll, now, hub, desk),
        };
        let switches = Intent::ALL.into_iter();
        for intent in switches.filter(|intent| intent.kind() != IntentKind::Axis) {
            let before = self.before.holds(intent);
            let sources = self.intents.sources(intent).iter();
            let furthest = sources
                .map(|source| self.value(source, now, hub, desk))
                .fold(0.0, f64::max);
            let held = furthest > HELD[usize::from(before)];
            state.set_held(intent, held, before);
        }
        self.before = state;
        self.updated = now;
        state
    }

    /// How far an axis is pushed by all its sources together.
    fn axis(&self, intent: Intent, now: Nanos, hub: &Hub, desk: &DeskState) -> f64 {
        let sources = self.intents.sources(intent).iter();
        let pushed = sources.map(|source| {
            let value = self.value(source, now, hub, desk);
            if source.inverted { -value } else { value }
        });
        // Adding to 0 keeps a value that is turned from being −0.
        (0.0 + pushed.sum::<f64>()).clamp(-1.0, 1.0)
    }

    /// How far a source is pushed, its sign as it is.
    fn value(&self, source: &Source, now: Nanos, hub: &Hub, desk: &DeskState) -> f64 {
        let on = |is: bool| f64::from(u8::from(is));
        match &source.part {
            Part::Key(code) => on(desk.keys.contains(code)),
            Part::Mouse(MouseButton::Left) => on(desk.mouse[0]),
            Part::Mouse(MouseButton::Right) => on(desk.mouse[1]),
            Part::Mouse(MouseButton::Middle) => on(desk.mouse[2]),
            Part::Gamepad(part) => {
                let value = |pad: GamepadState| pad.value(*part, self.dead_zone);
                desk.gamepad.map_or(0.0, value)
            }
            Part::Button { sensor, number } => {
                let pressed = hub.buttons_between(sensor, self.updated, now);
                on(pressed.unwrap_or(0) >> number & 1 != 0)
            }
            Part::Channel { sensor, number } => {
                let axes = hub.axes_at(sensor, now);
                let value = axes.and_then(|axes| axes.values.get(*number as usize).copied());
                beyond_dead_zone(value.unwrap_or(0.0), self.dead_zone)
            }
            Part::Gesture { sensor, gesture } => {
                let hand = self.hands.get(sensor);
                on(hand.is_some_and(|hand| hand.gesture == Some(*gesture)))
            }
            Part::Touch { sensor, touch } => {
                let place = TOUCHES.iter().position(|known| known == touch);
                let hand = self.hands.get(sensor).zip(place);
                on(hand.is_some_and(|(hand, place)| hand.touches[place]))
            }
        }
    }
}

fn touches(contacts: &Contacts, touch: Touch) -> bool {
    match touch {
        Touch::Thumb(finger) => contacts.own[0].contains(crate::Fingers::number(finger)),
        Touch::OtherHand => contacts.other.iter().any(|fingers| !fingers.is_empty()),
    }
}
