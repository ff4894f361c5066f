//! The stream: from a server's bytes, behind its cookie, to samples in the table's frame.
//!
//! Live driver and replay run the same stream, so that a recording gives the same samples. Samples
//! are dated by their arrival: a server's clock is its own.

use super::hand::VrpnHand;
use super::inbound::{Event, Inbound};
use super::message::LengthError;
use super::report::{Report, TrackerPose};
use crate::tracked_sensors::{TrackedSensors, plausible};
use crate::{AXES, AxesSample, ButtonsSample, HandSample, HandState, Sample, Stream, StreamCounts};
use sandtable_config::Vrpn;
use sandtable_pose::Nanos;

/// How many names of other devices are remembered, to tell of them.
const MOST_NAMES: usize = 8;

/// The sender that every server has for itself.
const CONTROL: &[u8] = b"VRPN Control";

/// How much of a text for people is remembered, in bytes.
const LONGEST_TEXT: usize = 200;

/// Turns one server's bytes into samples. No socket, no clock: the chunks bring their times.
#[derive(Clone, Debug)]
pub struct VrpnStream {
    inbound: Inbound,
    device: Device,
}

/// What the device's senders say, and what it means.
#[derive(Clone, Debug)]
struct Device {
    /// The names that are listened for; the inbound side numbers them so.
    senders: Vec<String>,
    described: Vec<bool>,
    /// Which of them tells poses.
    tracker: usize,
    buttons: Buttons,
    analogs: Analogs,
    /// The fingers among buttons and analogs, where it is a glove.
    hand: Option<VrpnHand>,
    sensors: TrackedSensors<[u64; 7]>,
    counts: StreamCounts,
    others: Vec<String>,
    text: Option<ServerText>,
}

#[derive(Clone, Debug)]
struct Buttons {
    sender: usize,
    sensor: u32,
    pressed: u64,
}

#[derive(Clone, Debug)]
struct Analogs {
    sender: usize,
    sensor: u32,
}

/// What a server says in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerText {
    /// 0 for normal, 1 for a warning, 2 for an error.
    pub severity: u32,
    /// The words, cut where they are long.
    pub words: String,
}

impl VrpnStream {
    /// The stream of a rig's VRPN device.
    #[must_use]
    pub fn new(vrpn: &Vrpn) -> Self {
        let mut senders = vec![vrpn.address.sender.clone()];
        let mut number = |name: &String| match senders.iter().position(|known| known == name) {
            Some(number) => number,
            None => {
                senders.push(name.clone());
                senders.len() - 1
            }
        };
        let buttons = Buttons {
            sender: number(&vrpn.buttons.sender),
            sensor: vrpn.buttons.sensor,
            pressed: 0,
        };
        let analogs = Analogs {
            sender: number(&vrpn.analogs.sender),
            sensor: vrpn.analogs.sensor,
        };
        Self {
            inbound: Inbound::new(&senders),
            device: Device {
                described: vec![false; senders.len()],
                tracker: 0,
                buttons,
                analogs,
                hand: vrpn.glove.as_deref().map(VrpnHand::new),
                sensors: TrackedSensors::new(&vrpn.tracking, vrpn.sensors),
                counts: StreamCounts::default(),
                others: Vec::new(),
                text: None,
                senders,
            },
        }
    }

    /// The names of the senders that are listened for.
    #[must_use]
    pub fn senders(&self) -> &[String] {
        &self.device.senders
    }

    /// The first of the senders that the server has not described on this connection.
    #[must_use]
    pub fn missing_sender(&self) -> Option<&str> {
        let device = &self.device;
        let missing = device.described.iter().position(|described| !described)?;
        device.senders.get(missing).map(String::as_str)
    }

    /// Some of the other senders that the server has described.
    #[must_use]
    pub fn other_senders(&self) -> &[String] {
        &self.device.others
    }

    /// What the server has said in words since this was last asked.
    pub fn take_text(&mut self) -> Option<ServerText> {
        self.device.text.take()
    }

    /// Why nothing is understood any more, until a restart.
    #[must_use]
    pub fn problem(&self) -> Option<LengthError> {
        self.inbound.problem()
    }
}

impl Stream for VrpnStream {
    fn push(&mut self, bytes: &[u8], arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        let Self { inbound, device } = self;
        let result = inbound.push(bytes, &mut |event| device.event(event, arrival, out));
        if result.is_err() {
            device.counts.stray_bytes += bytes.len() as u64;
        }
    }

    fn restart(&mut self) {
        self.inbound.restart();
        let device = &mut self.device;
        device.described.fill(false);
        device.others.clear();
        device.text = None;
        // What is held now is told anew.
        device.buttons.pressed = 0;
        if let Some(hand) = &mut device.hand {
            hand.restart();
        }
        device.sensors.restart();
    }

