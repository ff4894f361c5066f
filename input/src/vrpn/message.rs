//! Messages: a header of six big-endian words, a payload, and zeros up to a multiple of 8 bytes.
//!
//! The header holds the length (its own 24 bytes and the payload's, without the padding), the time
//! of day, the sender's and the type's number, and a running number.

use std::time::Duration;

/// A header's length in bytes.
pub const HEADER_LENGTH: usize = 24;

/// The longest payload that is taken, in bytes; VRPN's own programs send less than 64,000.
pub const LONGEST_PAYLOAD: usize = 1 << 16;

/// The most that a message takes on the wire, in bytes.
pub const LONGEST_MESSAGE: usize = HEADER_LENGTH + LONGEST_PAYLOAD;

const ALIGNMENT: usize = 8;

/// What goes before a payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// How many bytes of payload follow, padding not counted.
    pub payload: usize,
    /// When what it tells happened, on the sending computer's clock.
    pub stamp: Stamp,
    /// Who says it, by a number of this connection.
    pub sender: i32,
    /// What it is, by a number of this connection; negative for the connection's own messages.
    pub kind: i32,
    /// A running number, or anything: nobody reads it.
    pub number: u32,
}

/// A time of day, since the start of 1970.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// Whole seconds.
    pub seconds: u32,
    /// Microseconds besides.
    pub microseconds: u32,
}

impl Stamp {
    /// The time of day that lies `since` after the start of 1970.
    #[must_use]
    pub fn since_1970(since: Duration) -> Self {
        Self {
            seconds: u32::try_from(since.as_secs()).unwrap_or(u32::MAX),
            microseconds: since.subsec_micros(),
        }
    }
}

/// A header whose length cannot be: what follows it cannot be told apart any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a message claims {claimed} bytes, where VRPN's have {HEADER_LENGTH} to {LONGEST_MESSAGE}")]
pub struct LengthError {
    /// The length that it claims, in bytes.
    pub claimed: u32,
}

impl Header {
    /// Reads a header.
    ///
    /// # Errors
    /// Where its length is less than its own, or more than any message has.
    pub fn decode(bytes: &[u8; HEADER_LENGTH]) -> Result<Self, LengthError> {
        let word = |n: usize| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|byte| bytes[4 * n + byte]);
            u32::from_be_bytes([a, b, c, d])
        };
        let claimed = word(0);
        let length = claimed as usize;
        if !(HEADER_LENGTH..=LONGEST_MESSAGE).contains(&length) {
            return Err(LengthError { claimed });
        }
        Ok(Self {
            payload: length - HEADER_LENGTH,
            stamp: Stamp {
                seconds: word(1),
                microseconds: word(2),
            },
            sender: word(3).cast_signed(),
            kind: word(4).cast_signed(),
            number: word(5),
        })
    }

    /// How many bytes the message has on the wire, header and padding included.
    #[must_use]
    pub fn wire_length(&self) -> usize {
        HEADER_LENGTH + self.payload.next_multiple_of(ALIGNMENT)
    }

    fn encode(&self) -> [u8; HEADER_LENGTH] {
        let length = u32::try_from(HEADER_LENGTH + self.payload).unwrap_or(u32::MAX);
        let words = [
            length,
            self.stamp.seconds,
            self.stamp.microseconds,
            self.sender.cast_unsigned(),
            self.kind.cast_unsigned(),
            self.number,
        ];
        let mut bytes = [0; HEADER_LENGTH];
        for (four, word) in bytes.chunks_exact_mut(4).zip(words) {
            four.copy_from_slice(&word.to_be_bytes());
        }
        bytes
    }
}

/// Appends a message to `out`: `header` with the length of what `payload` writes, that, and zeros.
pub fn write_message(header: &Header, payload: impl FnOnce(&mut Vec<u8>), out: &mut Vec<u8>) {
    let start = out.len();
    out.extend_from_slice(&[0; HEADER_LENGTH]);
    payload(out);
    let header = Header {
        payload: out.len() - start - HEADER_LENGTH,
        ..*header
    };
    out[start..start + HEADER_LENGTH].copy_from_slice(&header.encode());
    out.resize(start + header.wire_length(), 0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const HEADER: Header = Header {
        payload: 0,
        stamp: Stamp {
            seconds: 0x0102_0304,
            microseconds: 5,
        },
        sender: 6,
        kind: -2,
        number: 7,
    };

    #[test]
    fn the_length_counts_the_header_and_not_the_padding() {
        let mut bytes = Vec::new();
        write_message(&HEADER, |out| out.extend_from_slice(b"abc"), &mut bytes);
        assert_eq!(bytes.len(), 32);
        assert_eq!(
            bytes[..24],
            [
                0, 0, 0, 27, 1, 2, 3, 4, 0, 0, 0, 5, 0, 0, 0, 6, 255, 255, 255, 254, 0, 0, 0, 7
            ]
        );
        assert_eq!(bytes[24..], *b"abc\0\0\0\0\0");
        write_message(&HEADER, |_| {}, &mut bytes);
        assert_eq!(bytes.len(), 32 + 24);
        assert_eq!(bytes[32..36], [0, 0, 0, 24]);
    }

    #[test]
    fn lengths_that_cannot_be_are_refused() {
        let mut bytes = HEADER.encode();
        for (length, ok) in [
            (0, false),
            (23, false),
            (24, true),
            (0x0001_0018, true),
            (0x0001_0019, false),
            (u32::MAX, false),
        ] {
            bytes[..4].copy_from_slice(&length.to_be_bytes());
            assert_eq!(Header::decode(&bytes).is_ok(), ok, "{length}");
        }
    }

    proptest! {
        #[test]
        fn a_header_comes_back_as_it_was(
            payload in 0..=LONGEST_PAYLOAD, seconds: u32, microseconds: u32, sender: i32,
            kind: i32, number: u32,
        ) {
            let stamp = Stamp { seconds, microseconds };
            let header = Header { payload, stamp, sender, kind, number };
            prop_assert_eq!(Header::decode(&header.encode()), Ok(header));
        }
    }
}
