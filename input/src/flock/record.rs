//! Records: the bytes of one bird's measurement, and the words in them.
//!
//! A word is 16 bits of two's complement of which the line carries the upper 14, seven a byte, low
//! half first. Bit 7 is the phase bit: set in a record's first byte and in no other. Behind the
//! words come, where they are on, the button byte and the bird's address. Nothing here knows units,
//! ports or times.

use super::format::Coding;
use sandtable_config::RecordFormat;
use std::ops::Deref;

/// The most words that a record has: a position and a matrix.
const MOST_WORDS: usize = 12;

/// The most bytes that a record has: its words, the buttons and the address.
pub const LONGEST_RECORD: usize = 2 * MOST_WORDS + 2;

/// The phase bit, set in a record's first byte only.
pub(crate) const PHASE: u8 = 0x80;

/// The words of a record, as the line carries them: the low two bits are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Words {
    words: [i16; MOST_WORDS],
    count: usize,
}

impl Words {
    /// The words of `words`, or the first twelve where there are more.
    #[must_use]
    pub fn new(words: &[i16]) -> Self {
        let mut all = [0; MOST_WORDS];
        let count = words.len().min(MOST_WORDS);
        all[..count].copy_from_slice(&words[..count]);
        Self { words: all, count }
    }
}

impl Deref for Words {
    type Target = [i16];

    fn deref(&self) -> &[i16] {
        &self.words[..self.count]
    }
}

/// One bird's measurement as the line carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// The bird, from 1, in the order of the addresses on the line.
    pub bird: u32,
    /// What was measured; how many words, and what they mean, is the format's.
    pub words: Words,
    /// The button byte, where buttons are on.
    pub buttons: Option<u8>,
}

/// What a record looks like: its words, whether buttons follow, and which birds share the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    words: usize,
    buttons: bool,
    addresses: Vec<u8>,
}

impl Layout {
    /// Group mode: each record ends in its bird's address, which is one of `addresses`.
    #[must_use]
    pub fn grouped(format: RecordFormat, addresses: &[u8]) -> Self {
        Self {
            words: Coding::of(format).words(),
            buttons: false,
            addresses: addresses.to_vec(),
        }
    }

    /// One bird alone on the line: no address.
    #[must_use]
    pub fn standalone(format: RecordFormat) -> Self {
        Self::grouped(format, &[])
    }

    /// The same with a button byte in each record.
    #[must_use]
    pub fn with_buttons(self) -> Self {
        Self {
            buttons: true,
            ..self
        }
    }

    /// Bytes in a record.
    #[must_use]
    pub fn record_length(&self) -> usize {
        2 * self.words + usize::from(self.buttons) + usize::from(!self.addresses.is_empty())
    }

    /// How many birds send records.
    #[must_use]
    pub fn birds(&self) -> usize {
        self.addresses.len().max(1)
    }

    /// Reads a record of exactly [`Layout::record_length`] bytes, or `None` where the phase bits
    /// or the address are not those of a record.
    #[must_use]
    pub fn decode(&self, bytes: &[u8]) -> Option<Record> {
        let (first, rest) = bytes.split_first()?;
        let phased = first & PHASE != 0 && rest.iter().all(|byte| byte & PHASE == 0);
        if !phased || bytes.len() != self.record_length() {
            return None;
        }
        let (pairs, tail) = bytes.split_at(2 * self.words);
        let mut words = Words {
            count: self.words,
            ..Words::default()
        };
        for (word, pair) in words.words.iter_mut().zip(pairs.chunks_exact(2)) {
            *word = word_from_bytes([pair[0], pair[1]]);
        }
        let (buttons, tail) = match tail {
            [buttons, tail @ ..] if self.buttons => (Some(*buttons), tail),
            tail => (None, tail),
        };
        let bird = match tail {
            [] => 1,
            [address, ..] => self.bird(*address)?,
        };
        Some(Record {
            bird,
            words,
            buttons,
        })
    }

