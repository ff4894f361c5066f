//! Rig files: what the built-in ones say, and what an error names.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use glam::{DQuat, DVec3};
use sandtable_config::{
    Device, Hemisphere, Intents, Measure, Range, Rig, RigError, StereoMode, Viewing,
};
use sandtable_motion::{Derivative, OneEuroSettings, Prediction, Smoothing};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

fn workbench() -> String {
    Rig::builtin_text("workbench").unwrap().to_owned()
}

/// The error's text for the workbench with `from` replaced by `to`, which must be there.
fn error(from: &str, to: &str) -> String {
    let text = workbench();
    assert!(text.contains(from), "{from:?} is not in the workbench");
    let error = Rig::parse(&text.replacen(from, to, 1), "w.toml").unwrap_err();
    error.to_string()
}

#[test]
fn the_workbench_is_what_its_file_says() {
    let rig = Rig::builtin("workbench").unwrap();
    let Viewing::Table(table) = &rig.viewing else {
        panic!("{:?}", rig.viewing);
    };
    assert_eq!(table.upper_left, DVec3::new(-0.9, 0.55, 0.0));
    assert_eq!(table.pixels, [1280, 782]);
    assert_eq!(rig.stereo.mode, StereoMode::SideBySide);
    let head = rig.head.as_ref().unwrap();
    assert_eq!(head.sensor.as_ref().unwrap().to_string(), "flock/1");
    assert_eq!(head.eyes.interpupillary, 0.063);
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    assert_eq!((flock.birds, flock.baud), (2, 115_200));
    assert_eq!(flock.range, Range::Inches72);
    assert_eq!(flock.hemisphere, Hemisphere::Upper);
    assert_eq!(flock.addresses(), [1, 2]);
    // A head above the transmitter is above the glass, and a step to the right stays one.
    let above = flock.table_from_tracker.point(DVec3::new(0.0, 0.0, -0.9));
    assert!((above - DVec3::new(0.0, 0.0, 0.6)).length() < 1e-12);
    let right = flock.table_from_tracker.direction(DVec3::Y);
    assert!((right - DVec3::X).length() < 1e-12);
    // The eyes stand side by side along the table's x, nearer to the middle than the sensor.
    let eyes = head.rest.direction(head.eyes.rightwards);
    assert!((eyes - DVec3::X).length() < 1e-12);
}

#[test]
fn the_desktop_needs_no_device() {
    let rig = Rig::builtin("desktop").unwrap();
    assert!(matches!(&rig.viewing, Viewing::Desktop(d) if d.horizontal_fov == 60.0));
    assert!(rig.devices.is_empty() && rig.head.is_none());
    // What the file writes down is what stands without a word.
    assert_eq!(rig.intents, Intents::default());
    assert_eq!(rig.gamepad.dead_zone, 0.15);
    assert_eq!(rig.flight.speed, Measure::Share(0.1));
}

#[test]
fn the_built_in_texts_are_the_files_in_the_folder() {
    for name in ["desktop", "workbench"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("rigs/{name}.toml"));
        let rig = Rig::load(&path).unwrap();
        assert_eq!(rig.text(), Rig::builtin_text(name).unwrap());
    }
    let error = Rig::builtin("workbnch").unwrap_err().to_string();
    assert!(error.contains("desktop or workbench"), "{error}");
}

