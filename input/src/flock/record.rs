//! Records: the bytes of one bird's measurement, and the words in them.
//!
//! A word is 16 bits of two's complement of which the line carries the upper 14, seven a byte, low
//! half first. Bit 7 is the phase bit: set in a record's first byte and in no other. Nothing here
//! knows units, ports or times.

/// The most bytes that a position/quaternion record has: seven words and the address.
pub const LONGEST_RECORD: usize = 15;

/// The phase bit, set in a record's first byte only.
pub(crate) const PHASE: u8 = 0x80;

/// The words of a position/quaternion record, as the line carries them: the low two bits are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Words {
    /// x, y, z as shares of the full scale, 32768 to one.
    pub position: [i16; 3],
    /// The quaternion, scalar first, 32768 to one.
    pub quaternion: [i16; 4],
}

/// One bird's measurement as the line carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// The bird, from 1, in the order of the addresses on the line.
    pub bird: u32,
    /// Position and attitude.
    pub words: Words,
}

/// Which birds share the line, and so what a record looks like.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    addresses: Vec<u8>,
}

impl Layout {
    /// Group mode: each record ends in its bird's address, which is one of `addresses`.
    #[must_use]
    pub fn grouped(addresses: &[u8]) -> Self {
        Self {
            addresses: addresses.to_vec(),
        }
    }

    /// One bird alone on the line: no address.
    #[must_use]
    pub fn standalone() -> Self {
        Self {
            addresses: Vec::new(),
        }
    }

    /// Bytes in a record.
    #[must_use]
    pub fn record_length(&self) -> usize {
        if self.addresses.is_empty() { 14 } else { 15 }
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
        let mut words = [0; 7];
        for (word, pair) in words.iter_mut().zip(bytes.chunks_exact(2)) {
            *word = word_from_bytes([pair[0], pair[1]]);
        }
        let [x, y, z, q0, q1, q2, q3] = words;
        Some(Record {
            bird: match bytes.get(14) {
                None => 1,
                Some(&address) => self.bird(address)?,
            },
            words: Words {
                position: [x, y, z],
                quaternion: [q0, q1, q2, q3],
            },
        })
    }

    /// Appends the record's bytes to `out`; the inverse of [`Layout::decode`].
    ///
    /// A bird that is not on the line appends nothing.
    pub fn encode(&self, record: &Record, out: &mut Vec<u8>) {
        let index = (record.bird as usize).wrapping_sub(1);
        if index >= self.birds() {
            return;
        }
        let Words {
            position: [x, y, z],
            quaternion: [q0, q1, q2, q3],
        } = record.words;
        encode_words(&[x, y, z, q0, q1, q2, q3], out);
        out.extend(self.addresses.get(index));
    }

    fn bird(&self, address: u8) -> Option<u32> {
        // Some units send 0 where they mean the first address.
        let meant = if address == 0 { 1 } else { address };
        let index = self.addresses.iter().position(|&known| known == meant)?;
        u32::try_from(index + 1).ok()
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

    /// The bytes of the worked position/quaternion record: bird 1, group mode.
    const WORKED: [u8; 15] = [
        0xAA, 0x15, 0x2A, 0x05, 0x0E, 0x77, 0x73, 0x3C, 0x47, 0x7D, 0x71, 0x73, 0x57, 0x70, 0x01,
    ];

    #[test]
    fn the_worked_record_has_the_worked_words() {
        let layout = Layout::grouped(&[1, 2]);
        let record = layout.decode(&WORKED).unwrap();
        assert_eq!(record.bird, 1);
        assert_eq!(record.words.position, [10920, 2728, -4552]);
        assert_eq!(record.words.quaternion, [31180, -1252, -6204, -7844]);
        let mut bytes = Vec::new();
        layout.encode(&record, &mut bytes);
        assert_eq!(bytes, WORKED);
    }

    #[test]
    fn the_zero_pose_has_the_worked_bytes() {
        let words = Words {
            position: [0; 3],
            quaternion: [word_from_share(1.0), 0, 0, 0],
        };
        let mut bytes = Vec::new();
        Layout::standalone().encode(&Record { bird: 1, words }, &mut bytes);
        assert_eq!(bytes, [0x80, 0, 0, 0, 0, 0, 0x7F, 0x3F, 0, 0, 0, 0, 0, 0]);
        let back = Layout::standalone().decode(&bytes).unwrap();
        assert_eq!(back.words.quaternion[0], 32764);
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
        let layout = Layout::grouped(&[1, 2]);
        let with = |address| {
            let mut bytes = WORKED;
            bytes[14] = address;
            layout.decode(&bytes).map(|record| record.bird)
        };
        assert_eq!(with(0), Some(1));
        assert_eq!(with(2), Some(2));
        assert_eq!(with(3), None);
        // Behind an Extended Range Controller at 1, the birds are 2 and 3.
        let erc = Layout::grouped(&[2, 3]);
        assert_eq!(erc.decode(&WORKED), None);
    }

    proptest! {
        #[test]
        fn decode_is_the_inverse_of_encode(
            position in any::<[i16; 3]>(),
            quaternion in any::<[i16; 4]>(),
            bird in 1u32..=4,
            group in any::<bool>(),
        ) {
            let layout = if group {
                Layout::grouped(&[1, 2, 3, 4])
            } else {
                Layout::standalone()
            };
            let record = Record {
                bird: if group { bird } else { 1 },
                words: Words {
                    position: position.map(|w| w & !3),
                    quaternion: quaternion.map(|w| w & !3),
                },
            };
            let mut bytes = Vec::new();
            layout.encode(&record, &mut bytes);
            prop_assert_eq!(bytes.len(), layout.record_length());
            prop_assert_eq!(layout.decode(&bytes), Some(record));
        }

        #[test]
        fn no_bytes_make_the_decoder_panic(bytes in proptest::collection::vec(any::<u8>(), 0..40)) {
            let _ = Layout::grouped(&[1]).decode(&bytes);
            let _ = Layout::standalone().decode(&bytes);
        }
    }
}
