//! PINCH gloves on a bad line: whatever single byte is lost or loses its mark, no contact is told
//! that was not there, fingers are let go in time, and the next message is told as it was.
#![expect(
    clippy::unwrap_used,
    reason = "a test's helpers may fail as its body may"
)]

use proptest::prelude::*;
use sandtable_config::{Device, Pinch, Rig};
use sandtable_input::pinch::{ContactGroups, ContactMessage, Motion, PinchStream, encode_text};
use sandtable_input::{Contacts, Fingers, HandSample, Sample, Stream};
use sandtable_pose::Nanos;
use std::time::Duration;

fn pinch(settings: &str) -> Pinch {
    let text = format!(
        "name = 'p'\n[camera]\n[devices.pinch]\nkind = 'pinch'\nport = '/dev/ttyS0'\n{settings}"
    );
    let mut rig = Rig::parse(&text, "p").unwrap();
    let Some(Device::Pinch(pinch)) = rig.devices.remove("pinch") else {
        panic!("it is a PINCH glove");
    };
    pinch
}

/// A byte on a line of 9600 baud.
fn byte_time() -> Duration {
    Duration::from_secs_f64(10.0 / 9600.0)
}

/// A message as it was sent.
struct Sent {
    begin: Nanos,
    contacts: [Contacts; 2],
    bytes: Vec<u8>,
}

impl Sent {
    fn end(&self) -> Nanos {
        self.begin + byte_time() * u32::try_from(self.bytes.len()).unwrap()
    }
}

/// Hands that play, and then all that makes groups unlike: one to four of them, of fingers of one
/// hand and of both, so that bytes in another's place are another hand's fingers.
fn states() -> Vec<ContactGroups> {
    let mut states: Vec<_> = (0..12)
        .map(|number| Motion::Seeded(3).change(number).unwrap().1)
        .collect();
    let unlike: [&[[u8; 2]]; 6] = [
        &[[0b00011, 0], [0, 0b00101]],
        &[[0b00110, 0], [0b01001, 0]],
        &[[0, 0b11000], [0b00011, 0b00001], [0b00100, 0b00110]],
        &[[0b00001, 0b00010], [0b00010, 0b00001], [0b01100, 0]],
        &[
            [0b00001, 0b10000],
            [0b00010, 0b01000],
            [0b00100, 0b00100],
            [0b01000, 0b00010],
        ],
        &[[0b11111, 0], [0, 0b11111]],
    ];
    states.extend(unlike.map(|groups| {
        let groups: Vec<_> = groups.iter().map(|group| group.map(Fingers)).collect();
        ContactGroups::new(&groups).unwrap()
    }));
    states
}

/// A message of each state, 400 milliseconds and more from one to the next.
fn sent(timestamps: bool) -> Vec<Sent> {
    let interval = |number: usize| Duration::from_millis(400 + 37 * (number as u64 % 5));
    let (mut sent, mut begin) = (Vec::new(), Nanos(1_000_000_000));
    for (number, groups) in states().into_iter().enumerate() {
        let ticks = u16::try_from(interval(number).as_millis()).unwrap();
        begin = begin + interval(number);
        let message = ContactMessage {
            groups,
            ticks: timestamps.then_some(ticks),
        };
        let mut bytes = Vec::new();
        message.encode(&mut bytes);
        sent.push(Sent {
            begin,
            contacts: groups.contacts(),
            bytes,
        });
    }
    sent
}

/// Reads `bytes`, each with the time that it was through, and lets time pass as a driver does.
fn told(stream: &mut PinchStream, bytes: &[(Nanos, u8)], until: Nanos) -> Vec<HandSample> {
    let mut told = Vec::new();
    let mut keep = |sample| match sample {
        Sample::Hand(sample) => told.push(sample),
        other => panic!("{other:?}"),
    };
    for &(end, byte) in bytes {
        while let Some(due) = stream.due().filter(|due| *due < end) {
            stream.push(&[], due, &mut keep);
            assert_ne!(stream.due(), Some(due), "it has been told the time");
        }
        stream.push(&[byte], end, &mut keep);
    }
    stream.push(&[], until, &mut keep);
    told
}

