//! Inbound: from the other side's bytes, behind its cookie, to reports of the senders that one
//! wants to hear of.
//!
//! It knows no socket and no clock. Numbers of senders and types mean what this connection has
//! described them as; all else is let pass. What is kept between two reads is part of one message
//! at most, and two short tables.

use super::description::{SENDER_DESCRIPTION, TYPE_DESCRIPTION, decode_name};
use super::message::{HEADER_LENGTH, Header, LengthError, Stamp};
use super::report::{Report, ReportKind};

/// How many numbers may stand for the senders, or for the types, that are wanted.
const MOST_NUMBERS: usize = 256;

/// What the other side's bytes may be worth knowing for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event<'a> {
    /// A sender has been described.
    Sender {
        /// Its name.
        name: &'a [u8],
        /// Which of the wanted ones it is, if it is one.
        wanted: Option<usize>,
    },
    /// A wanted sender says something.
    Report {
        /// Which of the wanted ones.
        sender: usize,
        /// When it happened, on the other side's clock.
        stamp: Stamp,
        /// What it says.
        report: Report<'a>,
    },
    /// A message that is of no wanted sender, or of no known type.
    Foreign,
    /// A message whose payload is not what its type promises.
    Malformed,
}

/// One connection's inbound side.
#[derive(Clone, Debug)]
pub struct Inbound {
    wanted: Vec<Vec<u8>>,
    /// The other side's numbers, and which of the wanted senders each stands for.
    senders: Vec<(i32, usize)>,
    /// The other side's numbers, and which known type each stands for.
    types: Vec<(i32, ReportKind)>,
    /// A message of which a part has come.
    part: Vec<u8>,
    broken: Option<LengthError>,
}

impl Inbound {
    /// The inbound side of a new connection, by which the `wanted` senders are heard.
    pub fn new<N: AsRef<str>>(wanted: impl IntoIterator<Item = N>) -> Self {
        let bytes = |name: N| name.as_ref().as_bytes().to_vec();
        Self {
            wanted: wanted.into_iter().map(bytes).collect(),
            senders: Vec::new(),
            types: Vec::new(),
            part: Vec::new(),
            broken: None,
        }
    }

    /// Forgets the connection before, its numbers and what was wrong with it.
    pub fn restart(&mut self) {
        self.senders.clear();
        self.types.clear();
        self.part.clear();
        self.broken = None;
    }

    /// Why nothing is heard any more, once the other side has claimed an impossible length.
    #[must_use]
    pub fn problem(&self) -> Option<LengthError> {
        self.broken
    }

    /// Takes the bytes of one read and tells what they mean.
    ///
    /// # Errors
    /// Where a message's length cannot be. What comes behind it cannot be told apart, so that the
    /// same error is given until [`Inbound::restart`].
    pub fn push(
        &mut self,
        bytes: &[u8],
        out: &mut dyn FnMut(Event<'_>),
    ) -> Result<(), LengthError> {
        if let Some(error) = self.broken {
            return Err(error);
        }
        self.take(bytes, out).inspect_err(|error| {
            self.broken = Some(*error);
            self.part = Vec::new();
        })
    }

    fn take(
        &mut self,
        mut bytes: &[u8],
        out: &mut dyn FnMut(Event<'_>),
    ) -> Result<(), LengthError> {
        while !bytes.is_empty() {
            if self.part.is_empty()
                && let Some((head, rest)) = bytes.split_first_chunk::<HEADER_LENGTH>()
            {
                let header = Header::decode(head)?;
                let padded = header.wire_length() - HEADER_LENGTH;
                if let Some((payload, rest)) = rest.split_at_checked(padded) {
                    self.message(&header, &payload[..header.payload], out);
                    bytes = rest;
                    continue;
                }
            }
            bytes = self.keep(bytes, HEADER_LENGTH);
            let Some(head) = self.part.first_chunk::<HEADER_LENGTH>() else {
                break;
            };
            let header = Header::decode(head)?;
            bytes = self.keep(bytes, header.wire_length());
            if self.part.len() == header.wire_length() {
                let whole = std::mem::take(&mut self.part);
                self.message(&header, &whole[HEADER_LENGTH..][..header.payload], out);
                self.part = whole;
                self.part.clear();
            }
        }
        Ok(())
    }

    /// Moves what is missing of a part's `length` from `bytes` to it; gives the rest.
    fn keep<'b>(&mut self, bytes: &'b [u8], length: usize) -> &'b [u8] {
        let missing = length.saturating_sub(self.part.len());
        let (more, rest) = bytes.split_at(missing.min(bytes.len()));
        self.part.extend_from_slice(more);
        rest
    }

