//! The hub: the newest samples of every sensor, and how far to trust its poses.
//!
//! Device threads write samples, everyone else asks for what was true at a time of their own. A
//! sensor's histories are short and a lock is held for a search in one at most, so that no writer
//! waits long for a reader, and none for another sensor's.

use crate::flock::record_period;
use crate::{AXES, AxesSample, ButtonsSample, HandSample, HandState, PoseSample, Sample};
use crossbeam_channel::{Receiver, Sender, TrySendError};
use sandtable_config::{Device, Dtrack, Rig, SensorName, SensorSettings, Vrpn};
use sandtable_motion::{Estimate, FilterSettings, TrackerFilter};
use sandtable_pose::{Nanos, Pose, Validity};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Samples by sensor and time. The sensors are those of the rig that it was made for.
#[derive(Debug, Default)]
pub struct Hub {
    /// Each device's sensors, number 1 first.
    devices: BTreeMap<Arc<str>, Vec<Sensor>>,
    listeners: Mutex<Vec<Sender<Heard>>>,
}

/// A sample that a listener hears of, and the name of its device.
pub(crate) type Heard = (Arc<str>, Sample);

#[derive(Debug)]
struct Sensor {
    held_after: Duration,
    lost_after: Duration,
    /// From when a pose is asked for to the middle of its picture's time on the glass.
    ahead: Duration,
    filter: Mutex<TrackerFilter>,
    poses: History<ReadPose, 512>,
    buttons: History<ButtonsSample, 512>,
    axes: History<AxesSample, 128>,
    hands: History<(Nanos, HandState), 512>,
}

/// A pose, and when the read arrived that it came with.
#[derive(Clone, Copy, Debug)]
struct ReadPose {
    sample: PoseSample,
    arrival: Nanos,
}

/// The newest samples of one kind, at most `N`: of poses, five seconds of a Flock's usual cycle, of
/// hands, as many of a glove's.
#[derive(Debug)]
struct History<S, const N: usize>(Mutex<VecDeque<S>>);

impl Hub {
    /// A hub for all sensors of a rig, of which nothing is known yet.
    #[must_use]
    pub fn for_rig(rig: &Rig) -> Self {
        let sensors = |(name, device): (&String, &Device)| {
            let (held_after, lost_after, period) = match device {
                Device::Flock(flock) => (flock.held_after, flock.lost_after, record_period(flock)),
                Device::Vrpn(Vrpn { tracking, .. }) | Device::Dtrack(Dtrack { tracking, .. }) => {
                    (tracking.held_after, tracking.lost_after, tracking.period())
                }
                // They tell no poses.
                Device::Pinch(_) | Device::DataGlove(_) | Device::HidGlove(_) => Default::default(),
            };
            // A slow line brings records less often than a pose may be old.
            let held_after = held_after.max(3 * period);
            let lost_after = lost_after.max(held_after);
            let sensor = |number| {
                let sensor = SensorName {
                    device: name.clone(),
                    number,
                };
                let settings = rig.sensors.get(&sensor).copied().unwrap_or_default();
                Sensor::new(settings, held_after, lost_after)
            };
            let sensors = (1..=device.sensors()).map(sensor).collect();
            (name.as_str().into(), sensors)
        };
        Self {
            devices: rig.devices.iter().map(sensors).collect(),
            listeners: Mutex::default(),
        }
    }

    /// Adds a sample of a device's sensor; one of an unknown sensor is ignored. It counts as
    /// arrived when it was measured.
    pub fn push(&self, device: &str, sample: Sample) {
        self.push_read(device, sample, sample.time());
    }

    /// Adds a sample as [`Hub::push`] does, of a read that ended at `arrival`.
    pub fn push_read(&self, device: &str, sample: Sample, arrival: Nanos) {
        let Some((name, sensor)) = self.sensor(device, sample.sensor()) else {
            return;
        };
        let mut listeners = self.listeners();
        if !listeners.is_empty() {
            // A listener that is too slow misses samples; nobody waits for it.
            listeners.retain(|listener| {
                let result = listener.try_send((Arc::clone(name), sample));
                !matches!(result, Err(TrySendError::Disconnected(_)))
            });
        }
        drop(listeners);
        match sample {
            Sample::Pose(sample) => {
                sensor.poses.push(ReadPose { sample, arrival });
                sensor
                    .lock_filter()
                    .push(&sensor.pose(&sample, sample.time));
            }
            Sample::Buttons(sample) => sensor.buttons.push(sample),
            Sample::Axes(sample) => sensor.axes.push(sample),
            Sample::Hand(sample) => sensor.hands.push((sample.time, sample.hand)),
        }
    }

