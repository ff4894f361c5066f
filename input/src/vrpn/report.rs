//! Reports: what a device says, and how it is written in a payload.
//!
//! Numbers are big-endian. A pose is the sensor in source space: its position in metres, and the
//! rotation that turns the source's axes into the sensor's, as a quaternion x, y, z, w.

use glam::{DQuat, DVec3};

/// The most buttons that VRPN's programs know.
pub const MOST_BUTTONS: usize = 256;

/// The most analog channels that VRPN's programs know.
pub const MOST_CHANNELS: usize = 128;

/// What kinds of reports there are; on the wire each connection numbers them as it likes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportKind {
    /// Where a sensor is.
    Pose,
    /// How fast a sensor moves.
    Velocity,
    /// A button was pressed or released.
    ButtonChange,
    /// How all buttons are, for who comes late.
    ButtonStates,
    /// How all analog channels are.
    Channels,
    /// Words for people.
    Text,
    /// A client asks whether the device is there.
    Ping,
    /// It is.
    Pong,
}

impl ReportKind {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Pose,
        Self::Velocity,
        Self::ButtonChange,
        Self::ButtonStates,
        Self::Channels,
        Self::Text,
        Self::Ping,
        Self::Pong,
    ];

    /// The name by which a connection describes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pose => "vrpn_Tracker Pos_Quat",
            Self::Velocity => "vrpn_Tracker Velocity",
            Self::ButtonChange => "vrpn_Button Change",
            Self::ButtonStates => "vrpn_Button States",
            Self::Channels => "vrpn_Analog Channel",
            Self::Text => "vrpn_Base text_message",
            Self::Ping => "vrpn_Base ping_message",
            Self::Pong => "vrpn_Base pong_message",
        }
    }
}

/// What a device says. Lists and texts are borrowed from the message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Report<'a> {
    /// Where a sensor is.
    Pose(TrackerPose),
    /// How fast a sensor moves.
    Velocity(TrackerVelocity),
    /// A button was pressed or released.
    ButtonChange {
        /// The button's number, from 0.
        button: i32,
        /// 1 for pressed, 0 for released.
        state: i32,
    },
    /// How all buttons are, as [`Report::ButtonChange`]'s state, button 0 first.
    ButtonStates(BigEndian<'a, 4>),
    /// How all analog channels are, in the device's own units, channel 0 first.
    Channels(BigEndian<'a, 8>),
    /// Words for people.
    Text(Text<'a>),
    /// A client asks whether the device is there.
    Ping,
    /// It is.
    Pong,
}

/// A sensor's pose in source space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackerPose {
    /// The sensor's number, from 0.
    pub sensor: i32,
    /// Metres.
    pub position: DVec3,
    /// Turns the source's axes into the sensor's.
    pub rotation: DQuat,
}

/// A sensor's motion in source space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackerVelocity {
    /// The sensor's number, from 0.
    pub sensor: i32,
    /// Metres a second.
    pub velocity: DVec3,
    /// The turn within `interval`, about the source's axes.
    pub turn: DQuat,
    /// Seconds.
    pub interval: f64,
}

/// Words for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text<'a> {
    /// 0 for normal, 1 for a warning, 2 for an error.
    pub severity: u32,
    /// How important it is within its severity, 0 the most.
    pub level: u32,
    /// The words, without the zero behind them; mostly ASCII.
    pub words: &'a [u8],
}

/// A list of numbers of `N` bytes, as they are in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BigEndian<'a, const N: usize>(pub &'a [[u8; N]]);

impl<'a> BigEndian<'a, 4> {
    /// The numbers.
    pub fn values(self) -> impl ExactSizeIterator<Item = i32> + 'a {
        self.0.iter().map(|&bytes| i32::from_be_bytes(bytes))
    }
}

impl<'a> BigEndian<'a, 8> {
    /// The numbers.
    pub fn values(self) -> impl ExactSizeIterator<Item = f64> + 'a {
        self.0.iter().map(|&bytes| f64::from_be_bytes(bytes))
    }
}

impl<'a> Report<'a> {
    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> ReportKind {
        match self {
            Self::Pose(_) => ReportKind::Pose,
            Self::Velocity(_) => ReportKind::Velocity,
            Self::ButtonChange { .. } => ReportKind::ButtonChange,
            Self::ButtonStates(_) => ReportKind::ButtonStates,
            Self::Channels(_) => ReportKind::Channels,
            Self::Text(_) => ReportKind::Text,
            Self::Ping => ReportKind::Ping,
            Self::Pong => ReportKind::Pong,
        }
    }

