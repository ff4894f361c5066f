//! The hub: the newest poses of every sensor, and how far to trust them.
//!
//! Device threads write samples, everyone else asks for the pose at a time of their own. A sensor's
//! history is short and its lock is held for a search in it at most, so that no writer waits long
//! for a reader, and none for another sensor's.

use crate::flock::{Sample, record_period};
use sandtable_config::{Device, Rig, SensorName};
use sandtable_pose::{Nanos, Pose, Validity};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Poses by sensor and time. The sensors are those of the rig that it was made for.
#[derive(Debug, Default)]
pub struct Hub {
    /// Each device's sensors, number 1 first.
    devices: BTreeMap<String, Vec<Sensor>>,
}

#[derive(Debug)]
struct Sensor {
    held_after: Duration,
    lost_after: Duration,
    history: Mutex<VecDeque<Sample>>,
}

/// Samples kept of each sensor: five seconds of the usual cycle.
const HISTORY: usize = 512;

impl Hub {
    /// A hub for all sensors of a rig, none of which has a pose yet.
    #[must_use]
    pub fn for_rig(rig: &Rig) -> Self {
        let sensors = |device: &Device| {
            let Device::Flock(flock) = device;
            // A slow line brings records less often than a pose may be old.
            let held_after = flock.held_after.max(3 * record_period(flock));
            let sensor = || Sensor {
                held_after,
                lost_after: flock.lost_after.max(held_after),
                history: Mutex::default(),
            };
            (0..device.sensors()).map(|_| sensor()).collect()
        };
        Self {
            devices: rig
                .devices
                .iter()
                .map(|(name, device)| (name.clone(), sensors(device)))
                .collect(),
        }
    }

    /// Adds a sample of a device's sensor; one of an unknown sensor is ignored.
    pub fn push(&self, device: &str, sample: Sample) {
        if let Some(sensor) = self.sensor(device, sample.sensor) {
            sensor.push(sample);
        }
    }

    /// The newest pose measured at or before `time`, in the table's frame, or `None` where the
    /// sensor has had none or is unknown.
    ///
    /// It is live while young, held for a while, then lost; it is never replaced by a default.
    #[must_use]
    pub fn pose_at(&self, sensor: &SensorName, time: Nanos) -> Option<Pose> {
        self.sensor(&sensor.device, sensor.number)?.pose_at(time)
    }

    /// The sensors, in order.
    pub fn sensors(&self) -> impl Iterator<Item = SensorName> {
        self.devices.iter().flat_map(|(device, sensors)| {
            (1..).zip(sensors).map(|(number, _)| SensorName {
                device: device.clone(),
                number,
            })
        })
    }

    /// Forgets every pose, as before a recording is played anew.
    pub fn clear(&self) {
        for sensor in self.devices.values().flatten() {
            sensor.lock().clear();
        }
    }

    fn sensor(&self, device: &str, number: u32) -> Option<&Sensor> {
        let index = number.checked_sub(1)? as usize;
        self.devices.get(device)?.get(index)
    }
}

impl Sensor {
    fn lock(&self) -> std::sync::MutexGuard<'_, VecDeque<Sample>> {
        // No code that can panic runs under the lock; a poisoned history is whole.
        self.history.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, sample: Sample) {
        let mut history = self.lock();
        if history.len() == HISTORY {
            history.pop_front();
        }
        history.push_back(sample);
    }

    fn pose_at(&self, time: Nanos) -> Option<Pose> {
        let sample = {
            let history = self.lock();
            let later = history.partition_point(|sample| sample.time <= time);
            history.get(later.checked_sub(1)?).copied()?
        };
        let age = time.since(sample.time);
        let validity = if sample.frozen || age > self.lost_after {
            Validity::Lost
        } else if age > self.held_after {
            Validity::Held
        } else {
            Validity::Live
        };
        Some(Pose {
            frame_from_body: sample.table_from_sensor,
            time: sample.time,
            validity,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};
    use sandtable_pose::Rigid;

    fn hub() -> Hub {
        Hub::for_rig(&Rig::builtin("workbench").unwrap())
    }

    fn head() -> SensorName {
        SensorName {
            device: "flock".into(),
            number: 1,
        }
    }

    fn sample(ms: u64, x: f64) -> Sample {
        Sample {
            sensor: 1,
            time: Nanos(ms * 1_000_000),
            table_from_sensor: Rigid::new(DQuat::IDENTITY, DVec3::new(x, 0.0, 0.0)),
            frozen: false,
        }
    }

    fn validity(hub: &Hub, ms: u64) -> Option<Validity> {
        hub.pose_at(&head(), Nanos(ms * 1_000_000))
            .map(|pose| pose.validity)
    }

    #[test]
    fn a_pose_is_live_then_held_then_lost_and_keeps_its_place() {
        let hub = hub();
        assert_eq!(validity(&hub, 100), None);
        hub.push("flock", sample(100, 0.5));
        assert_eq!(validity(&hub, 99), None);
        assert_eq!(validity(&hub, 100), Some(Validity::Live));
        assert_eq!(validity(&hub, 130), Some(Validity::Live));
        assert_eq!(validity(&hub, 131), Some(Validity::Held));
        assert_eq!(validity(&hub, 350), Some(Validity::Held));
        assert_eq!(validity(&hub, 351), Some(Validity::Lost));
        let lost = hub.pose_at(&head(), Nanos(10_000_000_000)).unwrap();
        assert_eq!(lost.frame_from_body.translation.x, 0.5);
        assert_eq!(lost.time, Nanos(100_000_000));
    }

    #[test]
    fn an_earlier_time_gives_an_earlier_pose() {
        let hub = hub();
        for i in 0..2000 {
            hub.push("flock", sample(i * 10, i as f64));
        }
        let at = |ms: u64| hub.pose_at(&head(), Nanos(ms * 1_000_000));
        assert_eq!(at(19_995).unwrap().frame_from_body.translation.x, 1999.0);
        assert_eq!(at(19_989).unwrap().frame_from_body.translation.x, 1998.0);
        // What is older than the history is not guessed.
        assert_eq!(at(1000), None);
    }

    #[test]
    fn a_frozen_sensor_is_lost_however_young() {
        let hub = hub();
        hub.push(
            "flock",
            Sample {
                frozen: true,
                ..sample(100, 0.0)
            },
        );
        assert_eq!(validity(&hub, 100), Some(Validity::Lost));
    }

    #[test]
    fn sensors_that_the_rig_does_not_have_are_ignored() {
        let hub = hub();
        hub.push("glove", sample(0, 0.0));
        hub.push(
            "flock",
            Sample {
                sensor: 9,
                ..sample(0, 0.0)
            },
        );
        assert_eq!(validity(&hub, 0), None);
        assert_eq!(hub.sensors().count(), 2);
    }
}
