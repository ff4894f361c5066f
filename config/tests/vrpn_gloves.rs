//! Gloves of VRPN servers in rig files.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use sandtable_config::{Device, Gestures, Rig, RigError, Vrpn, VrpnFinger};
use std::time::Duration;

fn rig(lines: &str) -> Result<Rig, RigError> {
    let head =
        "name = 'lab'\n[camera]\n[devices.glove]\nkind = 'vrpn'\naddress = 'Glove0@lab-pc'\n";
    let table = "table_from_tracker = { translation = [0.0, 0.0, 0.0] }";
    Rig::parse(&format!("{head}{lines}\n{table}\n"), "lab.toml")
}

fn vrpn(lines: &str) -> Vrpn {
    match rig(lines).unwrap().devices.remove("glove") {
        Some(Device::Vrpn(vrpn)) => vrpn,
        other => panic!("{other:?}"),
    }
}

fn plain(channel: usize) -> Option<VrpnFinger> {
    Some(VrpnFinger {
        channel,
        inverted: false,
        range: None,
    })
}

#[test]
fn a_device_without_fingers_is_no_glove() {
    assert_eq!(vrpn("").glove, None);
    let rig = rig("").unwrap();
    assert_eq!(rig.devices["glove"].gestures(), None);
}

#[test]
fn fingers_are_channels_with_defaults() {
    let lines = "fingers = { thumb = 0, index = 3, little = 31 }";
    let glove = vrpn(lines).glove.unwrap();
    assert_eq!(glove.fingers, [plain(0), plain(3), None, None, plain(31)]);
    assert_eq!(glove.touching, [None; 5]);
    assert_eq!((glove.sensor, glove.auto_calibration), (1, true));
    assert_eq!(glove.least_range, 0.01);
    let rig = rig(lines).unwrap();
    assert_eq!(rig.devices["glove"].gestures(), Some(&Gestures::default()));
}

#[test]
fn a_glove_is_what_its_lines_say() {
    let vrpn = vrpn(
        "sensors = 3\nanalogs = { sensor = 2 }\nbuttons = { sender = 'Pinch0', sensor = 2 }\n\
         fingers = { index = { channel = 4, inverted = true, range = [-0.5, 2] }, \
         ring = { channel = 5, range = [0, 4095] } }\n\
         touching = { thumb = 5, index = 6, middle = 7, ring = 8, little = 63 }\n\
         auto_calibration = false\nleast_range = 40.95\n\
         gestures = { closed_above = 0.7, open_below = 0.5, settle = 0.1 }",
    );
    let glove = vrpn.glove.unwrap();
    let index = VrpnFinger {
        channel: 4,
        inverted: true,
        range: Some([-0.5, 2.0]),
    };
    assert_eq!(glove.sensor, 2);
    assert_eq!(glove.fingers[1], Some(index));
    assert_eq!(glove.fingers[3].unwrap().range, Some([0.0, 4095.0]));
    assert_eq!(glove.touching, [5, 6, 7, 8, 63].map(Some));
    assert!(!glove.auto_calibration);
    assert_eq!(glove.least_range, 40.95);
    assert_eq!(glove.gestures.settle, Duration::from_millis(100));
}

#[test]
fn buttons_alone_make_a_glove_of_their_sensor() {
    let vrpn = vrpn("sensors = 2\nbuttons = { sensor = 2 }\ntouching = { thumb = 0, index = 1 }");
    let glove = vrpn.glove.unwrap();
    assert_eq!((glove.sensor, glove.fingers), (2, [None; 5]));
    assert_eq!(glove.touching, [Some(0), Some(1), None, None, None]);
}

#[test]
fn each_error_names_its_key_and_its_remedy() {
    for (lines, needles) in [
        ("fingers = 3", &["fingers", "a table"][..]),
        ("fingers = {}", &["fingers", "at least one finger"]),
        ("fingers = { toe = 1 }", &["fingers.toe", "unknown"]),
        ("fingers = { thumb = 32 }", &["fingers.thumb", "0 to 31"]),
        ("fingers = { thumb = 'x' }", &["fingers.thumb", "0 to 31"]),
        (
            "fingers = { thumb = 1, index = 1 }",
            &["fingers.index", "a second time", "own"],
        ),
        (
            "fingers = { thumb = { range = [0, 1] } }",
            &["fingers.thumb.channel", "missing"],
        ),
        (
            "fingers = { thumb = { channel = 0, range = [1, 0] } }",
            &["fingers.thumb.range", "lower value first"],
        ),
        (
            "fingers = { thumb = 0 }\nauto_calibration = false",
            &["fingers.thumb", "range = [lowest, highest]"],
        ),
        ("touching = { thumb = 64 }", &["touching.thumb", "0 to 63"]),
        (
            "touching = { thumb = 2, ring = 2 }",
            &["touching.ring", "a second time"],
        ),
        (
            "sensors = 2\nbuttons = { sensor = 2 }\nfingers = { thumb = 0 }\ntouching = { thumb = 0 }",
            &["touching", "sensor 2", "sensor 1", "the same `sensor`"],
        ),
        ("gestures = { settle = 0.1 }", &["gestures", "unknown"]),
        ("least_range = 1", &["least_range", "unknown"]),
        (
            "fingers = { thumb = 0 }\nleast_range = 0",
            &["least_range", "own units"],
        ),
    ] {
        let error = rig(lines).unwrap_err().to_string();
        assert!(error.starts_with("lab.toml, line "), "{error}");
        for needle in needles {
            assert!(error.contains(needle), "no {needle:?} in {error}");
        }
    }
}