    /// Appends the record's bytes to `out`; the inverse of [`Layout::decode`].
    ///
    /// A bird that is not on the line, and a record of another format, append nothing.
    pub fn encode(&self, record: &Record, out: &mut Vec<u8>) {
        let index = (record.bird as usize).wrapping_sub(1);
        if index >= self.birds() || record.words.len() != self.words {
            return;
        }
        encode_words(&record.words, out);
        if self.buttons {
            out.push(record.buttons.unwrap_or(0) & !PHASE);
        }
        out.extend(self.addresses.get(index));
    }

    fn bird(&self, address: u8) -> Option<u32> {
        // Some units send 0 where they mean the first address.
        let meant = if address == 0 { 1 } else { address };
        let index = self.addresses.iter().position(|&known| known == meant)?;
        u32::try_from(index + 1).ok()
    }
}

/// Which buttons a button byte means, bit 0 the left one, 1 the middle one, 2 the right one.
///
/// The device sends one code for several states: the middle button hides the left one, and the
/// right one both.
#[must_use]
pub fn buttons_pressed(byte: u8) -> u64 {
    match byte & 0x70 {
        0x70 => 0b100,
        0x30 => 0b010,
        0x10 => 0b001,
        _ => 0,
    }
}

/// Appends words as a record's bytes: the first one carries the phase bit.
pub(crate) fn encode_words(words: &[i16], out: &mut Vec<u8>) {
    let start = out.len();
    for word in words {
        out.extend(bytes_from_word(*word));
    }
    if let Some(first) = out.get_mut(start) {
        *first |= PHASE;
    }
}

/// The word nearest to `share` of the full scale; what lies beyond is cut to it.
pub(crate) fn word_from_share(share: f64) -> i16 {
    // A float-to-integer cast saturates, and gives 0 for NaN.
    (share * 32768.0).round() as i16
}

/// The share of the full scale that a word means, in [−1, 1).
pub(crate) fn share_from_word(word: i16) -> f64 {
    f64::from(word) / 32768.0
}

fn word_from_bytes([low, high]: [u8; 2]) -> i16 {
    let bits = (u16::from(high & 0x7F) << 9) | (u16::from(low & 0x7F) << 2);
    bits.cast_signed()
}

