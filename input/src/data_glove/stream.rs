//! The stream: from reports to how far fingers are bent.
//!
//! Live driver and replay run the same stream, so that a recording gives the same samples.

use super::report::report_values;
use crate::hand::SensorCalibration;
use crate::{Flexion, HandSample, HandState, Sample, Stream, StreamCounts};
use sandtable_config::{ByteOrder, DataGlove};
use sandtable_pose::Nanos;
use std::time::Duration;

/// Of 14 sensors, those at the knuckle and at the next joint of each finger. The others tell how
/// far fingers are spread.
pub(super) const JOINTS: [[usize; 2]; 5] = [[0, 1], [3, 4], [6, 7], [9, 10], [12, 13]];

/// Turns one glove's reports into samples of hand 1. No port, no clock: the reports bring their
/// times.
///
/// With five sensors both joints of a finger are told alike. A finger is unknown until all of its
/// sensors have a range.
#[derive(Clone, Debug)]
pub struct DataGloveStream {
    positions: Vec<usize>,
    byte_order: ByteOrder,
    sensors: Vec<SensorCalibration>,
    newest: Nanos,
    counts: StreamCounts,
}

impl DataGloveStream {
    /// The stream of a rig's data glove.
    #[must_use]
    pub fn new(glove: &DataGlove) -> Self {
        let least = glove.least_range * DataGlove::HIGHEST;
        let sensor = |number: usize| {
            let range = glove.ranges.get(number).copied();
            SensorCalibration::new(range, glove.auto_calibration, least)
        };
        Self {
            positions: glove.positions.clone(),
            byte_order: glove.byte_order,
            sensors: (0..glove.sensors()).map(sensor).collect(),
            newest: Nanos(0),
            counts: StreamCounts::default(),
        }
    }

    fn flexion(&mut self, values: &[u16]) -> [Option<Flexion>; 5] {
        // One for each of at most 14 sensors.
        let mut bent = [None; 16];
        let sensors = self.sensors.iter_mut().zip(&self.positions);
        for (bent, (sensor, position)) in bent.iter_mut().zip(sensors) {
            *bent = sensor.scaled(f64::from(values[*position]));
        }
        std::array::from_fn(|finger| {
            let [near, far] = if self.positions.len() == 5 {
                [finger; 2]
            } else {
                JOINTS[finger]
            };
            Some(Flexion {
                near: bent[near]?,
                far: bent[far]?,
            })
        })
    }
}

impl Stream for DataGloveStream {
    fn push(&mut self, bytes: &[u8], arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        if bytes.is_empty() {
            return;
        }
        let Some(values) = report_values(bytes, self.byte_order, &self.positions) else {
            self.counts.implausible += 1;
            self.counts.stray_bytes += bytes.len() as u64;
            return;
        };
        self.counts.records += 1;
        self.counts.samples += 1;
        self.newest = arrival.max(self.newest + Duration::from_nanos(1));
        out(Sample::Hand(HandSample {
            sensor: 1,
            time: self.newest,
            hand: HandState {
                flexion: self.flexion(&values),
                contacts: None,
            },
        }));
    }

    fn restart(&mut self) {}

    fn reset_calibration(&mut self) {
        self.sensors.iter_mut().for_each(SensorCalibration::reset);
    }

    fn calibration(&self) -> Option<String> {
        let ranges = SensorCalibration::in_the_rigs_words(&self.sensors)?;
        Some(format!("ranges = {ranges}"))
    }

    fn counts(&self) -> StreamCounts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data_glove::{VALUES, encode_report, gesture_code};
    use crate::hand::Posture;
    use sandtable_config::{Device, Gestures, Rig};

    fn stream(settings: &str) -> DataGloveStream {
        let text = format!(
            "name = 'd'\n[camera]\n[devices.glove]\nkind = 'data-glove'\nhand = 'right'\n{settings}"
        );
        let rig = Rig::parse(&text, "d").unwrap();
        let Device::DataGlove(glove) = &rig.devices["glove"] else {
            panic!("it is a data glove");
        };
        DataGloveStream::new(glove)
    }

