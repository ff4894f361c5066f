//! The decoder: from a stream of bytes, some of them lost, to whole records.
//!
//! Every byte's phase bit is checked. A mark inside a record drops what came before it and starts
//! a new one there, so that a lost byte costs one record of one bird.

use super::record::{LONGEST_RECORD, Layout, PHASE, Record};

/// Finds records in a stream of bytes. No port, no clock.
#[derive(Clone, Debug)]
pub struct Decoder {
    layout: Layout,
    bytes: [u8; LONGEST_RECORD],
    filled: usize,
    counts: DecoderCounts,
}

/// What a decoder has seen since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecoderCounts {
    /// Whole records.
    pub records: u64,
    /// Bytes that belonged to no whole record.
    pub stray_bytes: u64,
    /// Records cut short by the next one's mark.
    pub cut_records: u64,
    /// Whole records under an address that nobody has.
    pub foreign_records: u64,
}

impl Decoder {
    /// A decoder that waits for the first mark.
    #[must_use]
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            bytes: [0; LONGEST_RECORD],
            filled: 0,
            counts: DecoderCounts::default(),
        }
    }

    /// Takes the next byte; gives the record that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Record> {
        if byte & PHASE != 0 {
            if self.filled > 0 {
                self.counts.cut_records += 1;
                self.counts.stray_bytes += self.filled as u64;
            }
            self.filled = 0;
        } else if self.filled == 0 {
            self.counts.stray_bytes += 1;
            return None;
        }
        self.bytes[self.filled] = byte;
        self.filled += 1;
        if self.filled < self.layout.record_length() {
            return None;
        }
        self.filled = 0;
        let record = self
            .layout
            .decode(&self.bytes[..self.layout.record_length()]);
        match record {
            Some(_) => self.counts.records += 1,
            None => self.counts.foreign_records += 1,
        }
        record
    }

    /// Forgets a record begun, as after a restart of the device.
    pub fn restart(&mut self) {
        self.filled = 0;
    }

    /// What it has seen.
    #[must_use]
    pub fn counts(&self) -> DecoderCounts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flock::record::Words;
    use sandtable_config::RecordFormat;

    const FORMAT: RecordFormat = RecordFormat::PositionQuaternion;

    /// A stream of `cycles` records of each bird, every one different from all others.
    fn sent(birds: u32, cycles: i16) -> (Layout, Vec<Record>, Vec<u8>) {
        let addresses: Vec<u8> = (1..=4).take(birds as usize).collect();
        let layout = if birds == 0 {
            Layout::standalone(FORMAT)
        } else {
            Layout::grouped(FORMAT, &addresses)
        };
        let mut records = Vec::new();
        let mut bytes = Vec::new();
        for cycle in 0..cycles {
            for bird in 1..=birds.max(1) {
                let seed = i32::from(cycle) * 911 + bird as i32 * 5381;
                let word = |i: i32| ((seed.wrapping_mul(7919 + 2 * i) % 65536) as i16) & !3;
                let words = Words::new(&[1, 2, 3, 4, 5, 6, 7].map(word));
                let record = Record {
                    bird,
                    words,
                    buttons: None,
                };
                layout.encode(&record, &mut bytes);
                records.push(record);
            }
        }
        (layout, records, bytes)
    }

    fn decoded(layout: &Layout, bytes: &[u8]) -> Vec<Record> {
        let mut decoder = Decoder::new(layout.clone());
        bytes.iter().filter_map(|&b| decoder.push(b)).collect()
    }

    /// Every record got was sent, in the order sent, and at most `lost` are missing, all of them
    /// within two records of the damage.
    fn assert_only_sent(sent: &[Record], got: &[Record], damaged: usize, lost: usize) {
        assert!(got.len() + lost >= sent.len(), "lost more than {lost}");
        let mut rest = sent.iter().enumerate();
        for record in got {
            let (index, _) = rest
                .find(|(_, s)| *s == record)
                .expect("a record came out that was not sent, or out of order");
            assert!(index < sent.len());
        }
        for (index, record) in sent.iter().enumerate() {
            if index < damaged || index >= damaged + 2 {
                assert!(got.contains(record), "record {index}, damage in {damaged}");
            }
        }
    }

    #[test]
    fn a_whole_stream_comes_out_as_sent() {
        for birds in 0..=4 {
            let (layout, records, bytes) = sent(birds, 20);
            assert_eq!(decoded(&layout, &bytes), records);
        }
    }

    #[test]
    fn flock_every_byte_lost_or_cut_off_lets_nothing_wrong_out() {
        for birds in 0..=4 {
            let (layout, records, bytes) = sent(birds, 8);
            for lost in 0..bytes.len() {
                let mut cut = bytes.clone();
                cut.remove(lost);
                let damaged = lost / layout.record_length();
                assert_only_sent(&records, &decoded(&layout, &cut), damaged, 1);
                // A stream joined in its middle, too.
                let joined = decoded(&layout, &bytes[lost..]);
                assert!(joined.iter().all(|record| records.contains(record)));
                assert!(joined.len() + 1 >= records.len() - damaged);
            }
        }
    }

    #[test]
    fn flock_every_phase_bit_turned_lets_nothing_wrong_out() {
        for birds in 0..=4 {
            let (layout, records, bytes) = sent(birds, 8);
            for turned in 0..bytes.len() {
                let mut bad = bytes.clone();
                bad[turned] ^= PHASE;
                let damaged = turned / layout.record_length();
                assert_only_sent(&records, &decoded(&layout, &bad), damaged, 1);
            }
        }
    }

    #[test]
    fn every_run_of_bytes_lost_within_a_record_lets_nothing_wrong_out() {
        // A run that takes a mark may join two records; the gate is against that.
        let (layout, records, bytes) = sent(2, 8);
        for from in 0..bytes.len() {
            for count in 2..=15 - from % 15 {
                let mut cut = bytes.clone();
                cut.drain(from..from + count);
                for record in decoded(&layout, &cut) {
                    assert!(records.contains(&record), "{count} lost from {from}");
                }
            }
        }
    }

    #[test]
    fn what_was_dropped_is_counted() {
        let (layout, _, bytes) = sent(2, 2);
        let mut decoder = Decoder::new(layout);
        for &byte in bytes[3..].iter() {
            decoder.push(byte);
        }
        let counts = decoder.counts();
        assert_eq!((counts.records, counts.stray_bytes), (3, 12));
        decoder.push(0x81);
        decoder.push(0x82);
        assert_eq!(decoder.counts().cut_records, 1);
    }
}