fn timed(sent: &[Sent]) -> Vec<(Nanos, u8)> {
    let bytes = sent.iter().flat_map(|sent| {
        let end = |index: usize| sent.begin + byte_time() * u32::try_from(index + 1).unwrap();
        let bytes = sent.bytes.iter().enumerate();
        bytes.map(move |(index, byte)| (end(index), *byte))
    });
    bytes.collect()
}

/// Whether every finger of `some` touches no other than in `all`.
fn within(some: &Contacts, all: &Contacts) -> bool {
    (0..5).all(|finger| {
        all.own[finger].contains(some.own[finger]) && all.other[finger].contains(some.other[finger])
    })
}

/// What has to hold where message `damaged` was sent and not received as it was.
fn assert_sound(pinch: &Pinch, sent: &[Sent], told: &[HandSample], damaged: usize, what: &str) {
    for sample in told {
        // A message's own bytes may make a sample a few bytes after its begin.
        let before = sent.iter().rev();
        let truth = before
            .clone()
            .find(|sent| sent.begin <= sample.time + byte_time());
        let hand = sample.sensor as usize - 1;
        if let Some(contacts) = sample.hand.contacts {
            let truth = truth.unwrap_or_else(|| panic!("{what}: told before it was sent"));
            assert!(
                within(&contacts, &truth.contacts[hand]),
                "{what}: {sample:?}"
            );
        }
    }
    for (index, sent) in sent
        .iter()
        .enumerate()
        .filter(|(index, _)| *index != damaged)
    {
        for (hand, sensor) in (1..=2).enumerate() {
            let as_sent = told.iter().any(|sample| {
                sample.sensor == sensor
                    && sample.time.since(sent.begin) < byte_time() / 2
                    && sample.hand.contacts == Some(sent.contacts[hand])
            });
            assert!(
                as_sent,
                "{what}: message {index} was not told to hand {sensor}"
            );
        }
    }
    // What was told before the damage is told no longer.
    let damaged = &sent[damaged];
    let latest = damaged.end() + pinch.release_after;
    let let_go = |sample: &&HandSample| sample.time >= damaged.begin && sample.time <= latest;
    assert!(told.iter().filter(let_go).count() >= 2, "{what}");
}

/// Damages each byte in turn; `damage` says what is read in its place.
fn each_byte_damaged(timestamps: bool, damage: impl Fn(u8) -> Vec<u8>) {
    let pinch = pinch(&format!("timestamps = {timestamps}"));
    let sent = sent(timestamps);
    let whole = timed(&sent);
    let until = whole.last().unwrap().0 + Duration::from_secs(1);
    let mut at = 0;
    // The first message is spared: before it nothing is told that would have to be let go.
    for (damaged, message) in sent.iter().enumerate() {
        for _ in 0..message.bytes.len() {
            let (end, byte) = whole[at];
            let mut bytes = whole.clone();
            bytes.splice(at..=at, damage(byte).into_iter().map(|byte| (end, byte)));
            if bytes != whole && damaged > 0 {
                let told = told(&mut PinchStream::new(&pinch), &bytes, until);
                let what = format!("byte {at} ({byte:02X})");
                assert_sound(&pinch, &sent, &told, damaged, &what);
            }
            at += 1;
        }
    }
}

#[test]
fn a_good_line_tells_every_message_when_it_began() {
    for timestamps in [false, true] {
        let pinch = pinch(&format!("timestamps = {timestamps}"));
        let sent = sent(timestamps);
        let told = told(
            &mut PinchStream::new(&pinch),
            &timed(&sent),
            Nanos(u64::MAX),
        );
        assert_eq!(told.len(), 2 * sent.len());
        for (pair, sent) in told.chunks(2).zip(&sent) {
            assert_eq!([pair[0].sensor, pair[1].sensor], [1, 2]);
            assert!(pair[0].time.since(sent.begin) < Duration::from_micros(1));
            let contacts = pair.iter().map(|sample| sample.hand.contacts.unwrap());
            assert!(contacts.eq(sent.contacts));
        }
    }
}

