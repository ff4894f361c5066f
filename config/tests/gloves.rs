//! Gloves in rig files: what their keys mean, what stands where a key is left out, and what an
//! error names.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use sandtable_config::{
    ByteOrder, DataGlove, Device, Gestures, HidAddress, HidBit, HidField, HidGlove, Pinch, Rig,
    RigError, Side,
};
use std::path::Path;
use std::time::Duration;

fn rig(glove: &str) -> Result<Rig, RigError> {
    let text = format!("name = 'g'\n[camera]\n[devices.glove]\n{glove}");
    Rig::parse(&text, "g.toml")
}

fn glove(text: &str) -> Device {
    rig(text).unwrap().devices.remove("glove").unwrap()
}

fn pinch(text: &str) -> Pinch {
    let Device::Pinch(pinch) = glove(&format!("kind = 'pinch'\n{text}")) else {
        panic!("it is a PINCH glove");
    };
    pinch
}

fn data_glove(text: &str) -> DataGlove {
    let Device::DataGlove(glove) = glove(&format!("kind = 'data-glove'\n{text}")) else {
        panic!("it is a data glove");
    };
    glove
}

fn hid_glove(text: &str) -> HidGlove {
    let Device::HidGlove(glove) = glove(&format!("kind = 'hid-glove'\n{text}")) else {
        panic!("it is a HID glove");
    };
    *glove
}

const HID: &str = "kind = 'hid-glove'\nhand = 'left'\nvendor = 0x1234\nproduct = 0\n\
                   report_id = 3\nreport_length = 9\n\
                   buttons = [{ byte = 8, bit = 7 }, { byte = 8 }]\n\
                   [devices.glove.fingers]\n\
                   thumb = { byte = 1, bits = 12, bit = 4, signed = true, inverted = true }\n\
                   little = { byte = 5, bits = 16, byte_order = 'big', range = [100, 60000] }\n";

#[test]
fn pinch_gloves_need_a_port_only() {
    let ms = Duration::from_millis;
    assert_eq!(
        pinch("port = '/dev/ttyUSB1'"),
        Pinch {
            port: "/dev/ttyUSB1".into(),
            baud: 9600,
            timestamps: false,
            byte_pause: ms(250),
            answer_within: ms(1000),
            release_after: ms(250),
            ask_every: Some(ms(10_000)),
            palms: false,
            gestures: Gestures {
                closed_above: 0.6,
                open_below: 0.4,
                settle: ms(50),
            },
        }
    );
    let pinch = pinch(
        "port = '/dev/ttyS0'\nbaud = 19200\ntimestamps = true\nbyte_pause = 0.001\n\
         answer_within = 2\nrelease_after = 0.5\nask_every = 0\npalms = true\n\
         gestures = { closed_above = 0.7, open_below = 0.5, settle = 0 }",
    );
    assert_eq!(
        (pinch.baud, pinch.timestamps, pinch.palms),
        (19200, true, true)
    );
    assert_eq!((pinch.byte_pause, pinch.answer_within), (ms(1), ms(2000)));
    assert_eq!((pinch.release_after, pinch.ask_every), (ms(500), None));
    assert_eq!(pinch.gestures.closed_above, 0.7);
    assert_eq!(pinch.gestures.settle, Duration::ZERO);
}

#[test]
fn data_gloves_know_their_sensors_by_their_number() {
    let five = data_glove("hand = 'right'\nsensors = 5");
    assert_eq!(five.positions, [0, 3, 6, 9, 12]);
    assert_eq!((five.side, five.product), (Side::Right, None));
    assert_eq!(five.address, HidAddress::default());
    assert_eq!(five.byte_order, ByteOrder::BigEndian);
    assert!(five.ranges.is_empty() && five.auto_calibration);
    assert_eq!(five.least_range, 0.01);
    assert_eq!(five.silent_after, Some(Duration::from_secs(2)));
    let fourteen = data_glove("hand = 'left'\nsensors = 14\nproduct = 0");
    assert_eq!(fourteen.positions, (0..14).collect::<Vec<_>>());
    assert_eq!(fourteen.product, Some(0));
    let mine = data_glove(
        "hand = 'left'\nsensors = 5\npositions = [4, 3, 2, 1, 0]\nbyte_order = 'little'\n\
         ranges = [[400, 3600], [400, 3600], [400, 3600], [400, 3600], [0, 4095]]\n\
         auto_calibration = false\nserial_number = 'L7'\npath = '/dev/hidraw3'\nsilent_after = 0",
    );
    assert_eq!(mine.positions, [4, 3, 2, 1, 0]);
    assert_eq!(mine.ranges[4], [0.0, 4095.0]);
    assert_eq!(mine.silent_after, None);
    assert_eq!(mine.address.serial_number.as_deref(), Some("L7"));
    assert_eq!(mine.address.path.as_deref(), Some("/dev/hidraw3"));
}

