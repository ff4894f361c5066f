//! The stream: from chunks of bytes with their arrival times to samples in metres.
//!
//! Live driver and replay run the same stream, so that a recording gives the same samples.

use super::decoder::Decoder;
use super::measurement::Scale;
use super::record::{Layout, PHASE, Record, Words, buttons_pressed};
use crate::gate::GateLimits;
use crate::track::Track;
use crate::{ButtonsSample, PoseSample, Sample, Stream, StreamCounts};
use sandtable_config::{Confirm, FieldCorrection, Flock};
use sandtable_pose::{Nanos, Rigid};
use std::time::Duration;

/// Equal records in a row after which a sensor is frozen: a magnetic tracker's last bit never
/// rests for a second.
pub const FROZEN_AFTER: u32 = 100;

/// Turns one device's bytes into samples. No port, no clock: the chunks bring their times.
#[derive(Clone, Debug)]
pub struct FlockStream {
    decoder: Decoder,
    record_length: usize,
    confirm: Confirm,
    /// A record that waits for the next one's mark, and when it began.
    unconfirmed: Option<(Record, Nanos)>,
    scale: Scale,
    limits: GateLimits,
    table_from_tracker: Rigid,
    correction: Option<FieldCorrection>,
    byte_time: Duration,
    birds: Vec<Bird>,
    counts: StreamCounts,
}

/// What is remembered of one bird.
#[derive(Clone, Debug, Default)]
struct Bird {
    track: Track<Words>,
    buttons: Option<u64>,
}

impl FlockStream {
    /// The stream of a rig's Flock.
    #[must_use]
    pub fn new(flock: &Flock) -> Self {
        let layout = layout(flock);
        Self {
            record_length: layout.record_length(),
            confirm: flock.confirm,
            unconfirmed: None,
            scale: Scale::of(flock),
            limits: GateLimits {
                max_speed: flock.max_speed,
                max_turn: flock.max_turn.to_radians(),
                period: record_period(flock),
                memory: flock.lost_after,
            },
            table_from_tracker: flock.table_from_tracker,
            correction: flock.correction.clone(),
            byte_time: byte_time(flock.baud),
            birds: vec![Bird::default(); layout.birds()],
            decoder: Decoder::new(layout),
            counts: StreamCounts::default(),
        }
    }

    /// The first bird of which no record has come since the stream was made or restarted.
    #[must_use]
    pub fn missing_bird(&self) -> Option<u32> {
        let missing = |(number, bird): (u32, &Bird)| (!bird.track.is_heard()).then_some(number);
        (1..).zip(&self.birds).find_map(missing)
    }

    /// Hands out what a record says: its buttons too, where they have changed, but nothing of one
    /// whose pose is not believed.
    fn record(&mut self, record: &Record, began: Nanos, out: &mut dyn FnMut(Sample)) {
        let Some(pose) = self.pose(record.bird, &record.words, began) else {
            return;
        };
        self.counts.samples += 1;
        out(Sample::Pose(pose));
        let pressed = record.buttons.map(buttons_pressed);
        let bird = &mut self.birds[pose.sensor as usize - 1];
        if let Some(pressed) = pressed
            && bird.buttons.replace(pressed) != Some(pressed)
        {
            self.counts.samples += 1;
            out(Sample::Buttons(ButtonsSample {
                sensor: pose.sensor,
                time: pose.time,
                pressed,
            }));
        }
    }

    fn pose(&mut self, number: u32, words: &Words, began: Nanos) -> Option<PoseSample> {
        let bird = self.birds.get_mut(number.checked_sub(1)? as usize)?;
        bird.track.hear(*words);
        let Some(pose) = self.scale.pose(words) else {
            self.counts.implausible += 1;
            return None;
        };
        // Judged as the line says it: a correction must not decide which records are believed.
        let time = match bird.track.admit(&self.limits, began, &pose) {
            Ok(time) => time,
            Err(refusal) => {
                self.counts.refuse(refusal);
                return None;
            }
        };
        let bent = self.table_from_tracker * pose;
        Some(PoseSample {
            sensor: number,
            time,
            table_from_sensor: match &self.correction {
                Some(correction) => correction.apply(&bent),
                None => bent,
            },
            frozen: bird.track.equal() >= FROZEN_AFTER,
        })
    }
}

impl Stream for FlockStream {
    fn push(&mut self, bytes: &[u8], arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        for (index, &byte) in bytes.iter().enumerate() {
            if let Some((record, began)) = self.unconfirmed.take() {
                if byte & PHASE != 0 {
                    self.record(&record, began, out);
                } else {
                    // A byte too many: one of this record's was sent twice, nobody knows which.
                    self.counts.overlong_records += 1;
                }
            }
            let Some(record) = self.decoder.push(byte) else {
                continue;
            };
            // The line's own speed tells when the record began, however late the bytes were read.
            let since = bytes.len() - 1 - index + self.record_length;
            let began = arrival - self.byte_time * u32::try_from(since).unwrap_or(u32::MAX);
            match self.confirm {
                Confirm::Immediate => self.record(&record, began, out),
                Confirm::NextMark => self.unconfirmed = Some((record, began)),
            }
        }
    }

