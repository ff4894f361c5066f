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
    buttons: History<ButtonsSample, 128>,
    axes: History<AxesSample, 128>,
    hands: History<(Nanos, HandState), 128>,
}

/// A pose, and when the read arrived that it came with.
#[derive(Clone, Copy, Debug)]
struct ReadPose {
    sample: PoseSample,
    arrival: Nanos,
}

/// The newest samples of one kind, at most `N`: of poses, five seconds of a Flock's usual cycle.
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
        let history = sensor.poses.lock();
        let later = history.partition_point(|read| read.sample.time <= from);
        history.range(later..).map(|read| read.sample).collect()
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

    /// The newest sample of at or before `time`.
    fn at(&self, time: Nanos, time_of: impl Fn(&S) -> Nanos) -> Option<S> {
        let history = self.lock();
        let later = history.partition_point(|sample| time_of(sample) <= time);
        history.get(later.checked_sub(1)?).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Flexion;
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

    fn sample(ms: u64, x: f64) -> PoseSample {
        PoseSample {
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
        hub.push("flock", Sample::Pose(sample(100, 0.5)));
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
            hub.push("flock", Sample::Pose(sample(i * 10, i as f64)));
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
            Sample::Pose(PoseSample {
                frozen: true,
                ..sample(100, 0.0)
            }),
        );
        assert_eq!(validity(&hub, 100), Some(Validity::Lost));
    }

    #[test]
    fn sensors_that_the_rig_does_not_have_are_ignored() {
        let hub = hub();
        hub.push("glove", Sample::Pose(sample(0, 0.0)));
        hub.push(
            "flock",
            Sample::Pose(PoseSample {
                sensor: 9,
                ..sample(0, 0.0)
            }),
        );
        assert_eq!(validity(&hub, 0), None);
        assert_eq!(hub.sensors().count(), 2);
    }

    #[test]
    fn a_sensors_settings_smooth_and_predict_it() {
        let text = Rig::builtin_text("workbench").unwrap().to_owned()
            + "\n[sensors.\"flock/1\"]\nprediction = { kind = \"constant-velocity\" }\n\
               ahead_ms = 20.0\n";
        let predicting = Hub::for_rig(&Rig::parse(&text, "test").unwrap());
        let plain = hub();
        for hub in [&predicting, &plain] {
            for i in 0..20 {
                hub.push("flock", Sample::Pose(sample(10 * i, 0.004 * i as f64)));
            }
        }
        let now = Nanos(190_000_000);
        let x = |hub: &Hub| {
            let estimate = hub.estimate_at(&head(), now).unwrap();
            assert!((estimate.velocity.unwrap().linear.x - 0.4).abs() < 1e-9);
            estimate.pose.frame_from_body.translation.x
        };
        assert_eq!(x(&plain), 0.004 * 19.0);
        assert!((x(&predicting) - 0.004 * 21.0).abs() < 1e-9);
        // A frozen sensor's pose is lost, and stays where it is.
        predicting.push(
            "flock",
            Sample::Pose(PoseSample {
                frozen: true,
                ..sample(200, 0.076)
            }),
        );
        let frozen = predicting.estimate_at(&head(), Nanos(200_000_000)).unwrap();
        assert_eq!(frozen.pose.validity, Validity::Lost);
        assert_eq!(frozen.pose.frame_from_body.translation.x, 0.076);
        predicting.clear();
        assert_eq!(predicting.estimate_at(&head(), now), None);
    }

    #[test]
    fn buttons_and_hands_are_as_they_were_at_a_time() {
        let hub = hub();
        let time = |ms: u64| Nanos(ms * 1_000_000);
        let pressed = |ms: u64, pressed: u64| {
            hub.push(
                "flock",
                Sample::Buttons(ButtonsSample {
                    sensor: 1,
                    time: time(ms),
                    pressed,
                }),
            );
        };
        assert_eq!(hub.buttons_at(&head(), time(5)), None);
        pressed(10, 0b1);
        pressed(20, 0b110);
        let at = |ms: u64| hub.buttons_at(&head(), time(ms));
        assert_eq!(
            [at(9), at(10), at(19), at(1000)],
            [None, Some(1), Some(1), Some(6)]
        );
        pressed(25, 0);
        let between = |from: u64, to: u64| hub.buttons_between(&head(), time(from), time(to));
        assert_eq!([between(0, 5), between(0, 10)], [None, Some(1)]);
        assert_eq!([between(12, 15), between(12, 40)], [Some(1), Some(7)]);
        assert_eq!([between(22, 40), between(25, 40)], [Some(6), Some(0)]);
        pressed(30, 0b110);
        let hand = HandState {
            flexion: [0.0, 0.25, 0.5, 0.75, 1.0].map(|bent| Some(Flexion::of_one_sensor(bent))),
            contacts: None,
        };
        hub.push(
            "flock",
            Sample::Hand(crate::HandSample {
                sensor: 1,
                time: time(10),
                hand,
            }),
        );
        assert_eq!(hub.hand_at(&head(), time(9)), None);
        assert_eq!(hub.hand_at(&head(), time(10)), Some(hand));
        hub.clear();
        assert_eq!((at(1000), hub.hand_at(&head(), time(10))), (None, None));
    }

    #[test]
    fn what_a_lost_device_holds_is_let_go_and_its_poses_stay() {
        let hub = hub();
        let time = |ms: u64| Nanos(ms * 1_000_000);
        let mut values = [0.0; AXES];
        values[1] = -1.0;
        hub.push("flock", Sample::Pose(sample(10, 0.5)));
        for sensor in 1..=2 {
            hub.push(
                "flock",
                Sample::Buttons(ButtonsSample {
                    sensor,
                    time: time(10),
                    pressed: 0b11,
                }),
            );
        }
        hub.push(
            "flock",
            Sample::Axes(AxesSample {
                sensor: 1,
                time: time(10),
                values,
                count: 2,
            }),
        );
        hub.let_go("glove", time(20));
        assert_eq!(hub.buttons_at(&head(), time(30)), Some(0b11));
        hub.let_go("flock", time(20));
        assert_eq!(hub.buttons_at(&head(), time(19)), Some(0b11));
        assert_eq!(hub.buttons_at(&head(), time(20)), Some(0));
        let axes = hub.axes_at(&head(), time(20)).unwrap();
        assert_eq!((axes.values, axes.count), ([0.0; AXES], 2));
        assert_eq!(validity(&hub, 10), Some(Validity::Live));
        // What is let go already is not let go again.
        let heard = hub.listen(8);
        hub.let_go("flock", time(30));
        assert_eq!(heard.len(), 0);
    }

    #[test]
    fn listeners_hear_all_that_they_have_room_for_and_hold_nobody_up() {
        let hub = hub();
        hub.push("flock", Sample::Pose(sample(0, 0.0)));
        let heard = hub.listen(3);
        for ms in 1..=5 {
            hub.push("flock", Sample::Pose(sample(ms, ms as f64)));
        }
        hub.push("glove", Sample::Pose(sample(6, 6.0)));
        let times: Vec<_> = heard
            .try_iter()
            .map(|(_, s)| s.time().0 / 1_000_000)
            .collect();
        assert_eq!(times, [1, 2, 3]);
        drop(heard);
        hub.push("flock", Sample::Pose(sample(7, 7.0)));
        assert_eq!(hub.listeners().len(), 0);
    }
}
