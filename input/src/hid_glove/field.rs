//! Fields: whole numbers at any bit of a report.

use sandtable_config::{ByteOrder, HidField};

/// The field's value in a report, or `None` where the report ends before it does.
///
/// As HID packs them, bit 0 of a byte comes first and a field goes on in the next byte; one with
/// its high byte first is of whole bytes.
#[must_use]
pub fn field_value(field: &HidField, report: &[u8]) -> Option<i64> {
    let bytes = report.get(field.byte..field.end())?;
    let joined = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
    // At most five bytes: 32 bits that begin at bit 7.
    let number = match field.byte_order {
        ByteOrder::BigEndian => bytes.iter().fold(0, joined),
        ByteOrder::LittleEndian => bytes.iter().rev().fold(0, joined),
    };
    let values = 1u64.checked_shl(field.bits)?;
    let number = number.checked_shr(field.bit)? & (values - 1);
    let negative = field.signed && number >= values / 2;
    let number = i64::try_from(number).ok()?;
    Some(if negative {
        number - i64::try_from(values).ok()?
    } else {
        number
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn field(byte: usize, bit: u32, bits: u32) -> HidField {
        HidField {
            byte,
            bit,
            bits,
            signed: false,
            byte_order: ByteOrder::LittleEndian,
        }
    }

    #[test]
    fn fields_are_found_at_any_bit() {
        let report = [0x12, 0x34, 0x56, 0x78, 0x9A];
        assert_eq!(field_value(&field(1, 0, 8), &report), Some(0x34));
        assert_eq!(field_value(&field(1, 0, 16), &report), Some(0x5634));
        assert_eq!(field_value(&field(1, 4, 12), &report), Some(0x563));
        assert_eq!(field_value(&field(0, 7, 1), &report), Some(0));
        assert_eq!(field_value(&field(2, 6, 2), &report), Some(1));
        let big = HidField {
            byte_order: ByteOrder::BigEndian,
            ..field(1, 0, 16)
        };
        assert_eq!(field_value(&big, &report), Some(0x3456));
        let signed = HidField {
            signed: true,
            ..field(4, 0, 8)
        };
        assert_eq!(field_value(&signed, &report), Some(0x9A - 0x100));
        assert_eq!(field_value(&field(4, 0, 16), &report), None);
        assert_eq!(field_value(&field(9, 0, 8), &report), None);
    }

    proptest! {
        #[test]
        fn a_value_put_at_any_bits_is_read_there(
            byte in 0usize..20,
            bit in 0u32..8,
            bits in 1u32..=32,
            signed: bool,
            around: bool,
            random: u64,
        ) {
            let field = HidField { signed, ..field(byte, bit, bits) };
            let value = random & ((1 << bits) - 1);
            let mut report = [if around { 0xFF } else { 0 }; 32];
            for n in 0..bits {
                let at = byte * 8 + (bit + n) as usize;
                let set = (value >> n & 1) as u8;
                report[at / 8] = report[at / 8] & !(1 << (at % 8)) | set << (at % 8);
            }
            let read = field_value(&field, &report).unwrap();
            prop_assert_eq!(read as u64 & ((1 << bits) - 1), value);
            let [lowest, highest] = field.limits();
            prop_assert!((lowest..=highest).contains(&(read as f64)));
        }

        #[test]
        fn any_report_has_a_value_or_none(
            report in prop::collection::vec(any::<u8>(), 0..40),
            byte in 0usize..40,
            bit in 0u32..8,
            bits in 1u32..=32,
            signed: bool,
            big: bool,
        ) {
            let byte_order = if big { ByteOrder::BigEndian } else { ByteOrder::LittleEndian };
            let field = HidField { byte, bit, bits, signed, byte_order };
            let value = field_value(&field, &report);
            prop_assert_eq!(value.is_some(), field.end() <= report.len());
        }
    }
}