    fn message(&mut self, header: &Header, payload: &[u8], out: &mut dyn FnMut(Event<'_>)) {
        match header.kind {
            SENDER_DESCRIPTION => match decode_name(payload) {
                Some(name) => {
                    let wanted = self.wanted.iter().position(|wanted| wanted == name);
                    renumber(&mut self.senders, header.sender, wanted);
                    out(Event::Sender { name, wanted });
                }
                None => out(Event::Malformed),
            },
            TYPE_DESCRIPTION => match decode_name(payload) {
                Some(name) => {
                    let mut known = ReportKind::ALL.into_iter();
                    let kind = known.find(|kind| kind.name().as_bytes() == name);
                    renumber(&mut self.types, header.sender, kind);
                }
                None => out(Event::Malformed),
            },
            _ => self.report(header, payload, out),
        }
    }

    fn report(&self, header: &Header, payload: &[u8], out: &mut dyn FnMut(Event<'_>)) {
        let sender = meaning(&self.senders, header.sender);
        let kind = meaning(&self.types, header.kind);
        let (Some(sender), Some(kind)) = (sender, kind) else {
            out(Event::Foreign);
            return;
        };
        match Report::decode(kind, payload) {
            Some(report) => out(Event::Report {
                sender,
                stamp: header.stamp,
                report,
            }),
            None => out(Event::Malformed),
        }
    }

    /// How many bytes it holds on to.
    #[cfg(test)]
    fn held(&self) -> usize {
        self.part.capacity()
            + self.senders.capacity() * size_of::<(i32, usize)>()
            + self.types.capacity() * size_of::<(i32, ReportKind)>()
    }
}

fn meaning<M: Copy>(table: &[(i32, M)], number: i32) -> Option<M> {
    let found = table.iter().find(|(known, _)| *known == number);
    found.map(|(_, meaning)| *meaning)
}

/// Lets `number` stand for `meaning` from now on, or for nothing that is wanted.
fn renumber<M: Copy>(table: &mut Vec<(i32, M)>, number: i32, meaning: Option<M>) {
    table.retain(|(known, _)| *known != number);
    if let Some(meaning) = meaning {
        // Nobody describes one name so often; one who does keeps the newest.
        if table.len() == MOST_NUMBERS {
            table.remove(0);
        }
        table.push((number, meaning));
    }
}

#[cfg(test)]
mod tests {
    use super::super::description::write_description;
    use super::super::message::{LONGEST_MESSAGE, write_message};
    use super::super::report::TrackerPose;
    use super::*;
    use glam::{DQuat, DVec3};
    use proptest::prelude::*;

    const TRACKER: &str = "Tracker0";

    fn inbound() -> Inbound {
        Inbound::new([TRACKER, "Wand0"])
    }

    fn described(names: &[(i32, i32, &str)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (kind, number, name) in names {
            write_description(*kind, *number, name.as_bytes(), &mut bytes);
        }
        bytes
    }

    /// Names, and a pose.
    fn conversation() -> Vec<u8> {
        let mut bytes = described(&[(-1, 5, TRACKER), (-2, 2, "vrpn_Tracker Pos_Quat")]);
        let header = Header {
            payload: 0,
            stamp: Stamp::default(),
            sender: 5,
            kind: 2,
            number: 0,
        };
        let pose = Report::Pose(TrackerPose {
            sensor: 0,
            position: DVec3::X,
            rotation: DQuat::IDENTITY,
        });
        write_message(&header, |out| pose.encode(out), &mut bytes);
        bytes
    }

    fn events(inbound: &mut Inbound, chunks: &[&[u8]]) -> Vec<String> {
        let mut events = Vec::new();
        for chunk in chunks {
            let result = inbound.push(chunk, &mut |event| events.push(format!("{event:?}")));
            assert_eq!(result, Ok(()));
        }
        events
    }

    #[test]
    fn a_name_described_without_end_takes_no_room_without_end() {
        let mut inbound = inbound();
        for number in 0..100_000 {
            let bytes = described(&[
                (-1, number, TRACKER),
                (-2, number, "vrpn_Button Change"),
                (-1, -number, "A stranger"),
            ]);
            events(&mut inbound, &[&bytes]);
        }
        assert!(inbound.held() < 1 << 14, "{}", inbound.held());
        // The newest number still counts.
        assert_eq!(meaning(&inbound.senders, 99_999), Some(0));
    }

    /// Bytes that look like messages more often than chance would have it.
    fn hostile() -> impl Strategy<Value = Vec<u8>> {
        let word = prop_oneof![
            Just(0u32),
            Just(24),
            Just(28),
            Just(88),
            Just(LONGEST_MESSAGE as u32),
            Just(u32::MAX),
            Just(-1i32 as u32),
            Just(-2i32 as u32),
            0..100u32,
            any::<u32>(),
        ];
        prop::collection::vec(word, 0..200)
            .prop_map(|words| words.iter().flat_map(|word| word.to_be_bytes()).collect())
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic_or_grow(bytes in hostile(), size in 1usize..100) {
            let mut inbound = inbound();
            let mut events = 0;
            for chunk in bytes.chunks(size) {
                let _ = inbound.push(chunk, &mut |_| events += 1);
            }
            // A message has 24 bytes at least, and what is kept of one is twice it at most.
            prop_assert!(events <= bytes.len() / HEADER_LENGTH);
            prop_assert!(inbound.held() <= 2 * bytes.len() + 512, "{}", inbound.held());
        }

        #[test]
        fn altered_bytes_make_it_neither_panic_nor_grow(
            at in 0usize..500, byte: u8, size in 1usize..600,
        ) {
            let mut bytes = conversation();
            let at = at % bytes.len();
            bytes[at] = byte;
            let mut inbound = inbound();
            for chunk in bytes.chunks(size) {
                let _ = inbound.push(chunk, &mut |_| {});
            }
            prop_assert!(inbound.held() <= 2 * LONGEST_MESSAGE + 512);
        }
    }

    #[test]
    fn a_long_message_is_kept_once_and_its_room_is_used_again() {
        let mut inbound = inbound();
        let header = Header {
            payload: 0,
            stamp: Stamp::default(),
            sender: 1,
            kind: 1,
            number: 0,
        };
        let mut bytes = Vec::new();
        let longest = LONGEST_MESSAGE - HEADER_LENGTH;
        write_message(
            &header,
            |out| out.resize(HEADER_LENGTH + longest, 7),
            &mut bytes,
        );
        for _ in 0..100 {
            let chunks: Vec<&[u8]> = bytes.chunks(1000).collect();
            assert_eq!(events(&mut inbound, &chunks), ["Foreign"]);
        }
        assert!(inbound.held() <= 2 * LONGEST_MESSAGE, "{}", inbound.held());
    }
}
