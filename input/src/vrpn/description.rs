//! Descriptions: which number stands for which name on this connection.
//!
//! They are messages of the types −1, for a sender, and −2, for a type. The number is in the
//! header's field for the sender; the payload is a length and the name with a zero behind it.

use super::message::{Header, Stamp, write_message};

/// The type of a message that describes a sender.
pub const SENDER_DESCRIPTION: i32 = -1;

/// The type of a message that describes a type.
pub const TYPE_DESCRIPTION: i32 = -2;

/// The longest name, in bytes without its zero: VRPN keeps names in 100 bytes.
pub const LONGEST_NAME: usize = 99;

/// The name in a description's payload, without its zero; `None` where it is none.
#[must_use]
pub fn decode_name(payload: &[u8]) -> Option<&[u8]> {
    let (length, name) = payload.split_first_chunk::<4>()?;
    let length = usize::try_from(i32::from_be_bytes(*length)).ok()?;
    if length != name.len() {
        return None;
    }
    let name = match name.iter().position(|&byte| byte == 0) {
        Some(end) => &name[..end],
        None => name,
    };
    (1..=LONGEST_NAME).contains(&name.len()).then_some(name)
}

/// Appends to `out` the message that describes `number` as `name`: a sender or a type, by `kind`.
///
/// A name that is too long is cut.
pub fn write_description(kind: i32, number: i32, name: &[u8], out: &mut Vec<u8>) {
    let name = &name[..name.len().min(LONGEST_NAME)];
    let header = Header {
        payload: 0,
        stamp: Stamp::default(),
        sender: number,
        kind,
        number: 0,
    };
    let payload = |out: &mut Vec<u8>| {
        let length = i32::try_from(name.len() + 1).unwrap_or(i32::MAX);
        out.extend_from_slice(&length.to_be_bytes());
        out.extend_from_slice(name);
        out.push(0);
    };
    write_message(&header, payload, out);
}

#[cfg(test)]
mod tests {
    use super::super::message::HEADER_LENGTH;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_description_is_as_the_real_program_sends_it() {
        let mut bytes = Vec::new();
        write_description(SENDER_DESCRIPTION, 3, b"Tracker0", &mut bytes);
        // 24 and 4 and 8 and a zero, padded to 40.
        assert_eq!(bytes.len(), 40);
        assert_eq!(bytes[..4], [0, 0, 0, 37]);
        assert_eq!(bytes[12..20], [0, 0, 0, 3, 255, 255, 255, 255]);
        assert_eq!(bytes[24..], *b"\0\0\0\x09Tracker0\0\0\0\0");
    }

    #[test]
    fn what_is_no_name_is_none() {
        for payload in [
            &b""[..],
            b"\0\0\0",
            b"\0\0\0\0",
            b"\0\0\0\x01\0",
            b"\0\0\0\x09abc\0",
            b"\xff\xff\xff\xffabc",
            b"\x7f\xff\xff\xff",
        ] {
            assert_eq!(decode_name(payload), None, "{payload:?}");
        }
        let mut long = 101i32.to_be_bytes().to_vec();
        long.extend([b'a'; 100]);
        long.push(0);
        assert_eq!(decode_name(&long), None);
        assert_eq!(decode_name(b"\0\0\0\x03abc"), Some(&b"abc"[..]));
    }

    proptest! {
        #[test]
        fn a_name_comes_back_as_it_was(number: i32, name in "[^\0]{1,30}") {
            let mut bytes = Vec::new();
            write_description(TYPE_DESCRIPTION, number, name.as_bytes(), &mut bytes);
            let (head, rest) = bytes.split_first_chunk::<HEADER_LENGTH>().unwrap();
            let header = Header::decode(head).unwrap();
            prop_assert_eq!((header.sender, header.kind), (number, TYPE_DESCRIPTION));
            let cut = &name.as_bytes()[..name.len().min(LONGEST_NAME)];
            prop_assert_eq!(decode_name(&rest[..header.payload]), Some(cut));
        }
    }
}
