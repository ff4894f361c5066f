//! A VRPN server's bytes, written by hand, through the stream of a rig's device.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

mod vrpn_by_hand;
mod waiting;

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use sandtable_config::Rig;
use sandtable_input::{Sample, Stream, StreamCounts, stream_of};
use sandtable_pose::Nanos;
use std::time::Duration;
use vrpn_by_hand::{doubles, integers, kind, message, pose, sender};

const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// The stream of a device of two sensors, whose wand and joystick are devices of their own.
fn stream() -> Box<dyn Stream> {
    stream_with("")
}

fn stream_with(line: &str) -> Box<dyn Stream> {
    let text = format!(
        "name = 'lab'\ncamera = {{ horizontal_fov = 60.0 }}\n[devices.t]\nkind = 'vrpn'\n\
         address = 'Tracker0@lab-pc'\nsensors = 2\nbuttons = {{ sender = 'Wand0', sensor = 2 }}\n\
         analogs = {{ sender = 'Joystick0' }}\n{line}\n\
         table_from_tracker = {{ translation = [0.0, 0.0, 1.0], axes = ['y', '-x', 'z'] }}"
    );
    let rig = Rig::parse(&text, "lab.toml").unwrap();
    stream_of(&rig.devices["t"])
}

/// A server's numbers for the names that the tests use.
#[derive(Clone, Copy)]
struct Numbers {
    tracker: i32,
    wand: i32,
    joystick: i32,
    pose: i32,
    change: i32,
    states: i32,
    channels: i32,
}

const FIRST: Numbers = Numbers {
    tracker: 1,
    wand: 2,
    joystick: 3,
    pose: 10,
    change: 11,
    states: 12,
    channels: 13,
};

/// Where every number of the first means something else.
const SECOND: Numbers = Numbers {
    tracker: 2,
    wand: 3,
    joystick: 1,
    pose: 11,
    change: 12,
    states: 13,
    channels: 10,
};

impl Numbers {
    fn descriptions(&self) -> Vec<u8> {
        [
            sender(0, "VRPN Control"),
            sender(self.tracker, "Tracker0"),
            sender(self.wand, "Wand0"),
            sender(self.joystick, "Joystick0"),
            sender(77, "Tracker1"),
            kind(self.pose, "vrpn_Tracker Pos_Quat"),
            kind(self.change, "vrpn_Button Change"),
            kind(self.states, "vrpn_Button States"),
            kind(self.channels, "vrpn_Analog Channel"),
            kind(99, "vrpn_Tracker Velocity"),
            // A type that nobody here knows.
            kind(50, "vrpn_Tracker To_Room"),
        ]
        .concat()
    }

    fn at(&self, number: i32, x: f64) -> Vec<u8> {
        message(
            self.tracker,
            self.pose,
            &pose(number, [x, 0.0, 0.0], IDENTITY),
        )
    }

    /// Some of all that a server says, strangers and unknown types among it.
    fn conversation(&self) -> Vec<u8> {
        let mut bytes = self.descriptions();
        for step in 0..4 {
            bytes.extend(self.at(0, 0.01 * f64::from(step)));
            bytes.extend(self.at(1, 0.5 - 0.01 * f64::from(step)));
            bytes.extend(message(77, self.pose, &pose(0, [9.0; 3], IDENTITY)));
            bytes.extend(message(self.tracker, 50, b"whatever it is"));
            let held = integers(&[3, 0, 1, 0]);
            bytes.extend(message(self.wand, self.states, &held));
            bytes.extend(message(self.wand, self.change, &integers(&[0, 1])));
            bytes.extend(message(self.wand, self.change, &integers(&[1, 0])));
            let axes = doubles(&[2.0, 0.25, -0.5 * f64::from(step)]);
            bytes.extend(message(self.joystick, self.channels, &axes));
        }
        bytes
    }
}

fn ms(ms: u64) -> Nanos {
    Nanos(ms * 1_000_000)
}

/// The samples of chunks that come 16 ms apart.
fn samples(stream: &mut dyn Stream, chunks: &[&[u8]]) -> Vec<Sample> {
    let mut samples = Vec::new();
    for (chunk, n) in chunks.iter().zip(1..) {
        stream.push(chunk, ms(16 * n), &mut |sample| samples.push(sample));
    }
    samples
}

/// A sample without its time.
fn timeless(sample: &Sample) -> String {
    match sample {
        Sample::Pose(s) => format!("{} {:?} {}", s.sensor, s.table_from_sensor, s.frozen),
        Sample::Buttons(s) => format!("{} {:b}", s.sensor, s.pressed),
        Sample::Axes(s) => format!("{} {:?}", s.sensor, &s.values[..s.count]),
        Sample::Hand(s) => format!("{s:?}"),
    }
}

