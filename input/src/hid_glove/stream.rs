//! The stream: from reports, as the rig describes them, to fingers and buttons.
//!
//! Live driver and replay run the same stream, so that a recording gives the same samples.

use super::field::field_value;
use crate::hand::{BentFinger, SensorCalibration};
use crate::{ButtonsSample, HandSample, HandState, Sample, Stream, StreamCounts};
use sandtable_config::{HidBit, HidField, HidGlove};
use sandtable_pose::Nanos;
use std::time::Duration;

/// Turns one glove's reports into samples of its hand and buttons. No port, no clock: the reports
/// bring their times.
#[derive(Clone, Debug)]
pub struct HidGloveStream {
    report_id: Option<u8>,
    report_length: Option<usize>,
    shortest_report: usize,
    fingers: [Option<(HidField, BentFinger)>; 5],
    buttons: Vec<HidBit>,
    newest: Nanos,
    counts: StreamCounts,
}

impl HidGloveStream {
    /// The stream of a rig's HID glove.
    #[must_use]
    pub fn new(glove: &HidGlove) -> Self {
        let fingers = glove.fingers.map(|finger| {
            let finger = finger?;
            let [lowest, highest] = finger.field.limits();
            let least = glove.least_range * (highest - lowest);
            let grows = glove.auto_calibration;
            let calibration = SensorCalibration::new(finger.range, grows, least);
            Some((finger.field, BentFinger::new(finger.inverted, calibration)))
        });
        Self {
            report_id: glove.report_id,
            report_length: glove.report_length,
            shortest_report: glove.shortest_report(),
            fingers,
            buttons: glove.buttons.clone(),
            newest: Nanos(0),
            counts: StreamCounts::default(),
        }
    }

    fn is_ours(&self, report: &[u8]) -> bool {
        self.report_id.is_none_or(|id| report.first() == Some(&id))
    }

    fn is_whole(&self, report: &[u8]) -> bool {
        report.len() >= self.shortest_report
            && self
                .report_length
                .is_none_or(|length| report.len() == length)
    }

    fn pressed(&self, report: &[u8]) -> u64 {
        let down = |button: &HidBit| {
            let byte = report.get(button.byte).copied().unwrap_or(0);
            u64::from(byte >> button.bit & 1)
        };
        let buttons = self.buttons.iter().enumerate();
        buttons.fold(0, |pressed, (number, button)| {
            pressed | down(button) << number
        })
    }
}

impl Stream for HidGloveStream {
    fn push(&mut self, bytes: &[u8], arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        if bytes.is_empty() {
            return;
        }
        // A glove may well send reports of other kinds.
        if !self.is_ours(bytes) {
            self.counts.foreign_records += 1;
            return;
        }
        if !self.is_whole(bytes) {
            self.counts.implausible += 1;
            self.counts.stray_bytes += bytes.len() as u64;
            return;
        }
        self.counts.records += 1;
        let time = arrival.max(self.newest + Duration::from_nanos(1));
        self.newest = time;
        let flexion = self.fingers.each_mut().map(|finger| {
            let (field, finger) = finger.as_mut()?;
            finger.flexion(field_value(field, bytes)? as f64)
        });
        self.counts.samples += 1;
        let contacts = None;
        out(Sample::Hand(HandSample {
            sensor: 1,
            time,
            hand: HandState { flexion, contacts },
        }));
        if !self.buttons.is_empty() {
            self.counts.samples += 1;
            out(Sample::Buttons(ButtonsSample {
                sensor: 1,
                time,
                pressed: self.pressed(bytes),
            }));
        }
    }

    fn restart(&mut self) {}

    fn reset_calibration(&mut self) {
        for (_, finger) in self.fingers.iter_mut().flatten() {
            finger.reset();
        }
    }

    fn calibration(&self) -> Option<String> {
        let fingers = self.fingers.each_ref();
        BentFinger::ranges(fingers.map(|finger| finger.as_ref().map(|(_, finger)| finger)))
    }

    fn counts(&self) -> StreamCounts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use sandtable_config::{Device, Rig};

    const GLOVE: &str = "name = 'h'\n[camera]\n[devices.glove]\nkind = 'hid-glove'\nhand = 'left'\n\
                         vendor = 1\nproduct = 2\nreport_id = 7\n\
                         buttons = [{ byte = 5, bit = 1 }, { byte = 5 }]\n\
                         [devices.glove.fingers]\n\
                         thumb = { byte = 1, range = [0, 200] }\n\
                         index = { byte = 2, bits = 16, byte_order = 'big', inverted = true }\n\
                         little = { byte = 4, signed = true, range = [-100, 100] }\n";