#[test]
fn each_error_names_file_line_key_and_remedy() {
    // (found in the workbench, written instead, what the error must say)
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "baud = 115200",
            "buad = 9600",
            &["devices.flock.buad", "did you mean `baud`?"],
        ),
        (
            "baud = 115200",
            "baud = 9601",
            &["devices.flock.baud", "is 9601", "9600, 19200"],
        ),
        ("baud = 115200", "baud = \"fast\"", &["is a string", "9600"]),
        (
            "birds = 2",
            "birds = 15",
            &["devices.flock.birds", "1 to 14"],
        ),
        (
            "birds = 2",
            "birds = 1",
            &["hand.sensor", "the sensors 1 to 1"],
        ),
        (
            "birds = 2",
            "bird = 2",
            &["devices.flock.bird", "did you mean `birds`?"],
        ),
        (
            "group = true",
            "group = false",
            &["devices.flock.group", "group mode"],
        ),
        (
            "range = 72",
            "range = 144",
            &["devices.flock.range", "erc_address"],
        ),
        (
            "range = 72",
            "range = 72\nerc_address = 1",
            &["erc_address", "range = 144"],
        ),
        (
            "\"upper\"",
            "\"uper\"",
            &["hemisphere", "did you mean \"upper\"?"],
        ),
        (
            "silence_before = 1.0",
            "silence_before = 0.3",
            &["silence_before", "0.6 to 30 seconds"],
        ),
        (
            "silence_after = 1.5",
            "silence_after = nan",
            &["silence_after", "is nan"],
        ),
        (
            "held_after_ms = 30.0",
            "held_after_ms = 300",
            &["lost_after_ms", "held"],
        ),
        (
            "/dev/ttyUSB0",
            "ttyUSB0",
            &["devices.flock.port", "absolute path"],
        ),
        (
            "/dev/ttyUSB0",
            "/dev/x; rm -rf ~",
            &["devices.flock.port", "never run"],
        ),
        ("/dev/ttyUSB0", "|nc host 1", &["devices.flock.port"]),
        (
            "sensor = \"flock/1\"",
            "sensor = \"flok/1\"",
            &["head.sensor", "flock/1"],
        ),
        (
            "sensor = \"flock/1\"",
            "sensor = \"flock\"",
            &["head.sensor", "\"flock/1\""],
        ),
        (
            "sensor = \"flock/1\"",
            "sensor = 1",
            &["head.sensor", "is a number"],
        ),
        (
            "interpupillary = 0.063",
            "interpupillary = 63",
            &["head.eyes.interpupillary", "0.1 metres"],
        ),
        (
            "rightwards = [0.0, 1.0, 0.0]",
            "rightwards = [0.0, 0.5, 0.0]",
            &["rightwards", "length 1"],
        ),
        (
            "rightwards = [0.0, 1.0, 0.0]",
            "rightwards = [1.0]",
            &["rightwards", "1 elements"],
        ),
        (
            "translation = [0.0, 0.0, -0.30], axes = [\"+y\", \"+x\", \"-z\"]",
            "translation = [0.0, 0.0, -0.30], axes = [\"+y\", \"+x\", \"+z\"]",
            &["axes", "mirror"],
        ),
        (
            "translation = [0.0, 0.0, -0.30], axes = [\"+y\", \"+x\", \"-z\"]",
            "translation = [0.0, 0.0, -0.30], axes = [\"+y\", \"+y\", \"-z\"]",
            &["axes", "twice"],
        ),
        (
            "translation = [0.0, 0.0, -0.30], axes = [\"+y\", \"+x\", \"-z\"]",
            "translation = [0.0, 0.0, -0.30], quaternion = [1, 0, 0, 0.5]",
            &["quaternion", "unit"],
        ),
        (
            "translation = [0.0, 0.0, -0.30]",
            "translation = [0, 0, 1e9]",
            &["table_from_tracker.translation[2]", "-100 to 100 metres"],
        ),
        (
            "upper_left = [-0.90, 0.55, 0.0]",
            "upper_left = [0.0, -0.55, 0.0]",
            &["`table`", "in a line"],
        ),
        (
            "upper_left = [-0.90, 0.55, 0.0]",
            "upper_left = [-0.5, 0.55, 0.0]",
            &["rectangle"],
        ),
        (
            "pixels = [1280, 782]",
            "pixels = [1280, 0]",
            &["table.pixels[1]", "1 to 16384"],
        ),
        (
            "mode = \"side-by-side\"",
            "mode = \"sidebyside\"",
            &["stereo.mode", "side-by-side"],
        ),
        (
            "[flight]",
            "[flihgt]",
            &["flihgt", "did you mean `flight`?"],
        ),
        (
            "forward = [1.0, 0.0, 0.0]",
            "forward = [1.0, 1.0, 0.0]",
            &["hand.forward", "length 1.414"],
        ),
        ("[head]", "[camera]\n[head]", &["table", "keep [camera]"]),
        (
            "kind = \"flock-of-birds\"",
            "kind = \"flock\"",
            &["devices.flock.kind", "flock-of-birds"],
        ),
        (
            "turn_rate = 60.0",
            "turn_rate = true",
            &["flight.turn_rate", "true or false"],
        ),
        (
            "dead_zone = 0.15",
            "dead_zone = 0.15\nright = \"left-stik-x\"",
            &["gamepad.right", "left-stick-x"],
        ),
        ("name = \"workbench\"", "", &["`name`", "is missing"]),
        (
            "hemisphere = \"upper\"",
            "",
            &["devices.flock.hemisphere", "is missing"],
        ),
    ];
    for (from, to, needles) in cases {
        let error = error(from, to);
        assert!(error.starts_with("w.toml, line "), "{error}");
        for needle in *needles {
            assert!(error.contains(needle), "{to:?}: {error}");
        }
    }
}