    fn restart(&mut self) {
        self.decoder.restart();
        self.unconfirmed = None;
        for bird in &mut self.birds {
            bird.track.restart();
            bird.buttons = None;
        }
    }

    fn counts(&self) -> StreamCounts {
        let decoder = self.decoder.counts();
        StreamCounts {
            records: decoder.records,
            stray_bytes: decoder.stray_bytes,
            cut_records: decoder.cut_records,
            foreign_records: decoder.foreign_records,
            ..self.counts
        }
    }
}

/// What a rig's Flock sends.
#[must_use]
pub fn layout(flock: &Flock) -> Layout {
    let layout = if flock.group {
        Layout::grouped(flock.format, &flock.addresses())
    } else {
        Layout::standalone(flock.format)
    };
    if flock.buttons {
        layout.with_buttons()
    } else {
        layout
    }
}

/// From one record of a bird to the next: the measuring cycle, or what the line can carry.
#[must_use]
pub fn record_period(flock: &Flock) -> Duration {
    let bytes = flock.birds * layout(flock).record_length() as u32;
    (byte_time(flock.baud) * bytes).max(Duration::from_millis(10))
}

/// How long a byte is on the line: a start bit, eight bits, a stop bit.
fn byte_time(baud: u32) -> Duration {
    Duration::from_secs_f64(10.0 / f64::from(baud.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};
    use sandtable_config::{Device, Rig};

    fn flock() -> Flock {
        let rig = Rig::builtin("workbench").unwrap();
        let Device::Flock(flock) = &rig.devices["flock"] else {
            panic!("the workbench has a Flock");
        };
        flock.clone()
    }

    /// Cycle by cycle, the bytes of two birds on slow paths of their own.
    fn sent(flock: &Flock, cycles: u32) -> Vec<(Nanos, Vec<u8>)> {
        let (layout, scale) = (layout(flock), Scale::of(flock));
        (0..cycles)
            .map(|cycle| {
                let mut bytes = Vec::new();
                for bird in 1..=2 {
                    let pose = path(bird, cycle);
                    let words = scale.words(&pose);
                    let record = Record {
                        bird,
                        words,
                        buttons: None,
                    };
                    layout.encode(&record, &mut bytes);
                }
                (Nanos(u64::from(cycle) * 9_680_000 + 5_000_000), bytes)
            })
            .collect()
    }

    fn path(bird: u32, cycle: u32) -> Rigid {
        let t = f64::from(cycle) * 0.00968;
        let turn = DQuat::from_rotation_z(0.4 * t + f64::from(bird));
        Rigid::new(turn, DVec3::new(0.3 * t.sin(), 0.1 * f64::from(bird), -0.5))
    }

    fn samples(flock: &Flock, chunks: &[(Nanos, Vec<u8>)]) -> Vec<PoseSample> {
        let mut stream = FlockStream::new(flock);
        let mut samples = Vec::new();
        for (arrival, bytes) in chunks {
            stream.push(bytes, *arrival, &mut |sample| {
                samples.extend(sample.pose().copied())
            });
        }
        samples
    }

    /// The nearest that a sample is to any pose sent for its sensor.
    fn error(flock: &Flock, sample: &PoseSample, cycles: u32) -> f64 {
        (0..cycles)
            .map(|cycle| {
                let sent = flock.table_from_tracker * path(sample.sensor, cycle);
                (sent.translation - sample.table_from_sensor.translation).length()
                    + sent
                        .rotation
                        .angle_between(sample.table_from_sensor.rotation)
            })
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn poses_come_out_in_the_tables_frame() {
        let flock = flock();
        let samples = samples(&flock, &sent(&flock, 50));
        // The first record of each bird waits for a second to vouch for it.
        assert_eq!(samples.len(), 2 * 49);
        for sample in &samples {
            assert!(error(&flock, sample, 50) < 1e-3);
            assert!(sample.table_from_sensor.translation.z > 0.0);
        }
        assert!(
            samples
                .iter()
                .filter(|s| s.sensor == 1)
                .is_sorted_by_key(|s| s.time)
        );
    }

    #[test]
    fn how_the_bytes_were_cut_into_reads_changes_no_pose() {
        let flock = flock();
        let chunks = sent(&flock, 30);
        let whole: Vec<Rigid> = samples(&flock, &chunks)
            .iter()
            .map(|s| s.table_from_sensor)
            .collect();
        let all: Vec<u8> = chunks.iter().flat_map(|(_, bytes)| bytes.clone()).collect();
        for size in [1, 7, 64] {
            let cut: Vec<(Nanos, Vec<u8>)> = all
                .chunks(size)
                .enumerate()
                .map(|(i, bytes)| {
                    (
                        Nanos((i * size) as u64 * 322_000 + 5_000_000),
                        bytes.to_vec(),
                    )
                })
                .collect();
            let got: Vec<Rigid> = samples(&flock, &cut)
                .iter()
                .map(|s| s.table_from_sensor)
                .collect();
            assert_eq!(got, whole, "reads of {size}");
        }
    }

    #[test]
    fn bytes_read_late_are_dated_by_the_line() {
        let flock = flock();
        let mut chunks = sent(&flock, 10);
        let late: Vec<u8> = chunks.drain(6..).flat_map(|(_, bytes)| bytes).collect();
        chunks.push((Nanos(100_000_000), late));
        let samples = samples(&flock, &chunks);
        let last = samples.last().unwrap();
        // 15 bytes of 10 bits at 115200 baud.
        assert_eq!(last.time, Nanos(100_000_000 - 15 * 86_806));
        assert!(
            samples
                .iter()
                .filter(|s| s.sensor == 2)
                .is_sorted_by_key(|s| s.time)
        );
    }

    #[test]
    fn a_hundred_equal_records_are_frozen() {
        let flock = flock();
        let (_, bytes) = sent(&flock, 1).remove(0);
        let chunks: Vec<_> = (0..120u64)
            .map(|i| (Nanos(i * 10_000_000), bytes.clone()))
            .collect();
        let samples = samples(&flock, &chunks);
        let of_bird_1: Vec<bool> = samples
            .iter()
            .filter(|s| s.sensor == 1)
            .map(|s| s.frozen)
            .collect();
        // The first record was not let out, so record 100 is sample 99.
        assert_eq!(of_bird_1.iter().position(|&frozen| frozen), Some(98));
        assert!(of_bird_1[98..].iter().all(|&frozen| frozen));
    }

    #[test]
    fn flock_every_byte_lost_doubled_or_unphased_lets_no_wrong_pose_out() {
        let flock = flock();
        let chunks = sent(&flock, 12);
        let all: Vec<u8> = chunks.iter().flat_map(|(_, bytes)| bytes.clone()).collect();
        for at in 0..all.len() {
            let mut lost = all.clone();
            lost.remove(at);
            let mut doubled = all.clone();
            doubled.insert(at, all[at]);
            let mut turned = all.clone();
            turned[at] ^= 0x80;
            for bad in [lost, doubled, turned] {
                let cut: Vec<_> = bad
                    .chunks(30)
                    .enumerate()
                    .map(|(i, bytes)| (Nanos(i as u64 * 9_680_000 + 5_000_000), bytes.to_vec()))
                    .collect();
                let samples = samples(&flock, &cut);
                assert!(samples.len() >= 2 * 11 - 2, "byte {at}: {}", samples.len());
                for sample in samples {
                    assert!(error(&flock, &sample, 12) < 1e-3, "byte {at}: {sample:?}");
                }
            }
        }
    }

    #[test]
    fn runs_of_lost_bytes_pass_only_by_what_a_hand_could_do() {
        let flock = flock();
        let chunks = sent(&flock, 12);
        let all: Vec<u8> = chunks.iter().flat_map(|(_, bytes)| bytes.clone()).collect();
        for from in 60..all.len() - 60 {
            for count in 2..=30 {
                let mut bad = all.clone();
                bad.drain(from..from + count);
                let cut: Vec<_> = bad
                    .chunks(30)
                    .enumerate()
                    .map(|(i, bytes)| (Nanos(i as u64 * 9_680_000 + 5_000_000), bytes.to_vec()))
                    .collect();
                for sample in samples(&flock, &cut) {
                    // A whole record's length lost may join two birds' records, which no check of
                    // bytes can see; the gate holds it to 5 m/s over three cycles and a turn.
                    assert!(
                        error(&flock, &sample, 12) < 0.7,
                        "{count} from {from}: {sample:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn few_altered_payload_bits_pass_and_only_by_what_a_hand_could_do() {
        let flock = flock();
        let chunks = sent(&flock, 12);
        let all: Vec<u8> = chunks.iter().flat_map(|(_, bytes)| bytes.clone()).collect();
        for at in 0..all.len() {
            for bit in 0..7 {
                let mut bad = all.clone();
                bad[at] ^= 1 << bit;
                let cut: Vec<_> = bad
                    .chunks(30)
                    .enumerate()
                    .map(|(i, bytes)| (Nanos(i as u64 * 9_680_000 + 5_000_000), bytes.to_vec()))
                    .collect();
                for sample in samples(&flock, &cut) {
                    // 5 m/s and 1000 degrees/s over one cycle of 10 ms.
                    assert!(
                        error(&flock, &sample, 12) < 0.05 + 0.175 + 0.01,
                        "{sample:?}"
                    );
                }
            }
        }
    }
}