#[test]
fn hid_gloves_are_what_their_fields_say() {
    let glove = hid_glove(HID.trim_start_matches("kind = 'hid-glove'\n"));
    assert_eq!((glove.vendor, glove.product), (0x1234, 0));
    assert_eq!((glove.report_id, glove.report_length), (Some(3), Some(9)));
    let [thumb, index, _, _, little] = glove.fingers;
    assert_eq!(index, None);
    let thumb = thumb.unwrap();
    assert_eq!(
        thumb.field,
        HidField {
            byte: 1,
            bit: 4,
            bits: 12,
            signed: true,
            byte_order: ByteOrder::LittleEndian
        }
    );
    assert_eq!(
        (thumb.field.limits(), thumb.field.end()),
        ([-2048.0, 2047.0], 3)
    );
    assert!(thumb.inverted && thumb.range.is_none());
    let little = little.unwrap();
    assert_eq!(little.field.byte_order, ByteOrder::BigEndian);
    assert_eq!(little.range, Some([100.0, 60_000.0]));
    assert_eq!(
        glove.buttons,
        [HidBit { byte: 8, bit: 7 }, HidBit { byte: 8, bit: 0 }]
    );
    assert_eq!(glove.shortest_report(), 9);
    assert_eq!(glove.silent_after, None);
}

#[test]
fn each_error_names_file_line_key_and_remedy() {
    let pinch = "kind = 'pinch'\nport = '/dev/ttyS0'\nbaud = 9600\n";
    let data = "kind = 'data-glove'\nhand = 'left'\nsensors = 5\n";
    // (the glove, found in it, written instead, what the error must say)
    let cases: &[(&str, &str, &str, &[&str])] = &[
        (
            pinch,
            "'pinch'",
            "'pinsh'",
            &["kind", "did you mean \"pinch\"?"],
        ),
        (pinch, "port = '/dev/ttyS0'", "", &["port", "is missing"]),
        (pinch, "/dev/ttyS0", "ttyS0", &["port", "absolute path"]),
        (pinch, "baud = 9600", "baud = 9601", &["baud", "9600"]),
        (
            pinch,
            "baud",
            "timestamps = 1\nbaud",
            &["timestamps", "true or false"],
        ),
        (
            pinch,
            "baud",
            "byte_pause = -1\nbaud",
            &["byte_pause", "0 to 2 seconds"],
        ),
        (
            pinch,
            "baud",
            "answer_within = 0\nbaud",
            &["answer_within", "0.05"],
        ),
        (
            pinch,
            "baud",
            "release_after = nan\nbaud",
            &["release_after", "is nan"],
        ),
        (
            pinch,
            "baud",
            "ask_evry = 3\nbaud",
            &["did you mean `ask_every`?"],
        ),
        (
            pinch,
            "baud",
            "hand = 'left'\nbaud",
            &["glove.hand", "is unknown"],
        ),
        (
            pinch,
            "baud",
            "gestures = { closed_above = 0.3 }\nbaud",
            &["glove.gestures.open_below", "at most as much"],
        ),
        (
            pinch,
            "baud",
            "gestures = { closed_above = 1.5 }\nbaud",
            &["glove.gestures.closed_above", "0 to 1"],
        ),
        (
            pinch,
            "baud",
            "gestures = { setle = 1 }\nbaud",
            &["did you mean `settle`?"],
        ),
        (data, "hand = 'left'", "", &["glove.hand", "left or right"]),
        (
            data,
            "sensors = 5",
            "sensors = 16",
            &["glove.sensors", "5 or 14"],
        ),
        (
            data,
            "sensors",
            "product = 0x10000\nsensors",
            &["product", "65535"],
        ),
        (
            data,
            "sensors",
            "path = ''\nsensors",
            &["path", "sandtable doctor"],
        ),
        (
            data,
            "sensors",
            "positions = [1, 2]\nsensors",
            &["2 elements", "array of 5"],
        ),
        (
            data,
            "sensors",
            "positions = [1, 1, 2, 3, 4]\nsensors",
            &["positions[1]", "second time"],
        ),
        (
            data,
            "sensors",
            "positions = [1, 2, 3, 4, 16]\nsensors",
            &["positions[4]", "0 to 15"],
        ),
        (
            data,
            "sensors",
            "ranges = [[0, 1]]\nsensors",
            &["1 elements", "5 pairs"],
        ),
        (
            data,
            "sensors",
            "ranges = [[0, 1], [0, 1], [0, 1], [0, 1], [9, 9]]\nsensors",
            &["ranges[4]", "lower value first"],
        ),
        (
            data,
            "sensors",
            "auto_calibration = false\nsensors",
            &["ranges", "is missing"],
        ),
        (
            data,
            "sensors",
            "least_range = 0\nsensors",
            &["least_range", "0.001 to 0.5"],
        ),
        (
            HID,
            "vendor = 0x1234\n",
            "",
            &["glove.vendor", "is missing", "0x1234"],
        ),
        (
            HID,
            "report_id = 3",
            "report_id = 0",
            &["report_id", "1 to 255"],
        ),
        (
            HID,
            "report_length = 9",
            "report_length = 8",
            &["report_length", "at least 9"],
        ),
        (
            HID,
            "byte = 8 }]",
            "byte = 8, bit = 8 }]",
            &["buttons[1].bit", "0 to 7"],
        ),
        (
            HID,
            "byte = 8 }]",
            "bit = 1 }]",
            &["buttons[1].byte", "is missing"],
        ),
        (
            HID,
            "bits = 16",
            "bits = 12",
            &["fingers.little.byte_order", "whole bytes"],
        ),
        (
            HID,
            "bits = 16",
            "bits = 33",
            &["fingers.little.bits", "1 to 32"],
        ),
        (
            HID,
            "[100, 60000]",
            "[100, 70000]",
            &["little.range[1]", "65535"],
        ),
        (
            HID,
            "buttons",
            "auto_calibration = false\nbuttons",
            &["fingers.thumb", "no `range`"],
        ),
        (
            HID,
            "thumb =",
            "thum =",
            &["glove.fingers.thum", "did you mean `thumb`?"],
        ),
    ];
    for (glove, from, to, needles) in cases {
        assert!(glove.contains(from), "{from:?} is not in the glove");
        let error = rig(&glove.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.starts_with("g.toml, line "), "{error}");
        for needle in *needles {
            assert!(error.contains(needle), "{to:?}: {error}");
        }
    }
    let error = rig("kind = 'hid-glove'\nhand = 'left'\nvendor = 1\nproduct = 2\nfingers = {}");
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("at least one finger")
    );
}