    /// Reads a payload; `None` where it is not one of this kind.
    #[must_use]
    pub fn decode(kind: ReportKind, payload: &'a [u8]) -> Option<Self> {
        match kind {
            ReportKind::Pose => {
                let (sensor, numbers) = tracker_numbers::<7>(payload)?;
                let [x, y, z, quaternion @ ..] = numbers;
                Some(Self::Pose(TrackerPose {
                    sensor,
                    position: DVec3::new(x, y, z),
                    rotation: DQuat::from_array(quaternion),
                }))
            }
            ReportKind::Velocity => {
                let (sensor, numbers) = tracker_numbers::<8>(payload)?;
                let [x, y, z, qx, qy, qz, qw, interval] = numbers;
                Some(Self::Velocity(TrackerVelocity {
                    sensor,
                    velocity: DVec3::new(x, y, z),
                    turn: DQuat::from_xyzw(qx, qy, qz, qw),
                    interval,
                }))
            }
            ReportKind::ButtonChange => match whole::<4>(payload)? {
                [button, state] => Some(Self::ButtonChange {
                    button: i32::from_be_bytes(*button),
                    state: i32::from_be_bytes(*state),
                }),
                _ => None,
            },
            ReportKind::ButtonStates => {
                let (count, states) = whole::<4>(payload)?.split_first()?;
                let count = usize::try_from(i32::from_be_bytes(*count)).ok()?;
                let right = count == states.len() && count <= MOST_BUTTONS;
                right.then_some(Self::ButtonStates(BigEndian(states)))
            }
            ReportKind::Channels => {
                let (count, values) = whole::<8>(payload)?.split_first()?;
                let right = values.len() <= MOST_CHANNELS
                    && f64::from_be_bytes(*count) == values.len() as f64;
                right.then_some(Self::Channels(BigEndian(values)))
            }
            ReportKind::Text => {
                let (severity, rest) = payload.split_first_chunk::<4>()?;
                let (level, words) = rest.split_first_chunk::<4>()?;
                let end = words.iter().position(|&byte| byte == 0);
                Some(Self::Text(Text {
                    severity: u32::from_be_bytes(*severity),
                    level: u32::from_be_bytes(*level),
                    words: &words[..end.unwrap_or(words.len())],
                }))
            }
            ReportKind::Ping => Some(Self::Ping),
            ReportKind::Pong => Some(Self::Pong),
        }
    }

    /// Appends its payload to `out`.
    pub fn encode(&self, out: &mut Vec<u8>) {
        match self {
            Self::Pose(pose) => {
                write_sensor(pose.sensor, out);
                write_doubles(&pose.position.to_array(), out);
                write_doubles(&pose.rotation.to_array(), out);
            }
            Self::Velocity(motion) => {
                write_sensor(motion.sensor, out);
                write_doubles(&motion.velocity.to_array(), out);
                write_doubles(&motion.turn.to_array(), out);
                write_doubles(&[motion.interval], out);
            }
            Self::ButtonChange { button, state } => {
                out.extend_from_slice(&button.to_be_bytes());
                out.extend_from_slice(&state.to_be_bytes());
            }
            Self::ButtonStates(states) => {
                let count = i32::try_from(states.0.len()).unwrap_or(i32::MAX);
                out.extend_from_slice(&count.to_be_bytes());
                out.extend_from_slice(states.0.as_flattened());
            }
            Self::Channels(values) => {
                write_doubles(&[values.0.len() as f64], out);
                out.extend_from_slice(values.0.as_flattened());
            }
            Self::Text(text) => {
                out.extend_from_slice(&text.severity.to_be_bytes());
                out.extend_from_slice(&text.level.to_be_bytes());
                out.extend_from_slice(text.words);
                out.push(0);
            }
            Self::Ping | Self::Pong => {}
        }
    }
}

/// The payload as numbers of `N` bytes, where it is nothing else.
fn whole<const N: usize>(payload: &[u8]) -> Option<&[[u8; N]]> {
    match payload.as_chunks::<N>() {
        (numbers, []) => Some(numbers),
        _ => None,
    }
}

/// A sensor, four bytes of nothing, and `N` doubles.
fn tracker_numbers<const N: usize>(payload: &[u8]) -> Option<(i32, [f64; N])> {
    let (sensor, rest) = payload.split_first_chunk::<4>()?;
    let (_, rest) = rest.split_first_chunk::<4>()?;
    let numbers = <&[[u8; 8]; N]>::try_from(whole::<8>(rest)?).ok()?;
    Some((i32::from_be_bytes(*sensor), numbers.map(f64::from_be_bytes)))
}

fn write_sensor(sensor: i32, out: &mut Vec<u8>) {
    out.extend_from_slice(&sensor.to_be_bytes());
    out.extend_from_slice(&[0; 4]);
}

