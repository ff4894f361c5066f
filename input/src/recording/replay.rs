//! Replay: a recording's bytes through the live decoders, on a virtual clock.

use super::reader::{RecordedMessage, ReplayError, read_messages};
use super::{DeviceEvent, GAPS_TOPIC, GapMessage, PLACEMENT_TOPIC, RIG_TOPIC, RigMessage};
use crate::{Hub, Sample, Stream, stream_of};
use sandtable_config::{Device, Rig};
use sandtable_pose::Nanos;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A recording, and how far it has been played.
#[derive(Debug)]
pub struct Replay {
    rig: Rig,
    entries: Vec<Entry>,
    /// The first entry that has not been played.
    next: usize,
    streams: BTreeMap<String, Box<dyn Stream>>,
    values: BTreeMap<String, Vec<(Nanos, Value)>>,
    start: Nanos,
    end: Nanos,
    dropped: u64,
    cut: Option<String>,
}

#[derive(Debug)]
struct Entry {
    arrival: Nanos,
    device: String,
    what: What,
}

#[derive(Debug)]
enum What {
    Bytes(Vec<u8>),
    Event(DeviceEvent),
}

impl Replay {
    /// Opens a recording. One that breaks off, or is damaged, is played up to there; see
    /// [`Replay::cut`].
    ///
    /// # Errors
    /// Where the file cannot be read, is no MCAP file, or was not written by a recorder.
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        let read = read_messages(path, |topic| !topic.starts_with("/poses/"))?;
        let bad = |message: &RecordedMessage, problem: String| ReplayError::BadMessage {
            path: path.to_owned(),
            number: message.number,
            topic: message.topic.clone(),
            problem,
        };
        let mut rig = None;
        let mut entries = Vec::new();
        let mut values: BTreeMap<String, Vec<(Nanos, Value)>> = BTreeMap::new();
        let (mut start, mut end, mut dropped) = (None, Nanos(0), 0u64);
        for message in read.messages {
            let time = Nanos(message.time);
            start.get_or_insert(time);
            end = end.max(time);
            let device = message.topic.strip_prefix("/devices/");
            if let Some((device, kind)) = device.and_then(|rest| rest.rsplit_once('/')) {
                let what = match kind {
                    "bytes" => What::Bytes(message.data),
                    "events" => What::Event(
                        serde_json::from_slice(&message.data)
                            .map_err(|error| bad(&message, error.to_string()))?,
                    ),
                    _ => continue,
                };
                entries.push(Entry {
                    arrival: time,
                    device: device.to_owned(),
                    what,
                });
            } else if message.topic == RIG_TOPIC {
                let found: RigMessage = serde_json::from_slice(&message.data)
                    .map_err(|error| bad(&message, error.to_string()))?;
                rig.get_or_insert(found);
            } else if message.topic == GAPS_TOPIC {
                let gap: GapMessage = serde_json::from_slice(&message.data)
                    .map_err(|error| bad(&message, error.to_string()))?;
                dropped = dropped.saturating_add(gap.dropped);
            } else {
                let value = serde_json::from_slice(&message.data)
                    .map_err(|error| bad(&message, error.to_string()))?;
                values.entry(message.topic).or_default().push((time, value));
            }
        }
        let Some(found) = rig else {
            let path = path.to_owned();
            return Err(match read.cut {
                Some(damage) if start.is_none() => ReplayError::DamagedBeginning { path, damage },
                cut => ReplayError::NoRig {
                    path,
                    cut: cut.map_or(String::new(), |cut| format!(": {cut}")),
                },
            });
        };
        let file = format!("the rig in {}", path.display());
        let rig = Rig::recorded(&found.text, &file, &found.files).map_err(|source| {
            ReplayError::BadRig {
                path: path.to_owned(),
                source: Box::new(source),
            }
        })?;
        // Devices queue their entries one by one, so those of two may be a moment out of order.
        entries.sort_by_key(|entry| entry.arrival);
        Ok(Self {
            streams: streams(&rig),
            rig,
            entries,
            next: 0,
            values,
            start: start.unwrap_or_default(),
            end,
            dropped,
            cut: read.cut,
        })
    }

    /// The rig that it was recorded at. Its devices' calibration is the recorded one.
    #[must_use]
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// The first placement, as its recorder was given it.
    #[must_use]
    pub fn placement(&self) -> Option<&Value> {
        self.values(PLACEMENT_TOPIC).first().map(|(_, value)| value)
    }

    /// All values recorded under a topic of the caller's own, with their times.
    #[must_use]
    pub fn values(&self, topic: &str) -> &[(Nanos, Value)] {
        self.values.get(topic).map_or(&[], Vec::as_slice)
    }

    /// The time of its first message.
    #[must_use]
    pub fn start(&self) -> Nanos {
        self.start
    }

    /// The time of its last message.
    #[must_use]
    pub fn end(&self) -> Nanos {
        self.end
    }

    /// How many messages its recorder had to drop, so that they are not in it.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Where and why it breaks off, if it does.
    #[must_use]
    pub fn cut(&self) -> Option<&str> {
        self.cut.as_deref()
    }

    /// Gives `hub` all samples of bytes that had arrived by `time` and were not given before.
    ///
    /// The hub should be one for [`Replay::rig`]; time never goes back but by [`Replay::rewind`].
    pub fn advance_to(&mut self, time: Nanos, hub: &Hub) {
        while let Some(entry) = self.entries.get(self.next)
            && entry.arrival <= time
        {
            self.next += 1;
            let Some(stream) = self.streams.get_mut(&entry.device) else {
                continue;
            };
            match &entry.what {
                What::Bytes(bytes) => {
                    stream.push(bytes, entry.arrival, &mut |sample| {
                        hub.push(&entry.device, sample);
                    });
                }
                What::Event(DeviceEvent::Started) => stream.restart(),
                What::Event(DeviceEvent::CalibrationReset) => stream.reset_calibration(),
                What::Event(DeviceEvent::Lost) => hub.let_go(&entry.device, entry.arrival),
            }
        }
    }

    /// All samples of a device, from the recording's beginning to its end, however far it has been
    /// played; none where it has no such device.
    #[must_use]
    pub fn samples(&self, device: &str) -> Vec<Sample> {
        let known = self.rig.devices.get(device);
        known.map_or_else(Vec::new, |known| self.samples_as(device, known))
    }

    /// The same where the device is `known`, not as the rig has it.
    pub(crate) fn samples_as(&self, device: &str, known: &Device) -> Vec<Sample> {
        let mut stream = stream_of(known);
        let mut samples = Vec::new();
        for entry in self.entries.iter().filter(|entry| entry.device == device) {
            match &entry.what {
                What::Bytes(bytes) => {
                    stream.push(bytes, entry.arrival, &mut |sample| samples.push(sample));
                }
                What::Event(DeviceEvent::Started) => stream.restart(),
                What::Event(DeviceEvent::CalibrationReset) => stream.reset_calibration(),
                What::Event(DeviceEvent::Lost) => {}
            }
        }
        samples
    }

    /// Whether all of it has been played.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.next == self.entries.len()
    }

    /// Goes back to its beginning; the hub must be cleared beside it.
    pub fn rewind(&mut self) {
        self.next = 0;
        self.streams = streams(&self.rig);
    }
}

fn streams(rig: &Rig) -> BTreeMap<String, Box<dyn Stream>> {
    let devices = rig.devices.iter();
    devices
        .map(|(name, device)| (name.clone(), stream_of(device)))
        .collect()
}