    /// The hand that a report makes whose sensors have these values.
    fn hand(stream: &mut DataGloveStream, raw: &[u16]) -> HandState {
        let mut values = [0; VALUES];
        for (position, raw) in stream.positions.iter().zip(raw) {
            values[*position] = *raw;
        }
        let report = encode_report(&values, stream.byte_order);
        let mut hand = None;
        stream.push(&report, Nanos(1), &mut |sample| {
            if let Sample::Hand(sample) = sample {
                hand = Some(sample.hand);
            }
        });
        hand.unwrap()
    }

    #[test]
    fn the_worked_report_is_its_flexion_and_its_gesture() {
        let ranges = "[[400, 3600], [400, 3600], [400, 3600], [400, 3600], [400, 3600]]";
        let mut stream = stream(&format!("sensors = 5\nranges = {ranges}"));
        let hand = hand(&mut stream, &[3000, 500, 3300, 3400, 3500]);
        let expected = [0.8125, 0.03125, 0.90625, 0.9375, 0.96875];
        let expected = expected.map(|bent| Some(Flexion::of_one_sensor(bent)));
        assert_eq!(hand.flexion, expected);
        let posture = Posture::of(&hand, &Gestures::default());
        assert_eq!(gesture_code(&posture), Some(1));
    }

    #[test]
    fn fourteen_sensors_are_two_joints_a_finger() {
        let ranges = vec!["[0, 1000]"; 14].join(", ");
        let settings = format!("sensors = 14\nranges = [{ranges}]\nauto_calibration = false");
        let mut stream = stream(&settings);
        let raw: Vec<u16> = (0..14).map(|sensor| 50 * sensor).collect();
        let flexion = hand(&mut stream, &raw).flexion.map(Option::unwrap);
        let near = flexion.map(|finger| finger.near);
        let far = flexion.map(|finger| finger.far);
        assert_eq!(near, [0.0, 0.15, 0.3, 0.45, 0.6]);
        assert_eq!(far, [0.05, 0.2, 0.35, 0.5, 0.65]);
        assert!((flexion[1].mean() - 0.175).abs() < 1e-12);
    }

    #[test]
    fn a_hand_opened_and_closed_is_calibrated_and_can_be_anew() {
        let mut stream = stream("sensors = 5");
        assert_eq!(stream.calibration(), None);
        assert_eq!(hand(&mut stream, &[1000; 5]).flexion, [None; 5]);
        // 1 % of 4095 is 40.95.
        assert_eq!(hand(&mut stream, &[1040; 5]).flexion, [None; 5]);
        let flexion = hand(&mut stream, &[2000, 2000, 2000, 2000, 1041]).flexion;
        assert_eq!(flexion, [Some(Flexion::of_one_sensor(1.0)); 5]);
        let flexion = hand(&mut stream, &[1500; 5]).flexion;
        assert_eq!(flexion[0], Some(Flexion::of_one_sensor(0.5)));
        let ranges = "[[1000, 2000], [1000, 2000], [1000, 2000], [1000, 2000], [1000, 1500]]";
        assert_eq!(stream.calibration(), Some(format!("ranges = {ranges}")));
        stream.restart();
        assert!(hand(&mut stream, &[1500; 5]).flexion[0].is_some());
        stream.reset_calibration();
        assert_eq!(hand(&mut stream, &[1500; 5]).flexion, [None; 5]);
        // What it has learnt is what a rig may begin with.
        let mut saved = self::stream(&format!("sensors = 5\nranges = {ranges}"));
        let flexion = hand(&mut saved, &[1250; 5]).flexion;
        assert_eq!(flexion[0], Some(Flexion::of_one_sensor(0.25)));
        assert_eq!(flexion[4], Some(Flexion::of_one_sensor(0.5)));
    }

    #[test]
    fn what_is_no_report_changes_nothing_and_is_counted() {
        let mut stream = stream("sensors = 5");
        let mut none = |bytes: &[u8]| stream.push(bytes, Nanos(5), &mut |_| panic!("no sample"));
        none(&[]);
        none(&[0; 63]);
        none(&[0xFF; 64]);
        let counts = stream.counts();
        assert_eq!((counts.records, counts.implausible), (0, 2));
        assert_eq!((counts.samples, counts.stray_bytes), (0, 127));
    }
}