#[test]
fn any_one_byte_may_be_lost() {
    each_byte_damaged(false, |_| Vec::new());
    each_byte_damaged(true, |_| Vec::new());
}

#[test]
fn any_one_byte_may_lose_or_gain_its_mark() {
    each_byte_damaged(false, |byte| vec![byte ^ 0x80]);
    each_byte_damaged(true, |byte| vec![byte ^ 0x80]);
}

#[test]
fn any_one_mark_may_become_another() {
    for mark in [0x80, 0x81, 0x82, 0x8F] {
        let damage = |byte| vec![if byte & 0x80 != 0 { mark } else { byte }];
        each_byte_damaged(false, damage);
        each_byte_damaged(true, damage);
    }
}

#[test]
fn noise_may_stand_between_any_two_bytes() {
    for noise in [0x00, 0x18, 0x3F, 0x7F, 0x83, 0xFF] {
        each_byte_damaged(false, |byte| vec![byte, noise]);
        each_byte_damaged(true, |byte| vec![byte, noise]);
    }
}

#[test]
fn garbage_before_the_first_message_tells_nothing() {
    let pinch = pinch("");
    let sent = sent(false);
    let garbage = b"Login: \x00\x18\x8F\x8F\xFF\x83\x1F\x80\x18\x82\x10";
    let mut bytes: Vec<_> = garbage
        .iter()
        .map(|byte| (Nanos(900_000_000), *byte))
        .collect();
    bytes.extend(timed(&sent));
    let told = told(&mut PinchStream::new(&pinch), &bytes, Nanos(u64::MAX));
    assert_eq!(told.len(), 2 * sent.len());
    assert!(told[0].time >= sent[0].begin);
}

#[test]
fn fingers_are_let_go_when_the_settings_time_is_over_and_not_before() {
    let pinch = pinch("release_after = 0.4");
    let ms = |ms: u64| Nanos(ms * 1_000_000);
    let mut stream = PinchStream::new(&pinch);
    let mut push = |bytes: &[u8], time| {
        let mut times = Vec::new();
        stream.push(bytes, time, &mut |sample| {
            let Sample::Hand(sample) = sample else {
                panic!("{sample:?}");
            };
            times.push((sample.time, sample.hand.contacts.is_some()));
        });
        (times, stream.due())
    };
    // Damage to nothing is nothing.
    assert_eq!(push(&[0x18], ms(10)), (vec![], None));
    let (told, due) = push(&[0x80, 0x18, 0x00, 0x8F], ms(1000));
    assert_eq!((told.len(), due), (2, None));
    // A text is no doubt, whole or not.
    assert_eq!(push(&[0x82, 0x30, 0x8F, 0x82], ms(1100)), (vec![], None));
    // A message that does not end is.
    assert_eq!(push(&[0x80, 0x18], ms(2000)).0, vec![]);
    let due = push(&[], ms(2300)).1.unwrap();
    assert_eq!(due.0 / 1_000_000, 2398);
    assert_eq!(push(&[], due - Duration::from_nanos(1)).0, vec![]);
    assert_eq!(push(&[], ms(2500)), (vec![(due, false); 2], None));
    // The rest of it settles nothing more, and once let go there is nothing to be let go.
    assert!(push(&[0x00], ms(2600)).0.is_empty());
    assert_eq!(push(&[0x7F], ms(9000)), (vec![], None));
    // A whole message in time ends the doubt, however late its begin is seen.
    assert_eq!(push(&[0x80, 0x18, 0x00, 0x8F], ms(9100)).1, None);
    assert!(push(&[0xFF], ms(9200)).1.is_some());
    let (told, due) = push(&[0x80, 0x8F], ms(9500));
    assert_eq!((told.len(), told[0].1, due), (2, true, None));
}

