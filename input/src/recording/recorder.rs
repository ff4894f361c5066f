//! The recorder: a thread that writes what devices hand it, and never makes them wait.

use super::file::{Encoding, RecordError, RecordingFile};
use super::foxglove::pose_in_frame;
use super::{
    DeviceEvent, GAPS_TOPIC, GapMessage, PLACEMENT_TOPIC, RIG_TOPIC, RigMessage, bytes_topic,
    events_topic, pose_topic,
};
use crate::PoseSample;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError};
use sandtable_config::Rig;
use sandtable_pose::Nanos;
use serde_json::Value;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// Records a session. Clones write to the same file; it is finished by [`Recorder::finish`], or
/// when the last clone is dropped.
#[derive(Clone, Debug)]
pub struct Recorder {
    shared: Arc<Shared>,
}

/// What a recording holds in the end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordingSummary {
    /// Messages written.
    pub messages: u64,
    /// Messages dropped because the disk was too slow for too long.
    pub dropped: u64,
    /// The file's length.
    pub bytes: u64,
}

#[derive(Debug)]
struct Shared {
    queue: Mutex<Option<Sender<Entry>>>,
    dropped: Arc<AtomicU64>,
    problem: Arc<Mutex<Option<String>>>,
    thread: Mutex<Option<JoinHandle<Result<RecordingSummary, RecordError>>>>,
}

/// Something to be written.
#[derive(Debug)]
enum Entry {
    Bytes {
        device: String,
        time: Nanos,
        bytes: Vec<u8>,
    },
    Event {
        device: String,
        time: Nanos,
        event: DeviceEvent,
    },
    Pose {
        device: String,
        sample: PoseSample,
    },
    Json {
        topic: String,
        time: Nanos,
        value: Value,
    },
}

/// Entries that may wait: minutes of four birds, and under 64 MiB.
const QUEUE: usize = 1 << 16;

impl Recorder {
    /// Begins a recording in a new file, with the rig, the files that it names, and the
    /// placement in it.
    ///
    /// # Errors
    /// [`RecordError::Exists`] where the file is there already; the others where it cannot be made.
    pub fn create(
        path: &Path,
        rig: &Rig,
        placement: Option<&Value>,
        start: Nanos,
    ) -> Result<Self, RecordError> {
        let mut file = RecordingFile::create(path)?;
        let message = RigMessage {
            name: rig.name.clone(),
            text: rig.text().to_owned(),
            files: rig.files(),
        };
        file.write(RIG_TOPIC, Encoding::Json, start, &json(&message))?;
        if let Some(placement) = placement {
            file.write(PLACEMENT_TOPIC, Encoding::Json, start, &json(placement))?;
        }
        let (queue, entries) = crossbeam_channel::bounded(QUEUE);
        let dropped = Arc::new(AtomicU64::new(0));
        let problem = Arc::new(Mutex::new(None));
        let mut writing = Writing {
            file,
            summary: RecordingSummary {
                messages: 1 + u64::from(placement.is_some()),
                ..RecordingSummary::default()
            },
            newest: start,
            dropped: Arc::clone(&dropped),
        };
        let reported = Arc::clone(&problem);
        let thread = std::thread::Builder::new()
            .name("recorder".into())
            .spawn(move || {
                let result = match writing.run(&entries) {
                    Ok(()) => writing.finish(),
                    Err(error) => Err(error),
                };
                if let Err(error) = &result {
                    tracing::error!("{error}");
                    *lock(&reported) = Some(error.to_string());
                }
                result
            })
            .map_err(RecordError::Thread)?;
        Ok(Self {
            shared: Arc::new(Shared {
                queue: Mutex::new(Some(queue)),
                dropped,
                problem,
                thread: Mutex::new(Some(thread)),
            }),
        })
    }

    /// Records the bytes of one read that ended at `time`.
    pub fn bytes(&self, device: &str, time: Nanos, bytes: &[u8]) {
        self.put(Entry::Bytes {
            device: device.to_owned(),
            time,
            bytes: bytes.to_vec(),
        });
    }

    /// Records what happened to a device.
    pub fn event(&self, device: &str, time: Nanos, event: DeviceEvent) {
        self.put(Entry::Event {
            device: device.to_owned(),
            time,
            event,
        });
    }

