//! The offer: which senders a hub's sensors are, and what their samples are in VRPN's words.

use crate::vrpn::{BigEndian, Report, TrackerPose};
use crate::{AXES, AxesSample, Contacts, Flexion, HandState, Hub, Sample};
use sandtable_config::SensorName;
use sandtable_pose::Nanos;
use std::collections::BTreeMap;

/// The most buttons of one sensor.
const BUTTONS: usize = u64::BITS as usize;

/// How many of a hand's channels, and of its buttons, are its fingers: the first ones.
const FINGERS: usize = 5;

/// The buttons that are a hand's fingers.
const FINGER_BUTTONS: u64 = (1 << FINGERS) - 1;

/// All senders, and how their buttons and channels are.
#[derive(Debug, Default)]
pub(super) struct Offer {
    senders: Vec<Standing>,
    /// Each device's senders, that of sensor 1 first.
    devices: BTreeMap<String, Vec<usize>>,
}

/// How one sender's buttons and channels are, so far as is known.
#[derive(Debug, Default)]
struct Standing {
    name: String,
    pressed: Option<u64>,
    /// One more than the highest button ever pressed.
    buttons: usize,
    channels: Option<([f64; AXES], usize)>,
    /// Whether its first channels are fingers, of which hands tell and axes do not: a glove of
    /// another server tells the same values as both.
    bends: bool,
    /// Whether its first buttons are fingers, in the same way.
    touches: bool,
}

impl Offer {
    /// What `hub` has, as it is now.
    pub(super) fn of(hub: &Hub) -> Self {
        let mut offer = Self::default();
        for sensor in hub.sensors() {
            let name = match sensor.number {
                1 => sensor.device.clone(),
                _ => sensor.to_string(),
            };
            let senders = offer.devices.entry(sensor.device.clone()).or_default();
            senders.push(offer.senders.len());
            offer.senders.push(Standing {
                name,
                ..Standing::default()
            });
            offer.take_standing(hub, &sensor);
        }
        offer
    }

    /// Takes what buttons and axes were before anyone listened.
    fn take_standing(&mut self, hub: &Hub, sensor: &SensorName) {
        let end = Nanos(u64::MAX);
        let Some(standing) = self.senders.last_mut() else {
            return;
        };
        if let Some(pressed) = hub.buttons_at(sensor, end) {
            standing.press(pressed);
        }
        if let Some(axes) = hub.axes_at(sensor, end) {
            standing.take_axes(&axes);
        }
        if let Some(hand) = hub.hand_at(sensor, end) {
            standing.take_hand(&hand);
            if let Some(pressed) = standing.touch(hand.contacts) {
                standing.press(pressed);
            }
        }
    }

