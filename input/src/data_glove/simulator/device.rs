//! The simulated glove: its sensors, and the reports that they make.

use super::SimulatorSettings;
use crate::data_glove::stream::JOINTS;
use crate::data_glove::{REPORT_LENGTH, VALUES, encode_report, products};
use crate::simulator::mixed;
use sandtable_config::{ByteOrder, DataGlove};
use std::time::Duration;

/// A Data Glove Ultra without a cable: gives one report after another.
#[derive(Clone, Debug)]
pub struct SimulatedDataGlove {
    settings: SimulatorSettings,
    /// Where in a report's values each sensor is.
    positions: Vec<usize>,
    byte_order: ByteOrder,
}

impl SimulatedDataGlove {
    /// The glove that `rig` describes, of 5 or 14 sensors, in its places and byte order.
    #[must_use]
    pub fn new(rig: &DataGlove, settings: SimulatorSettings) -> Self {
        Self {
            settings,
            positions: rig.positions.clone(),
            byte_order: rig.byte_order,
        }
    }

    /// Its USB product id, as one by wire.
    #[must_use]
    pub fn product(&self) -> u16 {
        let [by_wire, ..] = products(self.settings.side, self.positions.len());
        by_wire
    }

    /// The raw values of a sensor, from 0, on a straight and on a bent finger. As with real ones
    /// they are a part of what 12 bits can tell, and each sensor's own.
    #[must_use]
    pub fn range(sensor: usize) -> [u16; 2] {
        // Sixteen sensors stay within 900 to 3100.
        let sensor = sensor.min(VALUES) as u16;
        [900 + 37 * sensor, 2300 + 50 * sensor]
    }

    /// When the report with this number, from 0, is sent after the motion's begin.
    #[must_use]
    pub fn time(&self, number: u64) -> Duration {
        let rate = u64::from(self.settings.rate.max(1));
        let rest = Duration::from_nanos(number % rate * 1_000_000_000 / rate);
        Duration::from_secs(number / rate) + rest
    }

    /// The report with this number, from 0.
    #[must_use]
    pub fn report(&self, number: u64) -> [u8; REPORT_LENGTH] {
        let fingers = self.settings.motion.flexion(self.time(number));
        let mut values = [0; VALUES];
        for (sensor, &position) in self.positions.iter().enumerate() {
            let [straight, bent] = Self::range(sensor).map(f64::from);
            let flexion = self.flexion(sensor, &fingers);
            let raw = straight + flexion * (bent - straight) + self.noise(number, sensor);
            // Between 0 and 12 bits, whatever the noise is.
            let raw = raw.round().clamp(0.0, DataGlove::HIGHEST);
            if let Some(value) = values.get_mut(position) {
                *value = raw as u16;
            }
        }
        encode_report(&values, self.byte_order)
    }

    /// How far a sensor is bent. Both joints of a finger bend alike; between two fingers that are
    /// straight there is room.
    fn flexion(&self, sensor: usize, fingers: &[f64; 5]) -> f64 {
        if self.positions.len() == fingers.len() {
            return fingers[sensor];
        }
        let joint = JOINTS.iter().position(|joints| joints.contains(&sensor));
        match joint {
            Some(finger) => fingers[finger],
            None => {
                let right = JOINTS.iter().filter(|[near, _]| *near < sensor).count();
                let [left, right] = [right.saturating_sub(1), right.min(4)];
                1.0 - 0.5 * (fingers[left] + fingers[right])
            }
        }
    }

    /// A whole number from −`noise` to `noise`.
    fn noise(&self, number: u64, sensor: usize) -> f64 {
        let noise = u64::from(self.settings.noise);
        let place = number << 8 | sensor as u64;
        let random = mixed(self.settings.seed ^ mixed(place));
        (random % (2 * noise + 1)) as f64 - noise as f64
    }
}

#[cfg(test)]
mod tests {
    use super::super::Motion;
    use super::*;
    use crate::data_glove::{DataGloveStream, report_values};
    use crate::hand::{Posture, gesture_of};
    use crate::{HandState, Sample, Stream};
    use sandtable_config::{Device, Gesture, Gestures, Rig, Side};
    use sandtable_pose::Nanos;

    fn rig(settings: &str) -> DataGlove {
        let text = format!(
            "name = 'd'\n[camera]\n[devices.glove]\nkind = 'data-glove'\nhand = 'left'\n{settings}"
        );
        let mut rig = Rig::parse(&text, "d").unwrap();
        match rig.devices.remove("glove") {
            Some(Device::DataGlove(glove)) => glove,
            _ => panic!("it is a data glove"),
        }
    }

    fn calibrated(sensors: usize) -> DataGlove {
        let range = |sensor| SimulatedDataGlove::range(sensor).map(f64::from);
        DataGlove {
            ranges: (0..sensors).map(range).collect(),
            auto_calibration: false,
            ..rig(&format!("sensors = {sensors}"))
        }
    }