#[test]
fn a_message_read_late_is_dated_by_the_boxs_clock() {
    let pinch = pinch("timestamps = true");
    let mut stream = PinchStream::new(&pinch);
    let mut answers = Vec::new();
    for answer in ["?", "1", "1", "500", "L", "R"] {
        encode_text(answer, &mut answers);
    }
    let mut message = |ticks, arrival_ms: u64| {
        let mut bytes = std::mem::take(&mut answers);
        let groups = ContactGroups::default();
        let ticks = Some(ticks);
        ContactMessage { groups, ticks }.encode(&mut bytes);
        let mut times = Vec::new();
        let arrival = Nanos(arrival_ms * 1_000_000);
        stream.push(&bytes, arrival, &mut |sample| times.push(sample.time()));
        (times[0] + byte_time() * 4).0 / 1_000_000
    };
    assert_eq!(message(0, 1000), 1000);
    // 400 ticks of half a millisecond: read 60 ms late.
    assert_eq!(message(400, 1260), 1200);
    assert_eq!(message(400, 1400), 1400);
    // What cannot be is not believed: later than it arrived, or far too late.
    assert_eq!(message(400, 1500), 1500);
    assert_eq!(message(400, 1900), 1900);
    // A counter that has run over tells nothing.
    assert_eq!(message(0x3FFF, 10_100), 10_100);
}

#[test]
fn what_is_restarted_has_told_nothing_yet() {
    let pinch = pinch("");
    let mut stream = PinchStream::new(&pinch);
    stream.push(&[0x80, 0x18, 0x00, 0x8F, 0x80], Nanos(0), &mut |_| {});
    assert!(stream.due().is_some());
    stream.restart();
    assert_eq!(stream.due(), None);
    let nothing = &mut |sample| panic!("{sample:?}");
    stream.push(&[0x18, 0x00, 0x8F], Nanos(10_000_000_000), nothing);
}

#[test]
fn what_no_check_of_bytes_can_see() {
    let pinch = pinch("");
    let contacts = |bytes: &[u8]| {
        let mut hands = Vec::new();
        PinchStream::new(&pinch).push(bytes, Nanos(0), &mut |sample| {
            if let Sample::Hand(sample) = sample {
                hands.push(sample.hand.contacts.unwrap());
            }
        });
        hands
    };
    // A bit of a finger turned is another finger.
    assert_ne!(
        contacts(&[0x80, 0x18, 0x00, 0x8F]),
        contacts(&[0x80, 0x14, 0x00, 0x8F])
    );
    // Two bytes lost of `80 18 00 00 14 8F`: two hands that pinch become two that touch.
    assert_eq!(contacts(&[0x80, 0x18, 0x14, 0x8F]).len(), 2);
}

proptest! {
    #[test]
    fn no_bytes_and_times_make_it_panic_and_time_never_goes_back(
        reads in prop::collection::vec(
            (
                prop::collection::vec(
                    prop_oneof![any::<u8>(), 0x80..=0x82u8, Just(0x8F), 0..=0x1Fu8],
                    0..40,
                ),
                0u64..500_000_000,
            ),
            0..60,
        ),
        timestamps: bool,
    ) {
        let pinch = pinch(&format!("timestamps = {timestamps}"));
        let mut stream = PinchStream::new(&pinch);
        let (mut arrival, mut newest) = (0, [Nanos(0); 2]);
        for (bytes, later) in reads {
            arrival += later;
            let mut times = Vec::new();
            stream.push(&bytes, Nanos(arrival), &mut |sample| {
                times.push((sample.sensor() as usize - 1, sample.time()));
            });
            for (hand, time) in times {
                prop_assert!(time > newest[hand]);
                newest[hand] = time;
            }
            // What is due is not long in coming.
            prop_assert!(stream.due().is_none_or(|due| due > Nanos(arrival)));
        }
    }
}