#[test]
fn the_line_is_the_offending_one() {
    let text = workbench();
    let line = 1 + text.lines().position(|l| l.starts_with("baud")).unwrap();
    let error = error("baud = 115200", "baud = 1");
    assert!(error.contains(&format!("line {line}:")), "{error}");
}

#[test]
fn broken_toml_names_its_line() {
    let error = Rig::parse("name = 'x'\n[table\n", "b.toml").unwrap_err();
    assert!(
        matches!(&error, RigError::Syntax { line: 2, .. }),
        "{error}"
    );
}

#[test]
fn files_that_are_no_rigs_are_refused() {
    let error = Rig::load(Path::new("/nonexistent/r.toml")).unwrap_err();
    assert!(error.to_string().contains("/nonexistent/r.toml"));
    assert!(Rig::load(Path::new("/dev/zero")).is_err());
    let path = std::env::temp_dir().join(format!("sandtable-rig-{}.toml", std::process::id()));
    std::fs::write(&path, b"name = 'x'\n\n# \xFF\n").unwrap();
    let error = Rig::load(&path).unwrap_err();
    std::fs::remove_file(&path).unwrap();
    assert!(
        matches!(&error, RigError::Syntax { line: 3, .. }),
        "{error}"
    );
}

#[test]
fn no_cut_or_altered_text_panics() {
    let text = workbench();
    for cut in (0..text.len()).filter(|&i| text.is_char_boundary(i)) {
        // A cut at a line's end may well be a whole rig; it must only not panic.
        let _ = Rig::parse(&text[..cut], "cut");
        let _ = Rig::parse(&format!("{}9{}", &text[..cut], &text[cut..]), "altered");
    }
}

