//! Reports: 64 bytes that begin with 16 values.

use sandtable_config::{ByteOrder, DataGlove};

/// How many bytes a report has; it has no id.
pub const REPORT_LENGTH: usize = 64;

/// How many values it begins with. What follows them is not known.
pub const VALUES: usize = 16;

/// A report's raw values, 0 to 4095, or `None` for what is no report: a length that is none's, or
/// a value of more than 12 bits where `positions` has a sensor.
#[must_use]
pub fn report_values(
    report: &[u8],
    byte_order: ByteOrder,
    positions: &[usize],
) -> Option<[u16; VALUES]> {
    let report: &[u8; REPORT_LENGTH] = report.try_into().ok()?;
    let mut values = [0; VALUES];
    let (pairs, _) = report.as_chunks::<2>();
    for (value, pair) in values.iter_mut().zip(pairs) {
        *value = match byte_order {
            ByteOrder::BigEndian => u16::from_be_bytes(*pair),
            ByteOrder::LittleEndian => u16::from_le_bytes(*pair),
        };
    }
    let plausible = |position: &usize| {
        let value = values.get(*position);
        value.is_some_and(|value| f64::from(*value) <= DataGlove::HIGHEST)
    };
    positions.iter().all(plausible).then_some(values)
}

/// The report with these values, as a glove would send it.
#[must_use]
pub fn encode_report(values: &[u16; VALUES], byte_order: ByteOrder) -> [u8; REPORT_LENGTH] {
    let mut report = [0; REPORT_LENGTH];
    for (pair, value) in report.chunks_exact_mut(2).zip(values) {
        pair.copy_from_slice(&match byte_order {
            ByteOrder::BigEndian => value.to_be_bytes(),
            ByteOrder::LittleEndian => value.to_le_bytes(),
        });
    }
    report
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FIVE: [usize; 5] = [0, 3, 6, 9, 12];

    /// `0B B8 00 00 00 00 01 F4 ...`, a right glove of five sensors.
    fn worked() -> [u8; REPORT_LENGTH] {
        let mut report = [0; REPORT_LENGTH];
        for (at, bytes) in [
            (0, [0x0B, 0xB8]),
            (6, [0x01, 0xF4]),
            (12, [0x0C, 0xE4]),
            (18, [0x0D, 0x48]),
            (24, [0x0D, 0xAC]),
        ] {
            report[at..at + 2].copy_from_slice(&bytes);
        }
        report
    }

    #[test]
    fn the_worked_report_has_its_values() {
        let values = report_values(&worked(), ByteOrder::BigEndian, &FIVE).unwrap();
        let five = FIVE.map(|position| values[position]);
        assert_eq!(five, [3000, 500, 3300, 3400, 3500]);
        assert_eq!(encode_report(&values, ByteOrder::BigEndian), worked());
    }

    #[test]
    fn what_is_no_report_is_refused() {
        let worked = worked();
        for length in (0..REPORT_LENGTH).chain([65, 128]) {
            let mut report = worked.to_vec();
            report.resize(length, 0);
            assert_eq!(report_values(&report, ByteOrder::BigEndian, &FIVE), None);
        }
        // The other byte order makes values of more than 12 bits of these.
        assert_eq!(report_values(&worked, ByteOrder::LittleEndian, &FIVE), None);
        // A value that no sensor has may be anything.
        let mut odd = worked;
        odd[2] = 0xFF;
        assert!(report_values(&odd, ByteOrder::BigEndian, &FIVE).is_some());
        assert_eq!(report_values(&odd, ByteOrder::BigEndian, &[0, 1]), None);
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded_again(
            values in proptest::array::uniform16(0u16..=4095),
            big: bool,
        ) {
            let order = if big { ByteOrder::BigEndian } else { ByteOrder::LittleEndian };
            let all: Vec<usize> = (0..VALUES).collect();
            let report = encode_report(&values, order);
            prop_assert_eq!(report_values(&report, order, &all), Some(values));
        }

        #[test]
        fn any_bytes_decode_to_something(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = report_values(&bytes, ByteOrder::BigEndian, &FIVE);
            let _ = report_values(&bytes, ByteOrder::LittleEndian, &[99]);
        }
    }
}