fn write_doubles(numbers: &[f64], out: &mut Vec<u8>) {
    for number in numbers {
        out.extend_from_slice(&number.to_be_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn encoded(report: &Report<'_>) -> Vec<u8> {
        let mut bytes = Vec::new();
        report.encode(&mut bytes);
        bytes
    }

    #[test]
    fn a_pose_has_64_bytes_in_this_order() {
        let bytes = encoded(&Report::Pose(TrackerPose {
            sensor: 1,
            position: DVec3::new(1.0, 2.0, -0.5),
            rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 1.0),
        }));
        assert_eq!(bytes.len(), 64);
        assert_eq!(bytes[..8], [0, 0, 0, 1, 0, 0, 0, 0]);
        assert_eq!(bytes[8..16], [0x3f, 0xf0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[24..32], [0xbf, 0xe0, 0, 0, 0, 0, 0, 0]);
        // w is the last.
        assert_eq!(bytes[32..56], [0; 24]);
        assert_eq!(bytes[56..], [0x3f, 0xf0, 0, 0, 0, 0, 0, 0]);
        // What stands in the filler is nobody's business.
        let mut filled = bytes.clone();
        filled[4..8].fill(0xaa);
        assert_eq!(
            Report::decode(ReportKind::Pose, &filled),
            Report::decode(ReportKind::Pose, &bytes)
        );
    }

    #[test]
    fn payloads_of_another_length_are_none() {
        for (kind, right) in [
            (ReportKind::Pose, vec![64]),
            (ReportKind::Velocity, vec![72]),
            (ReportKind::ButtonChange, vec![8]),
            // A count of 0, and nothing behind it.
            (ReportKind::ButtonStates, vec![4]),
            (ReportKind::Channels, vec![8]),
            (ReportKind::Text, (8..=2000).collect()),
        ] {
            for length in 0..=2000 {
                let decoded = Report::decode(kind, &[0; 2000][..length]);
                assert_eq!(
                    decoded.is_some(),
                    right.contains(&length),
                    "{kind:?} {length}"
                );
            }
        }
    }

    #[test]
    fn counts_must_be_those_of_what_follows() {
        let states = |count: i32, buttons: usize| {
            let mut bytes = count.to_be_bytes().to_vec();
            bytes.resize(4 + 4 * buttons, 0);
            Report::decode(ReportKind::ButtonStates, &bytes).is_some()
        };
        assert!(states(3, 3) && states(256, 256));
        assert!(!states(2, 3) && !states(-1, 0) && !states(i32::MAX, 1) && !states(257, 257));
        let channels = |count: f64, values: usize| {
            let mut bytes = count.to_be_bytes().to_vec();
            bytes.resize(8 + 8 * values, 0);
            Report::decode(ReportKind::Channels, &bytes).is_some()
        };
        assert!(channels(2.0, 2) && channels(128.0, 128));
        assert!(!channels(f64::NAN, 1) && !channels(1e300, 1) && !channels(1.5, 1));
        assert!(!channels(129.0, 129) && !channels(-1.0, 0));
    }

    #[test]
    fn words_end_at_their_zero() {
        let mut bytes = encoded(&Report::Text(Text {
            severity: 2,
            level: 7,
            words: b"no report",
        }));
        assert_eq!(bytes.len(), 8 + 10);
        bytes.extend_from_slice(b"rest of a buffer");
        let Some(Report::Text(text)) = Report::decode(ReportKind::Text, &bytes) else {
            panic!("no text");
        };
        assert_eq!(
            (text.severity, text.level, text.words),
            (2, 7, &b"no report"[..])
        );
    }

    fn bits(report: Option<Report<'_>>, kind: ReportKind) -> Option<Vec<u8>> {
        report.map(|report| {
            assert_eq!(report.kind(), kind);
            encoded(&report)
        })
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded(
            sensor: i32, state: i32, p: [f64; 3], q: [f64; 4], interval: f64,
            states: Vec<i32>, values: Vec<f64>, words in "[^\0]{0,40}",
        ) {
            let states: Vec<_> = states.iter().map(|s| s.to_be_bytes()).take(256).collect();
            let values: Vec<_> = values.iter().map(|v| v.to_be_bytes()).take(128).collect();
            let (position, rotation) = (DVec3::from_array(p), DQuat::from_array(q));
            for report in [
                Report::Pose(TrackerPose { sensor, position, rotation }),
                Report::Velocity(TrackerVelocity {
                    sensor, velocity: position, turn: rotation, interval,
                }),
                Report::ButtonChange { button: sensor, state },
                Report::ButtonStates(BigEndian(&states)),
                Report::Channels(BigEndian(&values)),
                Report::Text(Text { severity: 1, level: 2, words: words.as_bytes() }),
                Report::Ping,
                Report::Pong,
            ] {
                // By bits: a NaN is as good as any, and not equal to itself.
                let bytes = encoded(&report);
                let back = bits(Report::decode(report.kind(), &bytes), report.kind());
                prop_assert_eq!(back, Some(bytes));
            }
        }

        #[test]
        fn no_payload_makes_it_panic(payload: Vec<u8>) {
            for kind in ReportKind::ALL {
                let report = Report::decode(kind, &payload);
                if let Some(Report::ButtonStates(states)) = report {
                    prop_assert!(states.values().len() <= MOST_BUTTONS);
                }
            }
        }
    }
}