    /// Records a decoded pose, for viewers.
    pub fn pose(&self, device: &str, sample: PoseSample) {
        self.put(Entry::Pose {
            device: device.to_owned(),
            sample,
        });
    }

    /// Records that the placement is another from `time` on.
    pub fn placement(&self, time: Nanos, placement: Value) {
        self.json(PLACEMENT_TOPIC, time, placement);
    }

    /// Records a value of the caller's own under a topic such as `/session/flight`.
    pub fn json(&self, topic: &str, time: Nanos, value: Value) {
        self.put(Entry::Json {
            topic: topic.to_owned(),
            time,
            value,
        });
    }

    /// Why the recording has ended early, once it has.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        lock(&self.shared.problem).clone()
    }

    /// How many messages were dropped so far because the disk was too slow for too long.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared.dropped.load(Ordering::Relaxed)
    }

    /// Writes out what waits, ends the file and says what it holds. What is recorded afterwards
    /// is ignored, and a second call gives `None`.
    ///
    /// # Errors
    /// Where the recording has ended early.
    pub fn finish(&self) -> Result<Option<RecordingSummary>, RecordError> {
        *lock(&self.shared.queue) = None;
        let Some(thread) = lock(&self.shared.thread).take() else {
            return Ok(None);
        };
        match thread.join() {
            Ok(result) => result.map(Some),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }

    fn put(&self, entry: Entry) {
        let queue = lock(&self.shared.queue);
        if let Some(queue) = queue.as_ref()
            && let Err(TrySendError::Full(_)) = queue.try_send(entry)
        {
            // Devices never wait for a disk; the file says how much is missing.
            self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        *lock(&self.queue) = None;
        if let Some(thread) = lock(&self.thread).take() {
            // An error was logged by the thread itself.
            let _ = thread.join();
        }
    }
}

/// The recorder's thread.
struct Writing {
    file: RecordingFile,
    summary: RecordingSummary,
    newest: Nanos,
    dropped: Arc<AtomicU64>,
}

impl Writing {
    fn run(&mut self, entries: &Receiver<Entry>) -> Result<(), RecordError> {
        loop {
            match entries.recv_timeout(self.file.keep_in()) {
                Ok(entry) => self.write(&entry)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return self.write_gaps(),
            }
            if self.file.keep_in().is_zero() {
                self.write_gaps()?;
                self.file.keep()?;
            }
        }
    }

    fn finish(mut self) -> Result<RecordingSummary, RecordError> {
        self.summary.bytes = self.file.finish()?;
        Ok(self.summary)
    }

    fn write(&mut self, entry: &Entry) -> Result<(), RecordError> {
        let (topic, encoding, time, data);
        match entry {
            Entry::Bytes {
                device,
                time: at,
                bytes,
            } => {
                (topic, encoding, time) = (bytes_topic(device), Encoding::Raw, *at);
                data = bytes.clone();
            }
            Entry::Event {
                device,
                time: at,
                event,
            } => {
                (topic, encoding, time) = (events_topic(device), Encoding::Json, *at);
                data = json(event);
            }
            Entry::Pose { device, sample } => {
                topic = pose_topic(device, sample.sensor);
                (encoding, time) = (Encoding::PoseInFrame, sample.time);
                data = json(&pose_in_frame(sample));
            }
            Entry::Json {
                topic: own,
                time: at,
                value,
            } => {
                (topic, encoding, time) = (own.clone(), Encoding::Json, *at);
                data = json(value);
            }
        }
        self.newest = self.newest.max(time);
        self.summary.messages += 1;
        self.file.write(&topic, encoding, time, &data)
    }

    /// Says in the file how many messages are missing from it.
    fn write_gaps(&mut self) -> Result<(), RecordError> {
        let dropped = self.dropped.load(Ordering::Relaxed);
        let new = dropped - self.summary.dropped;
        if new == 0 {
            return Ok(());
        }
        self.summary.dropped = dropped;
        self.summary.messages += 1;
        let message = json(&GapMessage { dropped: new });
        self.file
            .write(GAPS_TOPIC, Encoding::Json, self.newest, &message)
    }
}

fn json(value: &impl serde::Serialize) -> Vec<u8> {
    serde_json::to_vec(value).expect("the values recorded have string keys only")
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