    fn stream(text: &str) -> HidGloveStream {
        let rig = Rig::parse(text, "h").unwrap();
        let Device::HidGlove(glove) = &rig.devices["glove"] else {
            panic!("it is a HID glove");
        };
        HidGloveStream::new(glove)
    }

    fn samples(stream: &mut HidGloveStream, report: &[u8]) -> Vec<Sample> {
        let mut samples = Vec::new();
        stream.push(report, Nanos(9), &mut |sample| samples.push(sample));
        samples
    }

    fn bent(samples: &[Sample]) -> [Option<f64>; 5] {
        let Sample::Hand(sample) = samples[0] else {
            panic!("a hand comes first");
        };
        sample.hand.flexion.map(|flexion| Some(flexion?.mean()))
    }

    #[test]
    fn fingers_and_buttons_are_where_the_rig_says() {
        let mut stream = stream(GLOVE);
        let first = samples(&mut stream, &[7, 50, 0x10, 0x00, 0, 0b10]);
        // The index finger has no range yet, and two fingers are not there.
        assert_eq!(bent(&first), [Some(0.25), None, None, None, Some(0.5)]);
        let Sample::Buttons(buttons) = first[1] else {
            panic!("buttons come next");
        };
        assert_eq!((buttons.pressed, buttons.sensor), (0b01, 1));
        let second = samples(&mut stream, &[7, 200, 0x20, 0x00, 0x9C, 0b01]);
        assert_eq!(bent(&second), [Some(1.0), Some(0.0), None, None, Some(0.0)]);
        assert!(matches!(second[1], Sample::Buttons(b) if b.pressed == 0b10));
        assert!(second[0].time() > first[0].time());
        let third = samples(&mut stream, &[7, 0, 0x14, 0x00, 0, 0]);
        assert_eq!(bent(&third)[1], Some(0.75));
        let learnt =
            "thumb range = [0, 200], index range = [4096, 8192], little range = [-100, 100]";
        assert_eq!(stream.calibration().as_deref(), Some(learnt));
        stream.reset_calibration();
        assert_eq!(bent(&samples(&mut stream, &[7, 1, 2, 3, 4, 5])), [None; 5]);
    }

    #[test]
    fn other_reports_are_let_pass_and_short_ones_refused() {
        let mut stream = stream(GLOVE);
        assert!(samples(&mut stream, &[8, 1, 2, 3, 4, 5]).is_empty());
        assert!(samples(&mut stream, &[7, 1, 2, 3, 4]).is_empty());
        assert!(samples(&mut stream, &[]).is_empty());
        let counts = stream.counts();
        assert_eq!((counts.foreign_records, counts.implausible), (1, 1));
        assert_eq!(samples(&mut stream, &[7; 9]).len(), 2);
        let exact = GLOVE.replace("report_id = 7", "report_id = 7\nreport_length = 6");
        let mut stream = self::stream(&exact);
        assert!(samples(&mut stream, &[7; 9]).is_empty());
        assert_eq!(samples(&mut stream, &[7; 6]).len(), 2);
    }

    #[test]
    fn a_glove_without_report_id_and_buttons_tells_its_hand() {
        let text = GLOVE.replace("report_id = 7\n", "");
        let from = text.find("buttons").unwrap();
        let to = text.find("[devices.glove.fingers]").unwrap();
        let mut stream = stream(&format!("{}{}", &text[..from], &text[to..]));
        assert_eq!(samples(&mut stream, &[0, 100, 0, 0, 0]).len(), 1);
    }

    proptest! {
        #[test]
        fn any_report_gives_flexions_from_0_to_1(
            reports in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..12), 0..50),
        ) {
            let mut stream = stream(GLOVE);
            for mut report in reports {
                if let Some(id) = report.first_mut() {
                    *id = 7 + (*id & 1);
                }
                for sample in samples(&mut stream, &report) {
                    if let Sample::Hand(sample) = sample {
                        for flexion in sample.hand.flexion.into_iter().flatten() {
                            prop_assert!((0.0..=1.0).contains(&flexion.near));
                        }
                    }
                }
            }
        }
    }
}
