//! Reading a recording, whole or torn: messages in their order, up to the first damage.
//!
//! Only what lies in whole chunks counts, each checked by its sum before any of it is believed, and
//! the running numbers of the messages show a chunk that is missing.

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Why a recording cannot be replayed at all.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The file cannot be read.
    #[error(
        "cannot read the recording {path:?} ({source}); name a file that `sandtable record` wrote"
    )]
    Unreadable {
        /// The file that was asked for.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// It is no MCAP file.
    #[error(
        "{path:?} is no MCAP file: its first 8 bytes are not MCAP's; name a file that `sandtable record` wrote"
    )]
    NotMcap {
        /// The file that was asked for.
        path: PathBuf,
    },
    /// There is no rig in it that can be read.
    #[error("{path:?} holds no rig{cut}; name a file that `sandtable record` wrote")]
    NoRig {
        /// The file that was asked for.
        path: PathBuf,
        /// Where it breaks off, if it does.
        cut: String,
    },
    /// It breaks off, or is damaged, before its first message, which is the rig.
    #[error(
        "the beginning of the recording {path:?} is damaged, where its rig stands: {damage}; copy the file again from where it was recorded, or name another that `sandtable record` wrote"
    )]
    DamagedBeginning {
        /// The file that was asked for.
        path: PathBuf,
        /// Where, and what is wrong there.
        damage: String,
    },
    /// Its rig is not one.
    #[error("the rig in {path:?} cannot be used: {source}")]
    BadRig {
        /// The file that was asked for.
        path: PathBuf,
        /// What is wrong with it.
        source: Box<sandtable_config::RigError>,
    },
    /// A message in it is not what its topic promises.
    #[error("{path:?}, message {number} on {topic}: {problem}; record anew with this version")]
    BadMessage {
        /// The file that was asked for.
        path: PathBuf,
        /// The message's running number, from 0.
        number: u32,
        /// Its topic.
        topic: String,
        /// What is wrong with it.
        problem: String,
    },
}

/// A message as it was recorded.
pub(crate) struct RecordedMessage {
    pub(crate) number: u32,
    pub(crate) topic: String,
    pub(crate) time: u64,
    pub(crate) data: Vec<u8>,
}

/// A file's messages, and where it breaks off.
pub(crate) struct Messages {
    pub(crate) messages: Vec<RecordedMessage>,
    pub(crate) cut: Option<String>,
}

const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
const OP_FOOTER: u8 = 0x02;
const OP_CHANNEL: u8 = 0x04;
const OP_MESSAGE: u8 = 0x05;
const OP_CHUNK: u8 = 0x06;
const OP_DATA_END: u8 = 0x0F;

/// No chunk of ours comes near this, compressed or not.
const CHUNK_LIMIT: u64 = 16 << 20;

/// Reads the messages on topics that `wanted` admits.
pub(crate) fn read_messages(
    path: &Path,
    wanted: impl Fn(&str) -> bool,
) -> Result<Messages, ReplayError> {
    let unreadable = |source| ReplayError::Unreadable {
        path: path.to_owned(),
        source,
    };
    let file = File::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut input = BufReader::new(file);
    let mut magic = [0; 8];
    match input.read_exact(&mut magic) {
        Ok(()) if magic == MAGIC => {}
        Ok(()) => {
            return Err(ReplayError::NotMcap {
                path: path.to_owned(),
            });
        }
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            return Err(ReplayError::NotMcap {
                path: path.to_owned(),
            });
        }
        Err(error) => return Err(unreadable(error)),
    }
    let mut reading = Reading {
        topics: HashMap::new(),
        messages: Vec::new(),
        next_number: 0,
    };
    let mut at = MAGIC.len() as u64;
    let cut = loop {
        let mut head = [0; 9];
        match input.read_exact(&mut head) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                break Some(format!("it breaks off at byte {length}"));
            }
            Err(error) => return Err(unreadable(error)),
        }
        let [op, size @ ..] = head;
        let size = u64::from_le_bytes(size);
        let rest = length.saturating_sub(at + 9);
        if op == OP_DATA_END || op == OP_FOOTER {
            break None;
        }
        if size > rest {
            break Some(format!("it breaks off within the record at byte {at}"));
        }
        if op == OP_CHUNK {
            if size > CHUNK_LIMIT {
                break Some(format!("the chunk at byte {at} claims {size} bytes"));
            }
            let mut chunk = head.to_vec();
            chunk.resize(head.len() + size as usize, 0);
            input
                .read_exact(&mut chunk[head.len()..])
                .map_err(unreadable)?;
            if let Err(problem) = reading.chunk(&chunk, &wanted) {
                break Some(format!("the chunk at byte {at} is damaged: {problem}"));
            }
        } else {
            input
                .seek(SeekFrom::Current(size.cast_signed()))
                .map_err(unreadable)?;
        }
        at += 9 + size;
    };
    Ok(Messages {
        messages: reading.messages,
        cut,
    })
}

struct Reading {
    topics: HashMap<u16, String>,
    messages: Vec<RecordedMessage>,
    next_number: u32,
}

impl Reading {
    /// Takes the messages of a chunk, all or none.
    fn chunk(&mut self, chunk: &[u8], wanted: impl Fn(&str) -> bool) -> Result<(), String> {
        let records = whole_chunk(chunk).map_err(|error| error.to_string())?;
        let mut next_number = self.next_number;
        for record in &records {
            if let Record::Message { header, .. } = record {
                if header.sequence != next_number {
                    return Err(format!(
                        "messages from {next_number} on are missing before it"
                    ));
                }
                next_number = next_number.wrapping_add(1);
            }
        }
        self.next_number = next_number;
        for record in records {
            match record {
                Record::Channel(channel) => {
                    self.topics.insert(channel.id, channel.topic);
                }
                Record::Message { header, data } => {
                    let Some(topic) = self.topics.get(&header.channel_id) else {
                        return Err(format!("message {} has no channel", header.sequence));
                    };
                    if wanted(topic) {
                        self.messages.push(RecordedMessage {
                            number: header.sequence,
                            topic: topic.clone(),
                            time: header.log_time,
                            data: data.into_owned(),
                        });
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The records within a chunk's own record, none of them given before the sum of all was checked.
fn whole_chunk(mut chunk: &[u8]) -> mcap::McapResult<Vec<Record<'static>>> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(CHUNK_LIMIT as usize);
    let mut reader = LinearReader::new_with_options(options);
    let mut records = Vec::new();
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(need) => {
                let (given, rest) = chunk.split_at(need.min(chunk.len()));
                reader.insert(given.len()).copy_from_slice(given);
                reader.notify_read(given.len());
                chunk = rest;
            }
            LinearReadEvent::Record { data, opcode } => {
                if matches!(opcode, OP_CHANNEL | OP_MESSAGE) {
                    records.push(mcap::parse_record(opcode, data)?.into_owned());
                }
            }
        }
    }
    Ok(records)
}