#[test]
fn poses_buttons_and_analogs_are_samples_of_their_sensors() {
    let mut stream = stream();
    let bytes = FIRST.conversation();
    let samples = samples(stream.as_mut(), &[&bytes]);
    let poses: Vec<_> = samples.iter().filter_map(Sample::pose).collect();
    // The first of each sensor waits for a second to vouch for it.
    assert_eq!(poses.len(), 2 * 3);
    assert_eq!(poses[0].sensor, 1);
    // The tracker's x is the table's y, and it sits a metre up.
    let place = poses[0].table_from_sensor.translation;
    assert!(
        (place - DVec3::new(0.0, 0.01, 1.0)).length() < 1e-12,
        "{place}"
    );
    let quarter = DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2);
    assert!(poses[0].table_from_sensor.rotation.angle_between(quarter) < 1e-7);
    assert!(
        poses
            .iter()
            .filter(|p| p.sensor == 2)
            .is_sorted_by(|a, b| a.time < b.time)
    );
    let rest: Vec<_> = samples
        .iter()
        .filter(|s| s.pose().is_none())
        .map(timeless)
        .collect();
    assert_eq!(rest[..4], ["2 10", "2 11", "2 1", "1 [0.25, -0.0]"]);
    let counts = stream.counts();
    assert_eq!(counts.samples, samples.len() as u64);
    assert_eq!((counts.refused, counts.alone), (0, 2));
    assert_eq!((counts.foreign_records, counts.implausible), (8, 0));
}

#[test]
fn how_the_bytes_were_cut_into_reads_changes_no_sample() {
    let bytes = FIRST.conversation();
    let whole: Vec<_> = samples(stream().as_mut(), &[&bytes])
        .iter()
        .map(timeless)
        .collect();
    assert!(whole.len() > 20);
    for at in 0..=bytes.len() {
        let (a, b) = bytes.split_at(at);
        let mut stream = stream();
        let cut: Vec<_> = samples(stream.as_mut(), &[a, b])
            .iter()
            .map(timeless)
            .collect();
        assert_eq!(cut, whole, "cut at {at}");
    }
    let bytewise: Vec<&[u8]> = bytes.chunks(1).collect();
    let mut samples = Vec::new();
    let mut stream = stream();
    for byte in bytewise {
        stream.push(byte, ms(16), &mut |sample| samples.push(timeless(&sample)));
    }
    assert_eq!(samples, whole);
}

#[test]
fn a_restart_forgets_what_the_numbers_meant() {
    let mut stream = stream();
    let whole: Vec<_> = samples(stream.as_mut(), &[&FIRST.conversation()])
        .iter()
        .map(timeless)
        .collect();
    stream.restart();
    // Without descriptions nothing is understood.
    let bare = &FIRST.conversation()[FIRST.descriptions().len()..];
    assert_eq!(samples(stream.as_mut(), &[bare]), []);
    stream.restart();
    let mut again = Vec::new();
    stream.push(&SECOND.conversation(), ms(5000), &mut |s| {
        again.push(timeless(&s))
    });
    assert_eq!(again, whole);
    // And without a restart, the new numbers would have been taken for the old ones.
    let mut confused = stream_with("");
    samples(confused.as_mut(), &[&FIRST.descriptions()]);
    assert_ne!(samples(confused.as_mut(), &[bare]).len(), 0);
    let bare = &SECOND.conversation()[SECOND.descriptions().len()..];
    let wrong = samples(confused.as_mut(), &[bare]);
    assert_ne!(wrong.iter().map(timeless).collect::<Vec<_>>(), whole);
}

fn counts_of(messages: &[Vec<u8>]) -> (Vec<Sample>, StreamCounts) {
    let mut stream = stream();
    samples(stream.as_mut(), &[&FIRST.descriptions()]);
    let chunks: Vec<&[u8]> = messages.iter().map(Vec::as_slice).collect();
    let samples = samples(stream.as_mut(), &chunks);
    (samples, stream.counts())
}

