//! Whether a JPEG picture is whole: its decoder leaves rows grey that are missing, and says nothing.

/// Whether the marker that ends a picture stands where its segments and scans lead.
pub(super) fn is_whole(bytes: &[u8]) -> bool {
    let mut at = 0;
    while let Some(&[byte, marker]) = bytes.get(at..at + 2) {
        at += match (byte, marker) {
            // Within a scan: a byte of it, padding, or a place to start anew.
            (..0xff, _) | (0xff, 0xff) => 1,
            (0xff, 0x00 | 0x01 | 0xd0..=0xd8) => 2,
            // Whatever follows is another picture's, or padding.
            (0xff, 0xd9) => return true,
            // A segment says its length; it may hold a whole picture for itself.
            (0xff, _) => match bytes.get(at + 2..at + 4) {
                Some(&[high, low]) => 2 + usize::from(u16::from_be_bytes([high, low])),
                _ => return false,
            },
        };
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture's start, a segment with a thumbnail in it, a scan with a restart, and the end.
    const WHOLE: &[u8] = b"\xff\xd8\xff\xe1\0\x06\xff\xd8\xff\xd9\
        \xff\xda\0\x02\x12\xff\0\xff\xd0\x34\xff\xff\xd9";

    #[test]
    fn a_picture_is_whole_up_to_its_own_end_and_no_shorter() {
        assert!(is_whole(WHOLE));
        for length in 0..WHOLE.len() {
            assert!(!is_whole(&WHOLE[..length]), "the first {length} bytes");
        }
        let followed = [WHOLE, b"\0\0\xff\xd8"].concat();
        assert!(is_whole(&followed));
    }

    #[test]
    fn a_segment_that_leads_beyond_the_file_is_none() {
        assert!(!is_whole(b"\xff\xd8\xff\xe1\xff\xff\xff\xd9"));
        assert!(!is_whole(b"\xff\xd8\xff\xe1\0\0"));
    }
}
