//! Trackers and gloves on the network: VRPN's messages and DTrack's datagrams.

use super::{device, is_bent_within_its_range};
use sandtable_config::Device;
use sandtable_input::vrpn::{COOKIE, Connection};
use sandtable_input::{Sample, stream_of};
use sandtable_pose::Nanos;
use std::sync::LazyLock;

/// A tracker of two sensors that is a glove, too.
static VRPN: LazyLock<Device> = LazyLock::new(|| {
    device(
        "kind = 'vrpn'\naddress = 'T@h'\nsensors = 2\nbuttons = { sender = 'B' }\n\
         fingers = { thumb = 0, index = { channel = 4, inverted = true, range = [-1, 1] } }\n\
         touching = { thumb = 0, index = 1, little = 63 }\n\
         table_from_tracker = { translation = [0.0, 0.0, 1.0] }",
    )
});

/// What a server of ours says first, behind its cookie: who it has, and what its numbers mean.
static DESCRIPTIONS: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut server = Connection::new(["T", "B", "Other"]);
    server.sent(COOKIE.len());
    server.receive(&COOKIE).expect("a cookie");
    server.outgoing().to_vec()
});

/// The most bytes that a report has.
const LONGEST_READ: usize = 256;

/// A VRPN device's stream: the first byte says whether its numbers have been described, the second
/// how the bytes are cut into reads.
///
/// # Panics
/// Where what comes out is no pose, no axis or no finger, of another time than its read's, or more
/// than the bytes can have told.
pub fn vrpn(data: &[u8]) {
    let [kind, cut, bytes @ ..] = data else {
        return;
    };
    let mut stream = stream_of(&VRPN);
    if kind % 4 > 0 {
        stream.push(&DESCRIPTIONS, Nanos(0), &mut |sample| panic!("{sample:?}"));
    }
    let mut samples = 0;
    for (read, bytes) in (1..).zip(bytes.chunks(1 + usize::from(*cut) % LONGEST_READ)) {
        let arrival = Nanos(read * 20_000_000);
        stream.push(bytes, arrival, &mut |sample| {
            assert_eq!(sample.time(), arrival, "{sample:?}");
            assert!((1..=2).contains(&sample.sensor()), "{sample:?}");
            samples += 1;
            assert!(is_plausible(&sample), "{sample:?}");
        });
    }
    // A report of buttons has 32 bytes, and may be a hand, too.
    assert!(16 * samples <= bytes.len(), "{samples} of {}", bytes.len());
}

/// DTrack controllers with Flysticks and without.
static DTRACK: LazyLock<Vec<Device>> = LazyLock::new(|| {
    let of = |bodies: u32, flysticks: u32| {
        device(&format!(
            "kind = 'dtrack'\nbodies = {bodies}\nflysticks = {flysticks}\n\
             table_from_tracker = {{ translation = [0.0, 0.0, 1.0] }}"
        ))
    };
    vec![of(2, 1), of(1, 0), of(0, 2)]
});

/// Ends a datagram; none has one within.
const BETWEEN_DATAGRAMS: u8 = 0;

/// A DTrack controller's stream: the first byte chooses what it has; datagrams end with a zero.
///
/// # Panics
/// Where what comes out is no pose and no axis, or of a sensor that there is not.
pub fn dtrack(data: &[u8]) {
    let [kind, bytes @ ..] = data else {
        return;
    };
    let device = &DTRACK[usize::from(*kind) % DTRACK.len()];
    let mut stream = stream_of(device);
    for (read, datagram) in (1..).zip(bytes.split(|byte| *byte == BETWEEN_DATAGRAMS)) {
        let arrival = Nanos(read * 16_000_000);
        let mut samples = 0;
        stream.push(datagram, arrival, &mut |sample| {
            assert_eq!(sample.time(), arrival, "{sample:?}");
            let sensors = 1..=device.sensors();
            assert!(sensors.contains(&sample.sensor()), "{sample:?}");
            assert!(is_plausible(&sample), "{sample:?}");
            samples += 1;
        });
        // A body has 16 numbers and its brackets; a Flystick may be three samples of as many.
        assert!(8 * samples <= datagram.len(), "{samples} samples");
    }
}

fn is_plausible(sample: &Sample) -> bool {
    match sample {
        Sample::Pose(pose) => {
            let rigid = &pose.table_from_sensor;
            rigid.translation.is_finite() && rigid.rotation.is_normalized()
        }
        Sample::Axes(axes) => axes.values.iter().all(|value| value.is_finite()),
        Sample::Buttons(_) => true,
        Sample::Hand(hand) => is_bent_within_its_range(&hand.hand),
    }
}