#[test]
fn sensors_are_smoothed_and_predicted_as_their_tables_say() {
    let parse = |table: &str| {
        let text = format!("{}\n[sensors.\"flock/1\"]\n{table}", workbench());
        Rig::parse(&text, "sensors")
    };
    let rig = parse(
        "smoothing = { kind = \"one-euro\", position = { beta = 40.0, derivative = \"from-raw\" } }\n\
         prediction = { kind = \"double-exponential\", position_ms = 30.0, horizon_ms = 40.0 }\n\
         ahead_ms = 35.0",
    );
    let rig = rig.unwrap();
    let (name, settings) = rig.sensors.first_key_value().unwrap();
    assert_eq!(name.to_string(), "flock/1");
    assert_eq!(settings.ahead.as_millis(), 35);
    let Smoothing::OneEuro { position, attitude } = settings.filter.smoothing else {
        panic!("{settings:?}");
    };
    assert_eq!(
        (position.beta, position.derivative),
        (40.0, Derivative::FromRaw)
    );
    assert_eq!(attitude, OneEuroSettings::ATTITUDE);
    let thirty = Duration::from_millis(30);
    assert_eq!(
        settings.filter.prediction,
        Prediction::DoubleExponential {
            position: thirty,
            attitude: thirty,
            horizon: Duration::from_millis(40),
        }
    );
    for (table, said) in [
        (
            "smoothing = { kind = \"one-evro\" }",
            "did you mean \"one-euro\"?",
        ),
        (
            "prediction = { kind = \"constant-velocity\" }",
            "such as 30",
        ),
        ("smoothing = { kind = \"one-euro\", beta = 1.0 }", "beta"),
        ("ahead_ms = 500.0", "0 to 200 milliseconds"),
        ("gap_ms = nan", "gap_ms"),
        ("ahead_ms = 30.0", "nothing predicts"),
    ] {
        let error = parse(table).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    let text = workbench() + "\n[sensors.\"flock/3\"]\nahead_ms = 1.0";
    let error = Rig::parse(&text, "sensors").unwrap_err().to_string();
    assert!(error.contains("the sensors 1 to 2"), "{error}");
}

#[test]
fn two_devices_on_one_serial_port_are_refused() {
    let text = workbench() + "\n[devices.pinch]\nkind = \"pinch\"\nport = \"/dev/ttyUSB0\"";
    let error = Rig::parse(&text, "w.toml").unwrap_err().to_string();
    let line = text.lines().count();
    let place = format!("w.toml, line {line}: `devices.pinch.port`");
    for part in [&place, "as that of `flock`", "a serial line has one device"] {
        assert!(error.contains(part), "{error}");
    }
}

/// What was recorded must replay, whatever is refused by now.
#[test]
fn what_a_recordings_rig_asks_for_in_vain_is_no_error() {
    for more in [
        "\n[devices.pinch]\nkind = \"pinch\"\nport = \"/dev/ttyUSB0\"",
        "\n[sensors.\"flock/1\"]\nahead_ms = 30.0",
        "\n[intents]\nact = [\"flock/2 button 0\"]\nyaw = [\"flock/2 channel 0\"]",
    ] {
        let text = workbench() + more;
        assert!(Rig::parse(&text, "w.toml").is_err(), "{more}");
        Rig::recorded(&text, "w.mcap", &BTreeMap::new()).unwrap();
    }
}

#[test]
fn a_port_may_come_from_the_command_line() {
    let mut rig = Rig::builtin("workbench").unwrap();
    rig.set_port("flock", Path::new("/tmp/flock")).unwrap();
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    assert_eq!(flock.port, "/tmp/flock");
    let error = rig.set_port("glove", Path::new("/tmp/x")).unwrap_err();
    assert!(error.to_string().contains("it has: flock"), "{error}");
    assert!(rig.set_port("flock", Path::new("/tmp/a b|c")).is_err());
    let error = rig.set_port("flock", Path::new("")).unwrap_err();
    assert!(
        error.to_string().contains("as flock=/dev/ttyUSB0"),
        "{error}"
    );
    rig.set_port("flock", Path::new("near")).unwrap();
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    assert!(flock.port.starts_with('/') && flock.port.ends_with("/near"));
}

#[test]
fn a_bare_number_for_a_length_is_answered_with_how_lengths_are_written() {
    let text = "name = 'mine'\n[camera]\n[flight]\nspeed = 0.1\n";
    assert_eq!(
        Rig::parse(text, "mine.toml").unwrap_err().to_string(),
        "mine.toml, line 4: `flight.speed` is a number; write { metres = M } or { share = S }"
    );
}

#[test]
fn angles_are_the_flocks_own() {
    let text = workbench().replacen(
        "translation = [0.0, 0.0, -0.30], axes = [\"+y\", \"+x\", \"-z\"]",
        "translation = [0.0, 0.0, 0.0], angles = [90.0, 0.0, 0.0]",
        1,
    );
    let rig = Rig::parse(&text, "angles").unwrap();
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    let turned = flock.table_from_tracker.direction(DVec3::X);
    assert!((turned - DVec3::Y).length() < 1e-12);
    assert!(flock.table_from_tracker.rotation.dot(DQuat::IDENTITY) > 0.7);
}

#[test]
fn an_extended_range_controller_takes_its_own_address() {
    let text = workbench().replacen("range = 72", "range = 144\nerc_address = 1", 1);
    let rig = Rig::parse(&text, "erc").unwrap();
    let Device::Flock(flock) = &rig.devices["flock"] else {
        panic!("the workbench has a Flock");
    };
    assert_eq!(flock.units(), 3);
    assert_eq!(flock.addresses(), [2, 3]);
}
