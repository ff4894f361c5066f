//! The stream: from chunks of bytes with their arrival times to the contacts of two hands.
//!
//! Live driver and replay run the same stream, so that a recording gives the same samples.

use super::decoder::{Decoded, Decoder};
use super::message::MessageFormat;
use super::startup::Answer;
use crate::{Contacts, Flexion, HandSample, HandState, Sample, Stream, StreamCounts};
use sandtable_config::Pinch;
use sandtable_pose::Nanos;
use std::time::Duration;

/// The most that a read comes late, by which the box's own clock is believed rather than the
/// arrival: also what a clock that goes wrong can do.
const LATEST: Duration = Duration::from_millis(100);

/// Ticks at which the box's counter may have run over.
const OVERRUN: u16 = 0x3FFF;

/// Turns one box's bytes into samples. No port, no clock: the chunks bring their times.
///
/// A state is believed until the next one. From a byte on that fits in no message, or one that
/// begins a message which does not end, what the fingers do is in doubt; if no whole message
/// settles it within the rig's `release_after`, both hands are let go.
///
/// A byte lost or doubled, and the mark of a byte turned, are seen; then no contact is told that
/// was not there, though one may be missing where a mark was made of a finger's byte. What cannot
/// be seen: bits of fingers turned within a byte, an even number of bytes lost within one message,
/// and whole messages lost, for a message has neither a sum nor a number.
#[derive(Clone, Debug)]
pub struct PinchStream {
    decoder: Decoder,
    byte_time: Duration,
    release_after: Duration,
    /// Since when it is in doubt what the fingers do, while they are believed to do something.
    doubt: Option<Nanos>,
    /// Whether the newest samples tell what the fingers do.
    believed: bool,
    newest: Nanos,
    clock: BoxClock,
    answer: Option<Answer>,
    counts: StreamCounts,
}

impl PinchStream {
    /// The stream of a rig's PINCH gloves.
    #[must_use]
    pub fn new(pinch: &Pinch) -> Self {
        let format = MessageFormat {
            timestamps: pinch.timestamps,
            palms: pinch.palms,
        };
        Self {
            decoder: Decoder::new(format),
            byte_time: Duration::from_secs_f64(10.0 / f64::from(pinch.baud.max(1))),
            release_after: pinch.release_after,
            doubt: None,
            believed: false,
            newest: Nanos(0),
            clock: BoxClock::default(),
            answer: None,
            counts: StreamCounts::default(),
        }
    }

    /// The answer of the box that came last, once.
    pub(super) fn take_answer(&mut self) -> Option<Answer> {
        self.answer.take()
    }

    /// Takes a byte that was on the line until `end`.
    fn byte(&mut self, byte: u8, end: Nanos, out: &mut dyn FnMut(Sample)) {
        self.release(end, out);
        match self.decoder.push(byte) {
            Some(Decoded::Contacts(message)) => {
                let began = end - self.byte_time * message.length();
                let time = self.clock.date(began, message.ticks);
                self.doubt = None;
                self.believed = true;
                self.tell(time, Some(message.groups.contacts()), out);
                return;
            }
            Some(Decoded::Text(text)) => {
                let answer = Answer::of(text);
                self.clock.listen(&answer);
                self.answer = Some(answer);
            }
            Some(Decoded::Damage) => {
                self.clock.lose_count();
                self.doubt_since(end);
            }
            None => {}
        }
        if self.decoder.amid_contacts() {
            self.doubt_since(end);
        }
    }

    fn doubt_since(&mut self, time: Nanos) {
        if self.believed {
            self.doubt.get_or_insert(time);
        }
    }

    /// Lets both hands go where doubt has lasted until `now`.
    fn release(&mut self, now: Nanos, out: &mut dyn FnMut(Sample)) {
        if let Some(due) = self.due()
            && due <= now
        {
            self.doubt = None;
            self.believed = false;
            self.tell(due, None, out);
        }
    }

    fn tell(&mut self, time: Nanos, hands: Option<[Contacts; 2]>, out: &mut dyn FnMut(Sample)) {
        let time = time.max(self.newest + Duration::from_nanos(1));
        self.newest = time;
        for (hand, sensor) in (1..=2).enumerate() {
            let flexion = [None::<Flexion>; 5];
            let contacts = hands.map(|hands| hands[hand]);
            let hand = HandState { flexion, contacts };
            self.counts.samples += 1;
            out(Sample::Hand(HandSample { sensor, time, hand }));
        }
    }
}

impl Stream for PinchStream {
    fn push(&mut self, bytes: &[u8], arrival: Nanos, out: &mut dyn FnMut(Sample)) {
        for (index, &byte) in bytes.iter().enumerate() {
            // The line's own speed tells when a byte came, however late it was read.
            let since = bytes.len() - 1 - index;
            let end = arrival - self.byte_time * u32::try_from(since).unwrap_or(u32::MAX);
            self.byte(byte, end, out);
        }
        self.release(arrival, out);
    }

    fn restart(&mut self) {
        self.decoder.restart();
        self.doubt = None;
        self.believed = false;
        self.clock = BoxClock::default();
        self.answer = None;
    }

    fn due(&self) -> Option<Nanos> {
        self.doubt.map(|since| since + self.release_after)
    }

    fn counts(&self) -> StreamCounts {
        let decoder = self.decoder.counts();
        StreamCounts {
            records: decoder.messages,
            stray_bytes: decoder.stray_bytes,
            cut_records: decoder.cut_messages,
            implausible: decoder.implausible,
            ..self.counts
        }
    }
}

/// The box's clock, by which messages that were read late are dated.
///
/// A message never began later than its arrival says, but may well have earlier; the box tells how
/// long after the one before. So the earlier of the two times is the better one, within reason.
#[derive(Clone, Copy, Debug, Default)]
struct BoxClock {
    /// A tick's length, once the box has told it.
    tick: Option<Duration>,
    /// The number that it told last; that before the gloves' own answers is the tick's.
    number: Option<u32>,
    last: Option<Nanos>,
}

impl BoxClock {
    fn listen(&mut self, answer: &Answer) {
        match answer {
            Answer::Number(number) => self.number = Some(*number),
            Answer::Glove { .. } => {
                if let Some(microseconds) = self.number.take().filter(|number| *number > 0) {
                    self.tick = Some(Duration::from_micros(microseconds.into()));
                }
            }
            Answer::Unknown | Answer::Other => self.number = None,
        }
    }

    /// A message was lost, and with it the time that it told.
    fn lose_count(&mut self) {
        self.last = None;
    }

    fn date(&mut self, arrived: Nanos, ticks: Option<u16>) -> Nanos {
        let by_box = match (self.last, self.tick, ticks) {
            (Some(last), Some(tick), Some(ticks)) if ticks < OVERRUN => {
                Some(last + tick * u32::from(ticks))
            }
            _ => None,
        };
        let believed = by_box.filter(|&time| time <= arrived && arrived.since(time) <= LATEST);
        let time = believed.unwrap_or(arrived);
        self.last = Some(time);
        time
    }
}