    fn settings(motion: Motion, noise: u16) -> SimulatorSettings {
        SimulatorSettings {
            motion,
            noise,
            ..SimulatorSettings::default()
        }
    }

    fn read(stream: &mut DataGloveStream, glove: &SimulatedDataGlove, number: u64) -> HandState {
        let mut hand = None;
        let arrival = Nanos(0) + glove.time(number);
        stream.push(&glove.report(number), arrival, &mut |sample| {
            if let Sample::Hand(sample) = sample {
                hand = Some(sample.hand);
            }
        });
        hand.unwrap()
    }

    #[test]
    fn what_it_holds_is_what_its_stream_reads() {
        let held = [0.05, 0.25, 0.5, 0.75, 1.0];
        for sensors in [5, 14] {
            let rig = calibrated(sensors);
            let glove = SimulatedDataGlove::new(&rig, settings(Motion::Hold(held), 3));
            let mut stream = DataGloveStream::new(&rig);
            for number in 0..200 {
                let hand = read(&mut stream, &glove, number);
                for (flexion, held) in hand.flexion.iter().zip(held) {
                    let flexion = flexion.unwrap();
                    // Three and a half raw values of 1400 at least.
                    for joint in [flexion.near, flexion.far] {
                        assert!((joint - held).abs() < 0.0026, "{joint} for {held}");
                    }
                }
            }
        }
    }

    #[test]
    fn each_named_motion_is_its_gesture() {
        for (name, gesture) in [
            ("open", Gesture::Open),
            ("fist", Gesture::Grab),
            ("point", Gesture::Point),
            ("pinch", Gesture::Pinch),
        ] {
            for sensors in [5, 14] {
                let rig = calibrated(sensors);
                let motion = Motion::named(name, 0).unwrap();
                let glove = SimulatedDataGlove::new(&rig, settings(motion, 2));
                let hand = read(&mut DataGloveStream::new(&rig), &glove, 0);
                let posture = Posture::of(&hand, &Gestures::default());
                assert_eq!(gesture_of(&posture, None), Some(gesture), "{name}");
            }
        }
    }

    #[test]
    fn a_stream_learns_its_ranges_while_it_plays() {
        for sensors in [5, 14] {
            let rig = rig(&format!("sensors = {sensors}"));
            let glove = SimulatedDataGlove::new(&rig, settings(Motion::Played(5), 0));
            let mut stream = DataGloveStream::new(&rig);
            assert_eq!(read(&mut stream, &glove, 0), HandState::default());
            for number in 1..150 {
                read(&mut stream, &glove, number);
            }
            let ranges: Vec<_> = (0..sensors)
                .map(|sensor| {
                    let [low, high] = SimulatedDataGlove::range(sensor);
                    format!("[{low}, {high}]")
                })
                .collect();
            let learnt = format!("ranges = [{}]", ranges.join(", "));
            assert_eq!(stream.calibration(), Some(learnt));
        }
    }

    #[test]
    fn noise_is_its_seeds_own_and_within_its_bounds() {
        let rig = calibrated(5);
        let reports = |noise, seed| -> Vec<[u8; REPORT_LENGTH]> {
            let settings = SimulatorSettings {
                seed,
                ..settings(Motion::Hold([0.5; 5]), noise)
            };
            let glove = SimulatedDataGlove::new(&rig, settings);
            (0..300).map(|number| glove.report(number)).collect()
        };
        assert_eq!(reports(4, 1), reports(4, 1));
        assert_ne!(reports(4, 1), reports(4, 2));
        assert!(reports(0, 1).windows(2).all(|pair| pair[0] == pair[1]));
        let seen: std::collections::BTreeSet<_> = reports(4, 1)
            .iter()
            .map(|report| report_values(report, ByteOrder::BigEndian, &[0]).unwrap()[0])
            .collect();
        // 900 to 2300 in the middle, and four to each side.
        assert_eq!(seen, (1596..=1604).collect());
        // Noise beyond what 12 bits can tell stays within them.
        for report in reports(u16::MAX, 1) {
            assert!(report_values(&report, ByteOrder::BigEndian, &rig.positions).is_some());
        }
    }

    #[test]
    fn it_is_the_glove_of_its_hand() {
        let glove = |side, sensors| {
            let settings = SimulatorSettings {
                side,
                ..SimulatorSettings::default()
            };
            SimulatedDataGlove::new(&calibrated(sensors), settings)
        };
        assert_eq!(glove(Side::Right, 14).product(), 0x0000);
        assert_eq!(glove(Side::Left, 5).product(), 0x0011);
        assert_eq!(glove(Side::Left, 5).time(150), Duration::from_secs(2));
    }
}
