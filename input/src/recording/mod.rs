//! Recordings: what devices said, when, at which rig; and their replay.
//!
//! A recording is an MCAP file with these channels:
//!
//! | topic | what | encoding |
//! |---|---|---|
//! | `/session/rig` | the rig: `{ "name", "text" }`, and `"files"` that it names; first of all | JSON |
//! | `/session/placement` | how the world lies on the table, as the caller gives it | JSON |
//! | `/session/gaps` | messages dropped since the last one: `{ "dropped" }` | JSON |
//! | `/devices/NAME/bytes` | the bytes of each read, as they came; none where only time passed | raw |
//! | `/devices/NAME/events` | `{ "event": "started" }`, `"lost"` or `"calibration-reset"` | JSON |
//! | `/poses/NAME/N` | decoded poses, for viewers | `foxglove.PoseInFrame`, JSON |
//!
//! Log times are nanoseconds since the session's start. Replay reads bytes and events only, and
//! runs them through the live decoders; the poses are there for Foxglove and other viewers.

mod file;
mod foxglove;
mod reader;
mod recorder;
mod replay;

pub use file::RecordError;
pub use reader::ReplayError;
pub use recorder::{Recorder, RecordingSummary};
pub use replay::Replay;

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The topic that placements are recorded under.
pub const PLACEMENT_TOPIC: &str = "/session/placement";

const RIG_TOPIC: &str = "/session/rig";
const GAPS_TOPIC: &str = "/session/gaps";

/// What happens to a device between its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum DeviceEvent {
    /// It was started: what comes now belongs to nothing before.
    Started,
    /// It fell silent or went away.
    Lost,
    /// What was learnt of its ranges was forgotten.
    CalibrationReset,
}

/// The rig as a recording keeps it.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct RigMessage {
    name: String,
    text: String,
    /// The texts of the files that the rig names, by their names there: corrections of bent
    /// fields. Recordings from before there were any have none.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    files: BTreeMap<String, String>,
}

/// What a full queue or disk swallowed.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct GapMessage {
    dropped: u64,
}

fn bytes_topic(device: &str) -> String {
    format!("/devices/{device}/bytes")
}

fn events_topic(device: &str) -> String {
    format!("/devices/{device}/events")
}

fn pose_topic(device: &str, sensor: u32) -> String {
    format!("/poses/{device}/{sensor}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rigs_that_name_no_file_are_written_and_read_as_before_there_were_any() {
        let old = r#"{"name":"lab","text":"name = 'lab'"}"#;
        let message: RigMessage = serde_json::from_str(old).unwrap();
        assert_eq!(message.files, BTreeMap::new());
        assert_eq!(serde_json::to_string(&message).unwrap(), old);
    }
}
