//! The file being recorded: MCAP chunks that are whole on the disk a fraction of a second later.

use super::foxglove;
use mcap::records::MessageHeader;
use mcap::write::Writer;
use sandtable_pose::Nanos;
use std::collections::{BTreeMap, HashMap};
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Why a recording cannot begin or has ended.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file is there already.
    #[error(
        "{path:?} exists; name another file, or move that one away: recordings are never overwritten"
    )]
    Exists {
        /// The file that was asked for.
        path: PathBuf,
    },
    /// The file cannot be made.
    #[error(
        "cannot create the recording {path:?} ({source}); name a file in a folder that you may write to"
    )]
    Create {
        /// The file that was asked for.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file can no longer be written.
    #[error(
        "the recording {path:?} ended early ({problem}); what was written until then is kept. Free some space or record to another disk"
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        problem: String,
    },
    /// No thread can be started.
    #[error("cannot start the recorder's thread ({0}); end other programs")]
    Thread(#[source] io::Error),
}

/// The longest that a message waits in memory before it is handed to the system.
const FLUSH_EVERY: Duration = Duration::from_millis(200);

/// The longest that a flushed message waits before it is on the disk.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// Bytes in a chunk at most, so that a busy second is several of them.
const CHUNK_SIZE: u64 = 64 << 10;

/// An MCAP file that is always whole up to the last flush.
pub(crate) struct RecordingFile {
    path: PathBuf,
    file: File,
    writer: Option<Writer<BufWriter<File>>>,
    channels: HashMap<String, u16>,
    sequence: u32,
    /// The file's length up to which it is whole.
    whole: u64,
    flushed: Instant,
    synced: Instant,
}

/// How a message's bytes are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Raw,
    Json,
    PoseInFrame,
}

impl RecordingFile {
    pub(crate) fn create(path: &Path) -> Result<Self, RecordError> {
        let failed = |source: io::Error| match source.kind() {
            io::ErrorKind::AlreadyExists => RecordError::Exists {
                path: path.to_owned(),
            },
            _ => RecordError::Create {
                path: path.to_owned(),
                source,
            },
        };
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(path)
            .map_err(failed)?;
        let second = file.try_clone().map_err(failed)?;
        let author = concat!("sandtable ", env!("CARGO_PKG_VERSION"));
        let writer = mcap::WriteOptions::library(mcap::WriteOptions::new(), author)
            .compression(Some(mcap::Compression::Zstd))
            .compression_threads(0)
            .chunk_size(Some(CHUNK_SIZE))
            // Else an open chunk claims an endless length on the disk.
            .disable_seeking(true)
            .create(BufWriter::new(second))
            .map_err(|error| failed(io::Error::other(error)))?;
        let now = Instant::now();
        let mut file = Self {
            path: path.to_owned(),
            file,
            writer: Some(writer),
            channels: HashMap::new(),
            sequence: 0,
            whole: 0,
            flushed: now,
            synced: now,
        };
        file.flush()?;
        Ok(file)
    }

    /// Adds a message; `time` is when it was logged.
    pub(crate) fn write(
        &mut self,
        topic: &str,
        encoding: Encoding,
        time: Nanos,
        data: &[u8],
    ) -> Result<(), RecordError> {
        // Running over all channels, so that a reader sees when a chunk is missing.
        let sequence = self.sequence;
        self.sequence = self.sequence.wrapping_add(1);
        self.attempt(|file, writer| {
            let channel_id = match file.channels.get(topic) {
                Some(&id) => id,
                None => {
                    let id = add_channel(writer, topic, encoding)?;
                    file.channels.insert(topic.to_owned(), id);
                    id
                }
            };
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time: time.0,
                publish_time: time.0,
            };
            writer.write_to_known_channel(&header, data)
        })
    }

    /// How long until [`RecordingFile::keep`] is due.
    pub(crate) fn keep_in(&self) -> Duration {
        FLUSH_EVERY.saturating_sub(self.flushed.elapsed())
    }

    /// Hands what was written to the system, and to the disk once a second.
    pub(crate) fn keep(&mut self) -> Result<(), RecordError> {
        if self.flushed.elapsed() >= FLUSH_EVERY {
            self.flush()?;
        }
        if self.synced.elapsed() >= SYNC_EVERY {
            self.synced = Instant::now();
            // A failed sync is final: the system may have dropped what it could not write.
            if let Err(error) = self.file.sync_data() {
                return Err(self.end_early(&error.to_string()));
            }
        }
        Ok(())
    }

    /// Writes the file's end and syncs it. Returns its length in bytes.
    pub(crate) fn finish(mut self) -> Result<u64, RecordError> {
        self.attempt(|_, writer| writer.finish().map(|_| ()))?;
        self.attempt(|file, _| Ok(file.file.sync_data()?))?;
        Ok(self.file.metadata().map_or(self.whole, |m| m.len()))
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        self.flushed = Instant::now();
        self.attempt(|_, writer| writer.flush())?;
        self.whole = self.file.metadata().map_or(self.whole, |m| m.len());
        Ok(())
    }

    fn attempt(
        &mut self,
        work: impl FnOnce(&mut Self, &mut Writer<BufWriter<File>>) -> mcap::McapResult<()>,
    ) -> Result<(), RecordError> {
        let Some(mut writer) = self.writer.take() else {
            return Err(self.error("it had ended already"));
        };
        let result = work(self, &mut writer);
        self.writer = Some(writer);
        match result {
            Ok(()) => Ok(()),
            Err(mcap::McapError::Io(error)) => Err(self.end_early(&error.to_string())),
            Err(error) => Err(self.end_early(&error.to_string())),
        }
    }

    /// Takes back what is half written, so that the rest stays readable.
    fn end_early(&mut self, problem: &str) -> RecordError {
        if let Some(writer) = self.writer.take() {
            // Neither writer nor buffer may write anything more, not even on being dropped.
            let (_, _unwritten) = writer.into_inner().into_parts();
        }
        let _ = self.file.set_len(self.whole);
        let _ = self.file.sync_data();
        self.error(problem)
    }

    fn error(&self, problem: &str) -> RecordError {
        RecordError::Write {
            path: self.path.clone(),
            problem: problem.to_owned(),
        }
    }
}

fn add_channel(
    writer: &mut Writer<BufWriter<File>>,
    topic: &str,
    encoding: Encoding,
) -> mcap::McapResult<u16> {
    let metadata = BTreeMap::new();
    match encoding {
        Encoding::Raw => writer.add_channel(0, topic, "application/octet-stream", &metadata),
        Encoding::Json => writer.add_channel(0, topic, "json", &metadata),
        Encoding::PoseInFrame => {
            let schema = foxglove::schema().to_string();
            let schema =
                writer.add_schema(foxglove::SCHEMA_NAME, "jsonschema", schema.as_bytes())?;
            writer.add_channel(schema, topic, "json", &metadata)
        }
    }
}
