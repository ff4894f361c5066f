//! Messages of PINCH gloves: what is sent is decoded again, and what is none is damage.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use proptest::prelude::*;
use sandtable_input::Fingers;
use sandtable_input::pinch::{
    ContactGroups, ContactMessage, Decoded, Decoder, DecoderCounts, LONGEST_MESSAGE, MessageFormat,
    encode_text,
};

const PLAIN: MessageFormat = MessageFormat {
    timestamps: false,
    palms: false,
};
const TIMED: MessageFormat = MessageFormat {
    timestamps: true,
    ..PLAIN
};
const PALMS: MessageFormat = MessageFormat {
    palms: true,
    ..PLAIN
};

/// What comes out, texts as they are and damage as `None`.
#[derive(Clone, Debug, PartialEq)]
enum Out {
    Contacts(ContactMessage),
    Text(String),
    Damage,
}

fn decoded(format: MessageFormat, bytes: &[u8]) -> Vec<Out> {
    let mut decoder = Decoder::new(format);
    let mut out = Vec::new();
    for &byte in bytes {
        out.extend(decoder.push(byte).map(|decoded| match decoded {
            Decoded::Contacts(message) => Out::Contacts(message),
            Decoded::Text(text) => Out::Text(text.to_owned()),
            Decoded::Damage => Out::Damage,
        }));
    }
    out
}

fn message(groups: &[[Fingers; 2]], ticks: Option<u16>) -> Out {
    let groups = ContactGroups::new(groups).unwrap();
    Out::Contacts(ContactMessage { groups, ticks })
}

#[test]
fn every_worked_example_is_what_it_says() {
    let none = Fingers(0);
    let (thumb, index, middle) = (Fingers::THUMB, Fingers::INDEX, Fingers::MIDDLE);
    assert_eq!(
        decoded(PLAIN, &[0x80, 0x18, 0x00, 0x8F]),
        [message(&[[thumb.with(index), none]], None)]
    );
    assert_eq!(
        decoded(PLAIN, &[0x80, 0x00, 0x14, 0x11, 0x00, 0x8F]),
        [message(
            &[
                [none, thumb.with(middle)],
                [thumb.with(Fingers::LITTLE), none]
            ],
            None
        )]
    );
    assert_eq!(
        decoded(PLAIN, &[0x80, 0x18, 0x08, 0x8F]),
        [message(&[[thumb.with(index), index]], None)]
    );
    assert_eq!(
        decoded(TIMED, &[0x81, 0x10, 0x10, 0x58, 0x02, 0x8F]),
        [message(&[[thumb, thumb]], Some(344))]
    );
    assert_eq!(decoded(PLAIN, &[0x80, 0x8F]), [message(&[], None)]);
    assert_eq!(
        decoded(PLAIN, &[0x82, 0x30, 0x8F, 0x82, 0x3F, 0x8F]),
        [Out::Text("0".into()), Out::Text("?".into())]
    );
}

#[test]
fn what_is_no_message_is_damage_and_counted() {
    let damage = |format, bytes: &[u8]| {
        assert_eq!(decoded(format, bytes), [Out::Damage], "{bytes:02X?}");
    };
    // An odd count, a finger alone, one finger in two groups, a bit that is no finger's.
    damage(PLAIN, &[0x80, 0x18, 0x8F]);
    damage(PLAIN, &[0x80, 0x10, 0x00, 0x8F]);
    damage(PLAIN, &[0x80, 0x18, 0x00, 0x14, 0x00, 0x8F]);
    damage(PLAIN, &[0x80, 0x38, 0x00, 0x8F]);
    // A message of the other kind, and one without its timestamp.
    damage(PLAIN, &[0x81, 0x10, 0x10, 0x05, 0x00, 0x8F]);
    damage(TIMED, &[0x80, 0x18, 0x00, 0x8F]);
    damage(TIMED, &[0x81, 0x8F]);
    // A text without any.
    damage(PLAIN, &[0x82, 0x8F]);
    damage(PLAIN, &[0x82, 0x20, 0x0D, 0x8F]);
    // Bytes outside of any message, and marks that are none.
    damage(PLAIN, &[0x18]);
    damage(PLAIN, &[0x8F]);
    damage(PLAIN, &[0x83]);
    damage(PLAIN, &[0x80, 0x18, 0xFF]);
    damage(PLAIN, &[0x82, 0x30, 0x10]);
    let mut decoder = Decoder::new(PLAIN);
    for byte in [
        0x55, 0x80, 0x18, 0x80, 0x18, 0x8F, 0x80, 0x18, 0x00, 0x8F, 0x82, 0x01,
    ] {
        decoder.push(byte);
    }
    let expected = DecoderCounts {
        messages: 1,
        stray_bytes: 1 + 2 + 2,
        cut_messages: 1,
        implausible: 1,
    };
    assert_eq!(decoder.counts(), expected);
}

