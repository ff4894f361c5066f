//! Recordings: files as they lie there, and whole ones with anything in their messages.

use sandtable_config::Rig;
use sandtable_input::{Hub, Replay};
use sandtable_pose::Nanos;
use serde_json::json;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, Cursor, Seek, Write};
use std::path::Path;
use std::sync::LazyLock;
use tempfile::NamedTempFile;

/// A rig with a device of every kind.
static RIG: LazyLock<Rig> = LazyLock::new(|| {
    let table = "table_from_tracker = { translation = [0.0, 0.0, 0.0] }";
    let text = format!(
        "{}\n[devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n\
         [devices.glove]\nkind = 'data-glove'\nhand = 'left'\nsensors = 5\n\
         [devices.other]\nkind = 'hid-glove'\nhand = 'left'\nvendor = 1\nproduct = 2\n\
         fingers = {{ index = {{ byte = 1 }} }}\n\
         [devices.vrpn]\nkind = 'vrpn'\naddress = 'T@h'\nfingers = {{ thumb = 0 }}\n{table}\n\
         [devices.dtrack]\nkind = 'dtrack'\n{table}\n",
        Rig::builtin_text("workbench").expect("built in")
    );
    Rig::parse(&text, "the decoders' rig").expect("a rig")
});

thread_local! {
    /// Written anew each time: to make one and to remove it takes longer than to read it.
    static FILE: RefCell<NamedTempFile> =
        RefCell::new(NamedTempFile::new().expect("a temporary file"));
}

/// What messages may be about.
const TOPICS: [&str; 12] = [
    "/devices/flock/bytes",
    "/devices/pinch/bytes",
    "/devices/glove/bytes",
    "/devices/other/bytes",
    "/devices/vrpn/bytes",
    "/devices/dtrack/bytes",
    "/devices/pinch/events",
    "/devices/stranger/bytes",
    "/devices//",
    "/session/placement",
    "/session/gaps",
    "/session/rig",
];

/// A recording: the first byte says whether the rest is the file itself, or the messages of a file
/// that is whole, each of a topic, a time, a length and so many bytes.
///
/// # Panics
/// Where one that cannot be opened is not named, one that can be does not come to its end, or
/// samples go back in time.
pub fn recording(data: &[u8]) {
    let [kind, bytes @ ..] = data else {
        return;
    };
    let whole = kind % 2 == 1;
    let written = if whole {
        of_messages(bytes)
    } else {
        Ok(bytes.to_vec())
    };
    let written = written.expect("messages of any kind make a file");
    FILE.with_borrow_mut(|file| {
        file.rewind().expect("it is a file");
        file.write_all(&written).expect("it can be written");
        let length = file.stream_position().expect("it is a file");
        file.as_file().set_len(length).expect("it can be cut");
        replay(file.path(), whole);
    });
}

/// Opens a recording and plays it twice.
fn replay(path: &Path, whole: bool) {
    let mut replay = match Replay::open(path) {
        Ok(replay) => replay,
        Err(error) => {
            let name = path.file_name().and_then(|name| name.to_str());
            assert!(error.to_string().contains(name.expect("a name")), "{error}");
            return;
        }
    };
    assert!(replay.start() <= replay.end() || whole);
    let hub = Hub::for_rig(replay.rig());
    for _ in 0..2 {
        replay.advance_to(replay.end(), &hub);
        assert!(replay.is_over());
        replay.rewind();
        hub.clear();
    }
    let devices: Vec<String> = replay.rig().devices.keys().cloned().collect();
    for device in devices {
        let mut newest = BTreeMap::new();
        for sample in replay.samples(&device) {
            let newest = newest.entry(sample.sensor()).or_insert(Nanos(0));
            assert!(sample.time() >= *newest, "{sample:?} goes back in time");
            *newest = sample.time();
        }
    }
}

/// A whole file with the rig and these messages.
fn of_messages(mut bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut writer = mcap::WriteOptions::new()
        .compression(None)
        .create(Cursor::new(Vec::new()))
        .map_err(io::Error::other)?;
    let mut number = 0;
    let mut message = |topic: &str, time: u64, data: &[u8]| {
        let channel = writer.add_channel(0, topic, "", &BTreeMap::new());
        let header = mcap::records::MessageHeader {
            channel_id: channel.map_err(io::Error::other)?,
            sequence: number,
            log_time: time,
            publish_time: time,
        };
        number += 1;
        let written = writer.write_to_known_channel(&header, data);
        written.map_err(io::Error::other)
    };
    let rig = json!({ "name": RIG.name, "text": RIG.text() });
    message("/session/rig", 0, rig.to_string().as_bytes())?;
    let mut time = 0u64;
    while let [topic, step, length, rest @ ..] = bytes {
        // Steps from a hundredth of a second to beyond the clock's end, and back to its begin.
        time = match step {
            0 => u64::MAX,
            1 => 0,
            step => time.saturating_add(u64::from(*step) * 10_000_000),
        };
        let (data, left) = rest.split_at(rest.len().min(usize::from(*length)));
        message(TOPICS[usize::from(*topic) % TOPICS.len()], time, data)?;
        bytes = left;
    }
    writer.finish().map_err(io::Error::other)?;
    Ok(writer.into_inner().into_inner())
}