    fn reset_calibration(&mut self) {
        if let Some(hand) = &mut self.device.hand {
            hand.reset_calibration();
        }
    }

    fn calibration(&self) -> Option<String> {
        self.device.hand.as_ref()?.calibration()
    }

    fn counts(&self) -> StreamCounts {
        self.device.counts
    }
}

impl Device {
    fn event(&mut self, event: Event<'_>, arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        self.counts.records += 1;
        match event {
            Event::Sender { name, wanted } => match wanted {
                Some(wanted) => self.described[wanted] = true,
                None if self.others.len() < MOST_NAMES && name != CONTROL => {
                    self.others.push(String::from_utf8_lossy(name).into_owned());
                }
                None => {}
            },
            Event::Report { sender, report, .. } => self.report(sender, report, arrival, out),
            Event::Foreign => self.counts.foreign_records += 1,
            Event::Malformed => self.counts.implausible += 1,
        }
    }

    fn report(
        &mut self,
        sender: usize,
        report: Report<'_>,
        arrival: Nanos,
        out: &mut dyn FnMut(Sample),
    ) {
        match report {
            Report::Pose(pose) if sender == self.tracker => self.pose(&pose, arrival, out),
            Report::ButtonChange { button, state } if sender == self.buttons.sender => {
                let known = u32::try_from(button).ok().and_then(|n| 1u64.checked_shl(n));
                match (known, state) {
                    (Some(bit), 0) => self.press(self.buttons.pressed & !bit, arrival, out),
                    (Some(bit), 1) => self.press(self.buttons.pressed | bit, arrival, out),
                    (None, _) => self.counts.foreign_records += 1,
                    (Some(_), _) => self.counts.implausible += 1,
                }
            }
            Report::ButtonStates(states) if sender == self.buttons.sender => {
                let bit = |(n, state): (u32, i32)| u64::from(state != 0).checked_shl(n);
                let bits = (0..).zip(states.values()).filter_map(bit);
                self.press(bits.fold(0, |pressed, bit| pressed | bit), arrival, out);
            }
            Report::Channels(channels) if sender == self.analogs.sender => {
                let mut values = [0.0; AXES];
                let count = channels.values().len().min(AXES);
                for (value, channel) in values.iter_mut().zip(channels.values()) {
                    *value = channel;
                }
                if values.iter().all(|value| value.is_finite()) {
                    self.counts.samples += 1;
                    out(Sample::Axes(AxesSample {
                        sensor: self.analogs.sensor,
                        time: arrival,
                        values,
                        count,
                    }));
                    let hand = self.hand.as_mut();
                    let told = hand.and_then(|hand| hand.bend(&values[..count]));
                    self.tell_hand(told, arrival, out);
                } else {
                    self.counts.implausible += 1;
                }
            }
            Report::Text(text) => {
                let words = &text.words[..text.words.len().min(LONGEST_TEXT)];
                self.text = Some(ServerText {
                    severity: text.severity,
                    words: String::from_utf8_lossy(words).into_owned(),
                });
            }
            // Velocities are not used; pings are a client's; a pong says by coming all it says.
            _ => {}
        }
    }

    fn pose(&mut self, pose: &TrackerPose, arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        let Ok(index) = usize::try_from(pose.sensor) else {
            self.counts.foreign_records += 1;
            return;
        };
        let (p, q) = (pose.position, pose.rotation);
        let raw = [p.x, p.y, p.z, q.x, q.y, q.z, q.w].map(f64::to_bits);
        let told = plausible(p, q);
        let counts = &mut self.counts;
        if let Some(sample) = self.sensors.sample(index, raw, told, arrival, counts) {
            out(Sample::Pose(sample));
        }
    }

    /// Lets out that exactly these buttons are pressed.
    fn press(&mut self, pressed: u64, arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        self.buttons.pressed = pressed;
        self.counts.samples += 1;
        out(Sample::Buttons(ButtonsSample {
            sensor: self.buttons.sensor,
            time: arrival,
            pressed,
        }));
        let told = self.hand.as_mut().and_then(|hand| hand.touch(pressed));
        self.tell_hand(told, arrival, out);
    }

    /// Lets out how the hand is, if there is one and it was told of.
    fn tell_hand(&mut self, told: Option<HandState>, arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        if let (Some(of), Some(hand)) = (&self.hand, told) {
            self.counts.samples += 1;
            out(Sample::Hand(HandSample {
                sensor: of.sensor(),
                time: arrival,
                hand,
            }));
        }
    }
}