    /// Every sample pushed from now on, in order. Up to `room` of them wait for their reader; what
    /// comes while there is no room is missed.
    pub(crate) fn listen(&self, room: usize) -> Receiver<Heard> {
        let (listener, heard) = crossbeam_channel::bounded(room);
        self.listeners().push(listener);
        heard
    }

    /// Lets go what a device holds that has gone away at `time`: its buttons, its axes, and what is
    /// known of its hands. A button must not stay pressed because its cable was pulled.
    pub(crate) fn let_go(&self, device: &str, time: Nanos) {
        let count = self.devices.get(device).map_or(0, Vec::len);
        for sensor in 1..=u32::try_from(count).unwrap_or(u32::MAX) {
            let name = SensorName {
                device: device.to_owned(),
                number: sensor,
            };
            // The newest, whatever its time.
            let end = Nanos(u64::MAX);
            if self
                .buttons_at(&name, end)
                .is_some_and(|pressed| pressed != 0)
            {
                let pressed = 0;
                let released = ButtonsSample {
                    sensor,
                    time,
                    pressed,
                };
                self.push(device, Sample::Buttons(released));
            }
            if let Some(axes) = self.axes_at(&name, end)
                && axes.values.iter().any(|value| *value != 0.0)
            {
                let values = [0.0; AXES];
                self.push(
                    device,
                    Sample::Axes(AxesSample {
                        time,
                        values,
                        ..axes
                    }),
                );
            }
            if self.hand_at(&name, end).is_some() {
                let hand = HandState::default();
                self.push(device, Sample::Hand(HandSample { sensor, time, hand }));
            }
        }
    }

    /// The newest pose measured at or before `time`, in the table's frame, or `None` where the
    /// sensor has had none or is unknown.
    ///
    /// It is live while young, held for a while, then lost; it is never replaced by a default.
    #[must_use]
    pub fn pose_at(&self, sensor: &SensorName, time: Nanos) -> Option<Pose> {
        let sensor = self.named(sensor)?;
        let read = sensor.poses.at(time, |read| read.sample.time)?;
        Some(sensor.pose(&read.sample, time))
    }

    /// When the read ended that brought the sensor's pose of exactly this `time`; `None` where no
    /// such pose is known, or no more.
    #[must_use]
    pub fn arrival_of(&self, sensor: &SensorName, time: Nanos) -> Option<Nanos> {
        let sensor = self.named(sensor)?;
        let read = sensor.poses.at(time, |read| read.sample.time)?;
        (read.sample.time == time).then_some(read.arrival)
    }

    /// All poses measured after `from` that are still known, the oldest first.
    #[must_use]
    pub fn poses_since(&self, sensor: &SensorName, from: Nanos) -> Vec<PoseSample> {
        let Some(sensor) = self.named(sensor) else {
            return Vec::new();
        };
        let reads = sensor.poses.since(from, |read| read.sample.time);
        reads.into_iter().map(|read| read.sample).collect()
    }

    /// When each sample of a hand came after `from`, of those that are still known, the oldest
    /// first.
    #[must_use]
    pub fn hands_since(&self, sensor: &SensorName, from: Nanos) -> Vec<Nanos> {
        let Some(sensor) = self.named(sensor) else {
            return Vec::new();
        };
        let samples = sensor.hands.since(from, |(time, _)| *time);
        samples.into_iter().map(|(time, _)| time).collect()
    }

    /// When each sample of buttons came after `from`, of those that are still known, the oldest
    /// first.
    #[must_use]
    pub fn buttons_since(&self, sensor: &SensorName, from: Nanos) -> Vec<Nanos> {
        let Some(sensor) = self.named(sensor) else {
            return Vec::new();
        };
        let samples = sensor.buttons.since(from, |sample| sample.time);
        samples.into_iter().map(|sample| sample.time).collect()
    }

    /// Where the sensor will be when a picture that is begun at `now` is on the glass, smoothed and
    /// predicted as the rig says, with its velocity and age; `None` where it has had no pose or is
    /// unknown. Of all samples so far, the newest counts.
    #[must_use]
    pub fn estimate_at(&self, sensor: &SensorName, now: Nanos) -> Option<Estimate> {
        let sensor = self.named(sensor)?;
        sensor.lock_filter().pose_at(now, now + sensor.ahead)
    }

    /// The buttons pressed at `time`, bit n for button n; `None` where nothing is known of them.
    #[must_use]
    pub fn buttons_at(&self, sensor: &SensorName, time: Nanos) -> Option<u64> {
        let sample = self.named(sensor)?.buttons.at(time, |sample| sample.time)?;
        Some(sample.pressed)
    }

