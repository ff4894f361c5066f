//! Recordings played on a virtual clock, and all that a hub knows.

use sandtable_config::SensorName;
use sandtable_input::{Hub, Replay};
use sandtable_pose::{Nanos, Pose};
use std::path::Path;
use std::time::Duration;

/// A hub that a whole recording was played to, by steps that are no multiple of anything, and the
/// time that the last of them reached.
pub(crate) fn played(file: &Path) -> (Hub, Nanos) {
    let mut replay = Replay::open(file).unwrap();
    let hub = Hub::for_rig(replay.rig());
    let mut time = replay.start();
    while !replay.is_over() {
        replay.advance_to(time, &hub);
        time = time + Duration::from_nanos(16_666_667);
    }
    (hub, time)
}

/// Every pose that a sensor has until `time`, the oldest first.
#[allow(dead_code, reason = "not every test that plays a recording has poses")]
pub(crate) fn all_poses(hub: &Hub, sensor: &SensorName, mut time: Nanos) -> Vec<Pose> {
    let mut poses = Vec::new();
    while let Some(pose) = hub.pose_at(sensor, time) {
        time = pose.time - Duration::from_nanos(1);
        poses.push(pose);
    }
    poses.reverse();
    poses
}