#[test]
fn what_is_no_pose_is_not_let_out() {
    let turned = |quaternion: [f64; 4]| {
        let payload = pose(0, [0.0; 3], quaternion);
        message(FIRST.tracker, FIRST.pose, &payload)
    };
    let bad = [
        turned([0.0; 4]),
        turned([0.0, 0.0, 0.0, 0.98]),
        turned([0.0, 0.0, 0.0, 1.02]),
        turned([f64::NAN, 0.0, 0.0, 1.0]),
        turned([f64::INFINITY; 4]),
        FIRST.at(0, f64::NAN),
        FIRST.at(0, f64::NEG_INFINITY),
        message(FIRST.tracker, FIRST.pose, &[0; 63]),
        message(FIRST.tracker, FIRST.pose, &[0; 72]),
        message(FIRST.wand, FIRST.change, &integers(&[0, 7])),
        message(FIRST.wand, FIRST.states, &integers(&[3, 1])),
        message(FIRST.joystick, FIRST.channels, &doubles(&[1.0, f64::NAN])),
        message(FIRST.joystick, FIRST.channels, &doubles(&[5.0, 0.0])),
    ];
    for bytes in &bad {
        let (samples, counts) = counts_of(&[bytes.clone(), bytes.clone()]);
        assert_eq!(samples, [], "{bytes:?}");
        assert_eq!(counts.implausible, 2);
    }
    let foreign = [
        FIRST.at(-1, 0.0),
        FIRST.at(2, 0.0),
        FIRST.at(i32::MAX, 0.0),
        message(FIRST.wand, FIRST.change, &integers(&[64, 1])),
        message(FIRST.wand, FIRST.change, &integers(&[-1, 1])),
    ];
    for bytes in &foreign {
        let (samples, counts) = counts_of(&[bytes.clone(), bytes.clone()]);
        assert_eq!((samples.len(), counts.foreign_records), (0, 2), "{bytes:?}");
    }
    // A length off by less than a hundredth is made good.
    let (samples, _) = counts_of(&[turned([0.0, 0.0, 0.0, 1.009]), turned([0.0, 0.0, 0.0, 1.0])]);
    assert_eq!(
        samples[0]
            .pose()
            .unwrap()
            .table_from_sensor
            .rotation
            .length(),
        1.0
    );
}

#[test]
fn jumps_are_refused_and_frozen_sensors_are_told() {
    let mut messages: Vec<_> = (0..5).map(|n| FIRST.at(0, 0.001 * f64::from(n))).collect();
    messages.push(FIRST.at(0, 3.0));
    messages.push(FIRST.at(0, 0.006));
    let (samples, counts) = counts_of(&messages);
    // The first has nobody to vouch for it; the jump is the other.
    assert_eq!((samples.len(), counts.refused, counts.alone), (5, 1, 1));
    assert!(
        samples
            .iter()
            .all(|s| s.pose().unwrap().table_from_sensor.translation.y < 0.01)
    );
    let still = vec![FIRST.at(0, 0.5); 150];
    let (samples, _) = counts_of(&still);
    let frozen: Vec<_> = samples.iter().map(|s| s.pose().unwrap().frozen).collect();
    assert_eq!(frozen.iter().position(|&frozen| frozen), Some(98));
    // One that may stand still never is.
    let mut patient = stream_with("frozen_after = 0");
    let bytes = [FIRST.descriptions(), still.concat()].concat();
    let samples = self::samples(patient.as_mut(), &[&bytes]);
    assert!(samples.len() > 100 && samples.iter().all(|s| !s.pose().unwrap().frozen));
}

#[test]
fn an_impossible_length_ends_the_bytes_until_a_restart() {
    for length in [0u32, 23, 65_561, 0x7fff_ffff, u32::MAX] {
        let mut stream = stream();
        let mut bad = FIRST.at(0, 0.0);
        bad[..4].copy_from_slice(&length.to_be_bytes());
        let bytes = [FIRST.descriptions(), bad, FIRST.conversation()].concat();
        assert_eq!(samples(stream.as_mut(), &[&bytes]), [], "{length}");
        assert!(stream.counts().stray_bytes > 0);
        stream.restart();
        assert!(samples(stream.as_mut(), &[&FIRST.conversation()]).len() > 20);
    }
}

#[test]
fn samples_never_go_back_in_time() {
    let mut stream = stream();
    let mut times = Vec::new();
    let bytes = FIRST.conversation();
    for (chunk, arrival) in bytes
        .chunks(300)
        .zip([5, 9, 9, 30, 30, 31].into_iter().cycle())
    {
        stream.push(chunk, ms(arrival), &mut |sample| {
            if sample.pose().is_some() && sample.sensor() == 1 {
                times.push(sample.time());
            }
        });
    }
    assert!(
        times.len() >= 2 && times.is_sorted_by(|a, b| a < b),
        "{times:?}"
    );
    assert!(Duration::ZERO < times[1].since(times[0]));
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes: Vec<u8>, at in 0usize..3000, byte: u8, size in 1usize..200) {
        let mut stream = stream();
        for chunk in bytes.chunks(size) {
            stream.push(chunk, ms(1), &mut |_| {});
        }
        let mut altered = FIRST.conversation();
        let at = at % altered.len();
        altered[at] = byte;
        let mut samples = 0;
        stream.restart();
        for chunk in altered.chunks(size) {
            stream.push(chunk, ms(2), &mut |_| samples += 1);
        }
        prop_assert!(samples <= 100);
    }
}
