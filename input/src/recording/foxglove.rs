//! Poses as Foxglove's well-known `foxglove.PoseInFrame`, in JSON.

use crate::PoseSample;
use serde_json::{Value, json};

/// The schema's name, by which viewers know what to draw.
pub(crate) const SCHEMA_NAME: &str = "foxglove.PoseInFrame";

/// The frame that recorded poses are in.
const FRAME: &str = "table";

/// A sample as a message's value.
pub(crate) fn pose_in_frame(sample: &PoseSample) -> Value {
    let position = sample.table_from_sensor.translation;
    let orientation = sample.table_from_sensor.rotation;
    let nanos = sample.time.0;
    json!({
        "timestamp": { "sec": nanos / 1_000_000_000, "nsec": nanos % 1_000_000_000 },
        "frame_id": FRAME,
        "pose": {
            "position": { "x": position.x, "y": position.y, "z": position.z },
            "orientation": {
                "x": orientation.x, "y": orientation.y, "z": orientation.z, "w": orientation.w,
            },
        },
    })
}

/// The JSON schema of [`pose_in_frame`]'s messages.
pub(crate) fn schema() -> Value {
    let numbers = |names: &[&str]| {
        let properties: serde_json::Map<String, Value> = names
            .iter()
            .map(|name| ((*name).to_owned(), json!({ "type": "number" })))
            .collect();
        json!({ "type": "object", "properties": properties })
    };
    json!({
        "title": SCHEMA_NAME,
        "description": "A timestamped pose for an object or reference frame in 3D space",
        "type": "object",
        "properties": {
            "timestamp": {
                "type": "object",
                "title": "time",
                "properties": {
                    "sec": { "type": "integer", "minimum": 0 },
                    "nsec": { "type": "integer", "minimum": 0, "maximum": 999_999_999 },
                },
            },
            "frame_id": { "type": "string" },
            "pose": {
                "title": "foxglove.Pose",
                "type": "object",
                "properties": {
                    "position": numbers(&["x", "y", "z"]),
                    "orientation": numbers(&["x", "y", "z", "w"]),
                },
            },
        },
    })
}