    /// The senders' names, in the order of their numbers.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.senders.iter().map(|standing| standing.name.as_str())
    }

    /// Tells what a sample says to all who are here.
    pub(super) fn tell(
        &mut self,
        device: &str,
        sample: &Sample,
        out: &mut dyn FnMut(i32, &Report<'_>),
    ) {
        let Some(senders) = self.devices.get(device) else {
            return;
        };
        let index = sample.sensor().wrapping_sub(1);
        let (Some(&tracker), Some(&sender)) = (senders.first(), senders.get(index as usize)) else {
            return;
        };
        let standing = &mut self.senders[sender];
        match sample {
            // The sensor is lost, and says so by its silence.
            Sample::Pose(pose) if pose.frozen => {}
            Sample::Pose(pose) => {
                let report = Report::Pose(TrackerPose {
                    sensor: index.cast_signed(),
                    position: pose.table_from_sensor.translation,
                    rotation: pose.table_from_sensor.rotation,
                });
                out(number(tracker), &report);
            }
            Sample::Buttons(buttons) => {
                let pressed = standing.beside_fingers(buttons.pressed);
                standing.tell_buttons(number(sender), pressed, out);
            }
            Sample::Axes(axes) => {
                if standing.take_axes(axes) {
                    standing.tell_channels(number(sender), out);
                }
            }
            Sample::Hand(hand) => {
                if standing.take_hand(&hand.hand) {
                    standing.tell_channels(number(sender), out);
                }
                if let Some(pressed) = standing.touch(hand.hand.contacts) {
                    standing.tell_buttons(number(sender), pressed, out);
                }
            }
        }
    }

    /// Tells how all buttons and channels are, to one who comes late.
    pub(super) fn tell_standing(&self, out: &mut dyn FnMut(i32, &Report<'_>)) {
        for (sender, standing) in self.senders.iter().enumerate() {
            if let Some(pressed) = standing.pressed {
                let state = |n: usize| i32::from(pressed >> n & 1 == 1).to_be_bytes();
                let states: [_; BUTTONS] = std::array::from_fn(state);
                let report = Report::ButtonStates(BigEndian(&states[..standing.buttons]));
                out(number(sender), &report);
            }
            standing.tell_channels(number(sender), out);
        }
    }
}

impl Standing {
    fn press(&mut self, pressed: u64) {
        self.pressed = Some(pressed);
        let highest = (u64::BITS - pressed.leading_zeros()) as usize;
        self.buttons = self.buttons.max(highest);
    }

    /// Takes in a sensor's axes; whether they are to be told. Those of a hand are told with its
    /// fingers, which come after them, and only once.
    fn take_axes(&mut self, axes: &AxesSample) -> bool {
        let count = axes.count.min(AXES);
        match &mut self.channels {
            Some((values, known)) if self.bends => {
                values[FINGERS..].copy_from_slice(&axes.values[FINGERS..]);
                *known = count.max(FINGERS);
                false
            }
            channels => {
                *channels = Some((axes.values, count));
                true
            }
        }
    }

    /// A sensor's own buttons together with the fingers that touch, where it has such.
    fn beside_fingers(&self, pressed: u64) -> u64 {
        if self.touches {
            pressed & !FINGER_BUTTONS | self.pressed.unwrap_or(0) & FINGER_BUTTONS
        } else {
            pressed
        }
    }

    /// The buttons that are pressed with these contacts; `None` where the hand never told of any.
    /// One that is let go touches nothing.
    fn touch(&mut self, contacts: Option<Contacts>) -> Option<u64> {
        self.touches |= contacts.is_some();
        let fingers = u64::from(contacts.unwrap_or_default().fingers().0);
        let own = self.pressed.unwrap_or(0) & !FINGER_BUTTONS;
        self.touches.then_some(own | fingers)
    }

    /// Takes in how far fingers are bent, the thumb first; whether that is known of any.
    ///
    /// VRPN has no word for a value that is not known: such a finger keeps the one it had.
    fn take_hand(&mut self, hand: &HandState) -> bool {
        let known = hand.flexion.iter().any(Option::is_some);
        if known {
            let (mut values, count) = self.channels.unwrap_or_default();
            if !self.bends {
                // Raw values were there, in a unit of their own.
                values[..FINGERS].fill(0.0);
                self.bends = true;
            }
            for (value, flexion) in values.iter_mut().zip(hand.flexion) {
                *value = flexion.map_or(*value, Flexion::mean);
            }
            self.channels = Some((values, count.max(FINGERS)));
        }
        known
    }

    fn tell_buttons(&mut self, sender: i32, pressed: u64, out: &mut dyn FnMut(i32, &Report<'_>)) {
        let changed = self.pressed.unwrap_or(0) ^ pressed;
        self.press(pressed);
        for button in (0..BUTTONS).filter(|n| changed >> n & 1 == 1) {
            let report = Report::ButtonChange {
                button: button as i32,
                state: i32::from(pressed >> button & 1 == 1),
            };
            out(sender, &report);
        }
    }

    fn tell_channels(&self, sender: i32, out: &mut dyn FnMut(i32, &Report<'_>)) {
        if let Some((values, count)) = &self.channels {
            let values = values.map(f64::to_be_bytes);
            out(sender, &Report::Channels(BigEndian(&values[..*count])));
        }
    }
}

/// A sender's number on every connection.
fn number(sender: usize) -> i32 {
    i32::try_from(sender).unwrap_or(i32::MAX)
}