#[test]
fn a_glove_has_sensors_and_gestures_but_no_place() {
    let pinch = glove("kind = 'pinch'\nport = '/dev/ttyS0'");
    assert_eq!(pinch.sensors(), 2);
    assert_eq!(glove(HID).sensors(), 1);
    assert_eq!(pinch.gestures(), Some(&Gestures::default()));
    let workbench = Rig::builtin("workbench").unwrap();
    assert_eq!(workbench.devices["flock"].gestures(), None);
    let text = Rig::builtin_text("workbench").unwrap();
    let text = format!("{text}\n[devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n");
    Rig::parse(&text, "w.toml").unwrap();
    let text = text.replacen("\"flock/2\"", "\"pinch/2\"", 1);
    let error = Rig::parse(&text, "w.toml").unwrap_err().to_string();
    assert!(
        error.contains("hand.sensor") && error.contains("fingers only"),
        "{error}"
    );
}

#[test]
fn the_workbenchs_gloves_are_what_stands_without_a_word() {
    let text = Rig::builtin_text("workbench").unwrap();
    let gloves = text.lines().skip_while(|line| *line != "# [devices.pinch]");
    let gloves = gloves.map_while(|line| line.strip_prefix('#'));
    let gloves: Vec<_> = gloves.map(str::trim_start).collect();
    let text = format!("name = 'g'\n[camera]\n{}", gloves.join("\n"));
    let rig = Rig::parse(&text, "gloves").unwrap();
    let same = |name: &str, short| assert_eq!(rig.devices[name], glove(short), "{name}");
    same("pinch", "kind = 'pinch'\nport = '/dev/ttyUSB1'");
    same("glove", "kind = 'data-glove'\nhand = 'right'\nsensors = 5");
    let Device::HidGlove(other) = &rig.devices["other"] else {
        panic!("it is a HID glove");
    };
    assert_eq!((other.product, other.fingers[1].is_some()), (0x5678, true));
    assert!(rig.devices["far"].gestures().is_some());
}

#[test]
fn only_gloves_on_a_line_have_a_port() {
    let mut rig = rig("kind = 'pinch'\nport = '/dev/ttyS0'").unwrap();
    rig.set_port("glove", Path::new("/dev/pts/3")).unwrap();
    let Device::Pinch(pinch) = &rig.devices["glove"] else {
        panic!("it is a PINCH glove");
    };
    assert_eq!(pinch.port, "/dev/pts/3");
    let mut rig = self::rig(HID).unwrap();
    let error = rig.set_port("glove", Path::new("/dev/pts/3")).unwrap_err();
    assert!(error.to_string().contains("no serial port"), "{error}");
}

#[test]
fn no_cut_or_altered_text_panics() {
    for cut in 0..HID.len() {
        let _ = rig(&HID[..cut]);
        let _ = rig(&format!("{}9{}", &HID[..cut], &HID[cut..]));
    }
}
