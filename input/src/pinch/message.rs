//! Messages of the box: marks, fingers as bits, and timestamps.

use super::groups::ContactGroups;
use crate::Fingers;

/// Begins a message of contacts.
pub(super) const CONTACTS: u8 = 0x80;
/// Begins a message of contacts with a timestamp.
pub(super) const TIMED_CONTACTS: u8 = 0x81;
/// Begins a text.
pub(super) const TEXT: u8 = 0x82;
/// Ends any message.
pub(super) const END: u8 = 0x8F;
/// Set in marks only.
pub(super) const MARK: u8 = 0x80;

/// What the gloves' messages are like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MessageFormat {
    /// Whether contacts come with timestamps. A message of the other kind is refused, as a turned
    /// bit would make it one: a timestamp would then be taken for fingers.
    pub timestamps: bool,
    /// Whether the gloves have contacts in the palms, whose bits are passed over; otherwise they
    /// are refused.
    pub palms: bool,
}

/// All contacts of both hands at a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactMessage {
    /// Which fingers are joined.
    pub groups: ContactGroups,
    /// The timer's ticks since the message before, 0 to 16383, where they were asked for.
    pub ticks: Option<u16>,
}

impl ContactMessage {
    /// Adds its bytes to `out`, from its first mark to its last. Ticks beyond 16383 are told as
    /// that many.
    pub fn encode(&self, out: &mut Vec<u8>) {
        out.push(if self.ticks.is_some() {
            TIMED_CONTACTS
        } else {
            CONTACTS
        });
        for group in self.groups.as_slice() {
            out.extend(group.map(byte_of_fingers));
        }
        if let Some(ticks) = self.ticks {
            let ticks = ticks.min(0x3FFF);
            out.extend([(ticks & 0x7F) as u8, (ticks >> 7) as u8]);
        }
        out.push(END);
    }

    /// How many bytes it has on the line.
    #[must_use]
    pub fn length(&self) -> u32 {
        let timestamp = if self.ticks.is_some() { 2 } else { 0 };
        2 + 2 * self.groups.as_slice().len() as u32 + timestamp
    }

    /// The message with this first mark and these bytes up to its end, or `None` where it is none.
    pub(super) fn decode(format: MessageFormat, mark: u8, body: &[u8]) -> Option<Self> {
        let expected = if format.timestamps {
            TIMED_CONTACTS
        } else {
            CONTACTS
        };
        if mark != expected {
            return None;
        }
        let (pairs, ticks) = if format.timestamps {
            let (pairs, &[low, high]) = body.split_last_chunk::<2>()?;
            (pairs, Some(u16::from(low) | u16::from(high) << 7))
        } else {
            (body, None)
        };
        let (pairs, []) = pairs.as_chunks::<2>() else {
            // A byte is lost, and nobody knows which.
            return None;
        };
        let mut groups = ContactGroups::default();
        for pair in pairs {
            let group = pair.map(fingers_of_byte);
            if format.palms {
                let group = group.map(|fingers| fingers.only(Fingers::ALL));
                // A finger on a palm is a contact, but of no two fingers.
                if group[0].count() + group[1].count() >= 2 {
                    groups.add(group)?;
                }
            } else {
                groups.add(group)?;
            }
        }
        Some(Self { groups, ticks })
    }
}

/// Adds a text's bytes to `out`, from its first mark to its last.
pub fn encode_text(text: &str, out: &mut Vec<u8>) {
    out.push(TEXT);
    out.extend(text.bytes().filter(|&byte| is_text(byte)));
    out.push(END);
}

/// Whether a byte may be in a text. Few bytes of fingers may, and none of them shows.
pub(super) fn is_text(byte: u8) -> bool {
    matches!(byte, b' '..=b'~' | b'\t' | b'\r' | b'\n')
}

/// On the line bit 4 is the thumb and bit 0 the little finger. Bits that are no finger's come out
/// as no finger's.
fn fingers_of_byte(byte: u8) -> Fingers {
    Fingers(byte.reverse_bits() >> 3 | byte & 0xE0)
}

fn byte_of_fingers(fingers: Fingers) -> u8 {
    fingers.0.reverse_bits() >> 3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fingers_have_their_own_bits_on_the_line() {
        let bits = [0x10, 0x08, 0x04, 0x02, 0x01];
        for (finger, bit) in bits.into_iter().enumerate() {
            assert_eq!(fingers_of_byte(bit), Fingers::number(finger));
            assert_eq!(byte_of_fingers(Fingers::number(finger)), bit);
        }
        for byte in 0..0x80 {
            let fingers = fingers_of_byte(byte);
            assert_eq!(Fingers::ALL.contains(fingers), byte < 0x20, "{byte:02X}");
        }
    }
}
