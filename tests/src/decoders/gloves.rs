//! Gloves: the messages of a PINCH box, and reports over USB.

use super::{device, is_bent_within_its_range};
use sandtable_config::Device;
use sandtable_input::data_glove::REPORT_LENGTH;
use sandtable_input::pinch::{ContactGroups, PinchStream};
use sandtable_input::{Sample, Stream, stream_of};
use sandtable_pose::Nanos;
use std::sync::LazyLock;
use std::time::Duration;

/// PINCH gloves with and without timestamps and contacts in the palms.
static PINCH: LazyLock<Vec<Device>> = LazyLock::new(|| {
    let of = |timestamps: bool, palms: bool| {
        device(&format!(
            "kind = 'pinch'\nport = '/dev/ttyS0'\ntimestamps = {timestamps}\npalms = {palms}"
        ))
    };
    vec![
        of(false, false),
        of(true, false),
        of(false, true),
        of(true, true),
    ]
});

/// A PINCH box's stream: the first byte chooses the messages' kind, the second how the bytes are
/// cut into reads.
///
/// # Panics
/// Where hands come out that no fingers can make, of two times or of fewer bytes than a message
/// has, or where doubt outlasts its time.
pub fn pinch(data: &[u8]) {
    let [kind, cut, bytes @ ..] = data else {
        return;
    };
    let Device::Pinch(pinch) = &PINCH[usize::from(*kind) % PINCH.len()] else {
        panic!("they are PINCH gloves");
    };
    let mut stream = PinchStream::new(pinch);
    let mut newest = Nanos(0);
    let mut left = None;
    let mut told = 0;
    for (read, bytes) in (1..).zip(bytes.chunks(1 + usize::from(*cut))) {
        let arrival = Nanos(read * 50_000_000);
        stream.push(bytes, arrival, &mut |sample| {
            let Sample::Hand(hand) = sample else {
                panic!("{sample:?} of gloves");
            };
            // Two that would be of one time are a nanosecond apart.
            let latest = arrival + Duration::from_micros(1);
            assert!(hand.time < latest, "{hand:?} comes from the future");
            match left.take() {
                None => {
                    assert!(hand.sensor == 1 && hand.time > newest, "{hand:?}");
                    left = Some(hand);
                }
                Some(left) => {
                    assert!((hand.sensor, hand.time) == (2, left.time), "{hand:?}");
                    let hands = [left.hand.contacts, hand.hand.contacts];
                    if let [Some(left), Some(right)] = hands {
                        assert!(ContactGroups::of_contacts(&[left, right]).is_some());
                        told += 1;
                    } else {
                        assert_eq!(hands, [None; 2]);
                    }
                }
            }
            newest = hand.time;
        });
        assert_eq!(left, None, "one hand without the other");
        assert!(stream.due().is_none_or(|due| due > arrival));
    }
    let counts = stream.counts();
    assert!(told <= counts.records);
    // Two marks a message.
    assert!(2 * counts.records + counts.stray_bytes <= bytes.len() as u64);
}

/// 5DT gloves of both kinds, that learn their ranges and that know them.
static DATA_GLOVES: LazyLock<Vec<Device>> = LazyLock::new(|| {
    let of = |sensors: usize, more: &str| {
        device(&format!(
            "kind = 'data-glove'\nhand = 'left'\nsensors = {sensors}\n{more}"
        ))
    };
    let ranges = vec!["[400, 3600]"; 14].join(", ");
    let known = format!("auto_calibration = false\nranges = [{ranges}]");
    vec![
        of(5, ""),
        of(14, ""),
        of(14, &known),
        of(5, "byte_order = 'little'\npositions = [15, 0, 7, 3, 1]"),
    ]
});

/// The reports that bytes are cut into: of `usual` length mostly, else of the one that the byte
/// `cut` says.
fn reports(cut: u8, usual: usize, bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let length = if cut < 192 {
        usual
    } else {
        2 * usize::from(cut - 191)
    };
    bytes.chunks(length)
}

/// A 5DT glove's stream: the first byte chooses the glove, the second how long reports are.
///
/// # Panics
/// Where a report of a wrong length is believed, or a finger is bent beyond its range.
pub fn data_glove(data: &[u8]) {
    let [kind, cut, bytes @ ..] = data else {
        return;
    };
    let mut stream = stream_of(&DATA_GLOVES[usize::from(*kind) % DATA_GLOVES.len()]);
    let mut newest = Nanos(0);
    for (read, report) in (1..).zip(reports(*cut, REPORT_LENGTH, bytes)) {
        // Two at one time now and then.
        let arrival = Nanos(0) + Duration::from_millis(10) * (read / 2);
        stream.push(report, arrival, &mut |sample| {
            assert_eq!(report.len(), REPORT_LENGTH, "{sample:?}");
            let Sample::Hand(hand) = sample else {
                panic!("{sample:?} of a glove");
            };
            assert!(hand.time > newest, "{hand:?} goes back in time");
            newest = hand.time;
            assert!(is_bent_within_its_range(&hand.hand), "{hand:?}");
        });
    }
    let counts = stream.counts();
    let whole = counts.records as usize * REPORT_LENGTH;
    assert_eq!(whole + counts.stray_bytes as usize, bytes.len());
}

/// HID gloves whose fields are anywhere, with an id and a length and without.
static HID_GLOVES: LazyLock<Vec<Device>> = LazyLock::new(|| {
    let of = |more: &str| {
        device(&format!(
            "kind = 'hid-glove'\nhand = 'left'\nvendor = 1\nproduct = 2\n{more}"
        ))
    };
    vec![
        of(
            "report_id = 7\nreport_length = 9\nbuttons = [{ byte = 8, bit = 7 }, { byte = 8 }]\n\
            fingers = { thumb = { byte = 1, bits = 12, bit = 4, signed = true, inverted = true }, \
            little = { byte = 5, bits = 16, byte_order = 'big', range = [100, 60000] } }",
        ),
        of("fingers = { index = { byte = 3, bit = 7, bits = 32 }, ring = { byte = 0, bits = 1 } }"),
        of("report_id = 7\nfingers = { middle = { byte = 5, bits = 32, byte_order = 'big' } }"),
    ]
});

/// How many bytes a report of each needs.
const SHORTEST: [usize; 3] = [9, 8, 9];

/// A HID glove's stream: the first byte chooses the glove, the second how long reports are.
///
/// # Panics
/// Where a report is believed that does not hold all fields, or a finger is bent beyond its range.
pub fn hid_glove(data: &[u8]) {
    let [kind, cut, bytes @ ..] = data else {
        return;
    };
    let kind = usize::from(*kind) % HID_GLOVES.len();
    let mut stream = stream_of(&HID_GLOVES[kind]);
    let mut newest = Nanos(0);
    let mut hands = 0;
    for (read, report) in (1..).zip(reports(*cut, SHORTEST[kind], bytes)) {
        let arrival = Nanos(0) + Duration::from_millis(10) * (read / 2);
        stream.push(report, arrival, &mut |sample| {
            assert!(report.len() >= SHORTEST[kind], "{sample:?}");
            match sample {
                Sample::Hand(hand) => {
                    assert!(hand.time > newest, "{hand:?} goes back in time");
                    assert!(is_bent_within_its_range(&hand.hand), "{hand:?}");
                    newest = hand.time;
                    hands += 1;
                }
                Sample::Buttons(buttons) => {
                    assert!(buttons.time == newest && buttons.pressed < 4, "{buttons:?}");
                }
                other => panic!("{other:?} of a glove"),
            }
        });
    }
    assert_eq!(stream.counts().records, hands);
}