fn bytes_from_word(word: i16) -> [u8; 2] {
    let bits = word.cast_unsigned();
    [(bits >> 2) as u8 & 0x7F, (bits >> 9) as u8 & 0x7F]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FORMAT: RecordFormat = RecordFormat::PositionQuaternion;

    /// The bytes of the worked position/quaternion record: bird 1, group mode.
    const WORKED: [u8; 15] = [
        0xAA, 0x15, 0x2A, 0x05, 0x0E, 0x77, 0x73, 0x3C, 0x47, 0x7D, 0x71, 0x73, 0x57, 0x70, 0x01,
    ];

    #[test]
    fn the_worked_record_has_the_worked_words() {
        let layout = Layout::grouped(FORMAT, &[1, 2]);
        let record = layout.decode(&WORKED).unwrap();
        assert_eq!(record.bird, 1);
        let words = [10920, 2728, -4552, 31180, -1252, -6204, -7844];
        assert_eq!(*record.words, words);
        let mut bytes = Vec::new();
        layout.encode(&record, &mut bytes);
        assert_eq!(bytes, WORKED);
    }

    #[test]
    fn a_record_with_buttons_is_the_worked_one() {
        let bytes = [
            0xAA, 0x15, 0x2A, 0x05, 0x0E, 0x77, 0x55, 0x0A, 0x0E, 0x07, 0x47, 0x03, 0x30, 0x02,
        ];
        let layout = Layout::grouped(RecordFormat::PositionAngles, &[1, 2]).with_buttons();
        let record = layout.decode(&bytes).unwrap();
        assert_eq!((record.bird, record.buttons), (2, Some(0x30)));
        assert_eq!(*record.words, [10920, 2728, -4552, 5460, 3640, 1820]);
        assert_eq!(buttons_pressed(0x30), 0b010);
        let mut again = Vec::new();
        layout.encode(&record, &mut again);
        assert_eq!(again, bytes);
    }

    #[test]
    fn the_zero_pose_has_the_worked_bytes() {
        let words = Words::new(&[0, 0, 0, word_from_share(1.0), 0, 0, 0]);
        let record = Record {
            bird: 1,
            words,
            buttons: None,
        };
        let mut bytes = Vec::new();
        Layout::standalone(FORMAT).encode(&record, &mut bytes);
        assert_eq!(bytes, [0x80, 0, 0, 0, 0, 0, 0x7F, 0x3F, 0, 0, 0, 0, 0, 0]);
        let back = Layout::standalone(FORMAT).decode(&bytes).unwrap();
        assert_eq!(back.words[3], 32764);
    }

    #[test]
    fn the_makers_own_example_holds() {
        let mut bytes = Vec::new();
        encode_words(&[0x1120, 0x3344, 0x5564], &mut bytes);
        assert_eq!(bytes, [0xC8, 0x08, 0x51, 0x19, 0x59, 0x2A]);
        assert_eq!(word_from_bytes([0xC8, 0x08]), 4384);
        assert_eq!(word_from_bytes([0x59, 0x2A]), 21860);
    }

    #[test]
    fn words_beyond_the_scale_are_cut_to_it() {
        assert_eq!(word_from_share(1.0), 32767);
        assert_eq!(word_from_share(-1.0), -32768);
        assert_eq!(word_from_share(-7.0), -32768);
        assert_eq!(word_from_share(f64::NAN), 0);
    }

    #[test]
    fn address_zero_is_the_first_bird_and_strangers_are_none() {
        let layout = Layout::grouped(FORMAT, &[1, 2]);
        let with = |address| {
            let mut bytes = WORKED;
            bytes[14] = address;
            layout.decode(&bytes).map(|record| record.bird)
        };
        assert_eq!(with(0), Some(1));
        assert_eq!(with(2), Some(2));
        assert_eq!(with(3), None);
        // Behind an Extended Range Controller at 1, the birds are 2 and 3.
        let erc = Layout::grouped(FORMAT, &[2, 3]);
        assert_eq!(erc.decode(&WORKED), None);
    }

    #[test]
    fn the_longest_record_is_as_long_as_said() {
        let lengths = RecordFormat::ALL.map(|format| {
            let layout = Layout::grouped(format, &[1]).with_buttons();
            layout.record_length()
        });
        assert_eq!(lengths.into_iter().max(), Some(LONGEST_RECORD));
    }

    proptest! {
        #[test]
        fn decode_is_the_inverse_of_encode(
            words in any::<[i16; 12]>(),
            format in 0usize..7,
            bird in 1u32..=14,
            group in any::<bool>(),
            buttons in proptest::option::of(0u8..0x80),
        ) {
            let format = RecordFormat::ALL[format];
            let addresses: Vec<u8> = (1..=14).collect();
            let layout = if group {
                Layout::grouped(format, &addresses)
            } else {
                Layout::standalone(format)
            };
            let layout = if buttons.is_some() { layout.with_buttons() } else { layout };
            let words = words.map(|w| w & !3);
            let record = Record {
                bird: if group { bird } else { 1 },
                words: Words::new(&words[..Coding::of(format).words()]),
                buttons,
            };
            let mut bytes = Vec::new();
            layout.encode(&record, &mut bytes);
            prop_assert_eq!(bytes.len(), layout.record_length());
            prop_assert_eq!(layout.decode(&bytes), Some(record));
        }

        #[test]
        fn no_bytes_make_the_decoder_panic(
            bytes in proptest::collection::vec(any::<u8>(), 0..40),
            format in 0usize..7,
        ) {
            let format = RecordFormat::ALL[format];
            let _ = Layout::grouped(format, &[1]).decode(&bytes);
            let _ = Layout::grouped(format, &[1]).with_buttons().decode(&bytes);
            let _ = Layout::standalone(format).decode(&bytes);
        }
    }
}
