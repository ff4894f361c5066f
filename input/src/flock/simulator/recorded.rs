//! Motions that were recorded.

use crate::Replay;
use sandtable_config::Device;
use sandtable_pose::{Nanos, Rigid};

/// Where the birds of a recorded Flock were, from its first pose to its last; it begins anew then.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedMotion {
    /// Each bird's poses (`tracker_from_sensor`) and their times, bird 1 first.
    birds: Vec<Vec<(Nanos, Rigid)>>,
    first: Nanos,
    last: Nanos,
}

impl RecordedMotion {
    /// The motion of a recorded device, or `None` where it is no Flock or no pose of it was
    /// recorded.
    #[must_use]
    pub fn of(replay: &Replay, device: &str) -> Option<Self> {
        // What the line said, not what a correction made of it: whoever hears it corrects it again.
        let mut bent = replay.rig().devices.get(device)?.clone();
        bent.leave_field_bent();
        let Device::Flock(flock) = &bent else {
            return None;
        };
        let tracker_from_table = flock.table_from_tracker.inverse();
        let mut birds = vec![Vec::new(); flock.birds as usize];
        for sample in replay.samples_as(device, &bent) {
            if let Some(pose) = sample.pose()
                && let Some(poses) = birds.get_mut(pose.sensor as usize - 1)
            {
                poses.push((pose.time, tracker_from_table * pose.table_from_sensor));
            }
        }
        let times = || birds.iter().flatten().map(|(time, _)| *time);
        let (first, last) = (times().min()?, times().max()?);
        Some(Self { birds, first, last })
    }

    /// How many birds it has.
    #[must_use]
    pub fn birds(&self) -> u32 {
        self.birds.len() as u32
    }

    /// Where bird `bird` (from 1) was `seconds` after the first pose of any; its own first pose
    /// before that, and `None` where it had none at all.
    #[must_use]
    pub fn pose(&self, bird: u32, seconds: f64) -> Option<Rigid> {
        let poses = self.birds.get((bird as usize).checked_sub(1)?)?;
        let lasting = self.last.since(self.first).as_secs_f64();
        let seconds = if lasting > 0.0 {
            seconds % lasting
        } else {
            0.0
        };
        let time = Nanos(self.first.0 + Nanos::from_seconds(seconds).0);
        let later = poses.partition_point(|(then, _)| *then <= time);
        let (_, pose) = poses.get(later.saturating_sub(1))?;
        Some(*pose)
    }
}