    /// The buttons that were down at any time after `from` and up to `to`, so that none is missed
    /// that is pressed for a moment; `None` where nothing is known of them.
    #[must_use]
    pub fn buttons_between(&self, sensor: &SensorName, from: Nanos, to: Nanos) -> Option<u64> {
        let history = self.named(sensor)?.buttons.lock();
        let up_to = history.partition_point(|sample| sample.time <= to);
        let newest = up_to.checked_sub(1)?;
        let after = history.partition_point(|sample| sample.time <= from);
        // The one before them holds on until the first.
        let first = after.saturating_sub(1).min(newest);
        let pressed = history.range(first..up_to).map(|sample| sample.pressed);
        Some(pressed.fold(0, |all, pressed| all | pressed))
    }

    /// The axes as they were at `time`; `None` where nothing is known of them.
    #[must_use]
    pub fn axes_at(&self, sensor: &SensorName, time: Nanos) -> Option<AxesSample> {
        self.named(sensor)?.axes.at(time, |sample| sample.time)
    }

    /// The fingers as they were at `time`; `None` where nothing is known of them, and from when on
    /// they were let go.
    #[must_use]
    pub fn hand_at(&self, sensor: &SensorName, time: Nanos) -> Option<HandState> {
        let (_, hand) = self.named(sensor)?.hands.at(time, |(time, _)| *time)?;
        (hand != HandState::default()).then_some(hand)
    }

    /// The sensors, in order.
    pub fn sensors(&self) -> impl Iterator<Item = SensorName> {
        self.devices.iter().flat_map(|(device, sensors)| {
            (1..).zip(sensors).map(|(number, _)| SensorName {
                device: device.to_string(),
                number,
            })
        })
    }

    /// Forgets every sample, as before a recording is played anew.
    pub fn clear(&self) {
        for sensor in self.devices.values().flatten() {
            sensor.poses.lock().clear();
            sensor.lock_filter().clear();
            sensor.buttons.lock().clear();
            sensor.axes.lock().clear();
            sensor.hands.lock().clear();
        }
    }

    fn named(&self, name: &SensorName) -> Option<&Sensor> {
        let (_, sensor) = self.sensor(&name.device, name.number)?;
        Some(sensor)
    }

    fn sensor(&self, device: &str, number: u32) -> Option<(&Arc<str>, &Sensor)> {
        let index = number.checked_sub(1)? as usize;
        let (name, sensors) = self.devices.get_key_value(device)?;
        Some((name, sensors.get(index)?))
    }

    fn listeners(&self) -> MutexGuard<'_, Vec<Sender<Heard>>> {
        // Nothing that can panic runs under the lock.
        self.listeners
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl Sensor {
    fn new(settings: SensorSettings, held_after: Duration, lost_after: Duration) -> Self {
        let SensorSettings { filter, ahead } = settings;
        let filter = FilterSettings {
            held_after,
            lost_after,
            // Between samples of a slow line there is no gap.
            gap: filter.gap.max(held_after),
            ..filter
        };
        Self {
            held_after,
            lost_after,
            ahead,
            filter: Mutex::new(TrackerFilter::new(filter).expect("a rig's settings were checked")),
            poses: History::default(),
            buttons: History::default(),
            axes: History::default(),
            hands: History::default(),
        }
    }

    fn lock_filter(&self) -> MutexGuard<'_, TrackerFilter> {
        self.filter.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn pose(&self, sample: &PoseSample, time: Nanos) -> Pose {
        let age = time.since(sample.time);
        let validity = if sample.frozen || age > self.lost_after {
            Validity::Lost
        } else if age > self.held_after {
            Validity::Held
        } else {
            Validity::Live
        };
        Pose {
            frame_from_body: sample.table_from_sensor,
            time: sample.time,
            validity,
        }
    }
}

impl<S, const N: usize> Default for History<S, N> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<S: Copy, const N: usize> History<S, N> {
    fn lock(&self) -> MutexGuard<'_, VecDeque<S>> {
        // No code that can panic runs under the lock; a poisoned history is whole.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, sample: S) {
        let mut history = self.lock();
        if history.len() == N {
            history.pop_front();
        }
        history.push_back(sample);
    }

    /// All samples of after `from`, the oldest first.
    fn since(&self, from: Nanos, time_of: impl Fn(&S) -> Nanos) -> Vec<S> {
        let history = self.lock();
        let later = history.partition_point(|sample| time_of(sample) <= from);
        history.iter().skip(later).copied().collect()
    }

    /// The newest sample of at or before `time`.
    fn at(&self, time: Nanos, time_of: impl Fn(&S) -> Nanos) -> Option<S> {
        let history = self.lock();
        let later = history.partition_point(|sample| time_of(sample) <= time);
        history.get(later.checked_sub(1)?).copied()
    }
}

#[cfg(test)]
mod tests;