#[test]
fn palms_are_passed_over_where_there_are_any() {
    // Thumb and index on a palm's contact, and a middle finger on the other one.
    let bytes = [0x80, 0x38, 0x00, 0x20, 0x04, 0x8F];
    let thumb_index = Fingers::THUMB.with(Fingers::INDEX);
    assert_eq!(
        decoded(PALMS, &bytes),
        [message(&[[thumb_index, Fingers(0)]], None)]
    );
    assert_eq!(decoded(PLAIN, &bytes), [Out::Damage]);
}

#[test]
fn an_endless_message_is_damage() {
    let mut bytes = vec![0x80];
    bytes.extend([0x18; 3 * LONGEST_MESSAGE]);
    bytes.extend([0x80, 0x8F]);
    let out = decoded(PLAIN, &bytes);
    assert!(out.len() > 1);
    let (last, damage) = out.split_last().unwrap();
    assert_eq!(*last, message(&[], None));
    assert!(damage.iter().all(|out| *out == Out::Damage));
}

/// Any groups that there can be: each finger is given to one of five groups or to none.
fn groups() -> impl Strategy<Value = ContactGroups> {
    proptest::array::uniform10(0..8usize).prop_map(|group_of| {
        let mut groups = [[Fingers(0); 2]; 5];
        for (finger, group) in group_of.into_iter().enumerate() {
            if let Some(group) = groups.get_mut(group) {
                let hand = &mut group[finger / 5];
                *hand = hand.with(Fingers::number(finger % 5));
            }
        }
        let joined = |group: &&[Fingers; 2]| group[0].count() + group[1].count() >= 2;
        let groups: Vec<_> = groups.iter().filter(joined).copied().collect();
        ContactGroups::new(&groups).unwrap()
    })
}

proptest! {
    #[test]
    fn what_is_encoded_is_decoded_again(
        sent in prop::collection::vec((groups(), 0u16..=0x3FFF), 1..20),
        timestamps: bool,
        palms: bool,
    ) {
        let mut bytes = Vec::new();
        let mut expected = Vec::new();
        for (groups, ticks) in sent {
            let message = ContactMessage { groups, ticks: timestamps.then_some(ticks) };
            message.encode(&mut bytes);
            encode_text("R NO GLOVE", &mut bytes);
            expected.extend([Out::Contacts(message), Out::Text("R NO GLOVE".into())]);
        }
        prop_assert_eq!(decoded(MessageFormat { timestamps, palms }, &bytes), expected);
    }

    #[test]
    fn any_bytes_decode_to_something(
        bytes in prop::collection::vec(
            prop_oneof![any::<u8>(), 0x80..=0x82u8, Just(0x8F), 0..=0x1Fu8],
            0..2000,
        ),
        timestamps: bool,
        palms: bool,
    ) {
        let format = MessageFormat { timestamps, palms };
        let mut decoder = Decoder::new(format);
        for byte in &bytes {
            decoder.push(*byte);
        }
        // The next whole message is found, whatever was before.
        let message = ContactMessage {
            groups: ContactGroups::default(),
            ticks: timestamps.then_some(0),
        };
        let mut next = Vec::new();
        message.encode(&mut next);
        let (last, first) = next.split_last().unwrap();
        for byte in first {
            decoder.push(*byte);
        }
        prop_assert_eq!(decoder.push(*last), Some(Decoded::Contacts(message)));
    }
}
