//! The decoder: from a stream of bytes, some of them lost, to whole messages.
//!
//! Only marks have their highest bit set, so that the next message is found at the next mark,
//! whatever was before. Bytes that make no message are told as damage.

use super::message::{
    CONTACTS, ContactMessage, END, MARK, MessageFormat, TEXT, TIMED_CONTACTS, is_text,
};

/// The most bytes that a message has, the marks included; longer ones are damage.
pub const LONGEST_MESSAGE: usize = 256;

/// Finds messages in a stream of bytes. No port, no clock.
#[derive(Clone, Debug)]
pub struct Decoder {
    format: MessageFormat,
    /// The message that is being received, from its first mark on.
    bytes: [u8; LONGEST_MESSAGE],
    filled: usize,
    counts: DecoderCounts,
}

/// What a byte completes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decoded<'a> {
    /// A message of contacts.
    Contacts(ContactMessage),
    /// A text, without white space around it.
    Text(&'a str),
    /// Nothing: one byte or several were lost or altered.
    Damage,
}

/// What a decoder has seen since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecoderCounts {
    /// Whole messages.
    pub messages: u64,
    /// Bytes that belonged to no whole message.
    pub stray_bytes: u64,
    /// Messages cut short by the next one's mark.
    pub cut_messages: u64,
    /// Messages with both marks that are none.
    pub implausible: u64,
}

impl Decoder {
    /// A decoder that waits for the first mark.
    #[must_use]
    pub fn new(format: MessageFormat) -> Self {
        Self {
            format,
            bytes: [0; LONGEST_MESSAGE],
            filled: 0,
            counts: DecoderCounts::default(),
        }
    }

    /// Takes the next byte; tells what it completes.
    pub fn push(&mut self, byte: u8) -> Option<Decoded<'_>> {
        match byte {
            CONTACTS | TIMED_CONTACTS | TEXT => {
                let cut = self.filled;
                self.bytes[0] = byte;
                self.filled = 1;
                if cut == 0 {
                    return None;
                }
                self.counts.cut_messages += 1;
                self.counts.stray_bytes += cut as u64;
                Some(Decoded::Damage)
            }
            END if self.filled > 0 => self.end(),
            _ => {
                let text = self.filled > 0 && self.bytes[0] == TEXT;
                let fits = (1..LONGEST_MESSAGE - 1).contains(&self.filled);
                if !fits || byte & MARK != 0 || (text && !is_text(byte)) {
                    self.counts.stray_bytes += 1 + self.filled as u64;
                    self.filled = 0;
                    return Some(Decoded::Damage);
                }
                self.bytes[self.filled] = byte;
                self.filled += 1;
                None
            }
        }
    }

    fn end(&mut self) -> Option<Decoded<'_>> {
        let (mark, body) = (self.bytes[0], &self.bytes[1..self.filled]);
        self.filled = 0;
        let decoded = if mark == TEXT {
            let text = std::str::from_utf8(body).unwrap_or_default().trim();
            (!text.is_empty()).then_some(Decoded::Text(text))
        } else {
            ContactMessage::decode(self.format, mark, body).map(Decoded::Contacts)
        };
        match decoded {
            Some(_) => self.counts.messages += 1,
            None => self.counts.implausible += 1,
        }
        Some(decoded.unwrap_or(Decoded::Damage))
    }

    /// Whether a message of contacts has begun and not ended: something has changed, and it is not
    /// known what.
    #[must_use]
    pub fn amid_contacts(&self) -> bool {
        self.filled > 0 && self.bytes[0] != TEXT
    }

    /// Forgets a message begun, as after a restart of the device.
    pub fn restart(&mut self) {
        self.filled = 0;
    }

    /// What it has seen.
    #[must_use]
    pub fn counts(&self) -> DecoderCounts {
        self.counts
    }
}
