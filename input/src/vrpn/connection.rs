//! A connection without its socket: the cookies of both sides, and what waits to be sent.
//!
//! ```text
//! socket --bytes--> receive --what follows the cookie--> Inbound --reports--> owner
//! socket <--bytes-- outgoing <-- cookie, descriptions, reports <--------------- owner
//! ```
//!
//! Client and server run the same one. It knows no clock: reports bring their stamps.

use super::cookie::{COOKIE, COOKIE_LENGTH, CookieError, check_cookie};
use super::description::{SENDER_DESCRIPTION, TYPE_DESCRIPTION, write_description};
use super::message::{Header, Stamp, write_message};
use super::report::{Report, ReportKind};

/// The most that may wait to be sent, in bytes.
pub const LONGEST_QUEUE: usize = 1 << 16;

/// What waits to be sent has grown beyond [`LONGEST_QUEUE`]: the other side does not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("more than {LONGEST_QUEUE} bytes wait to be read by the other side")]
pub struct QueueFull;

/// One side of a connection.
#[derive(Clone, Debug)]
pub struct Connection {
    /// The other side's cookie, as far as it has come.
    cookie: [u8; COOKIE_LENGTH],
    got: usize,
    open: bool,
    /// Our own descriptions, in bytes, until they are sent.
    descriptions: Vec<u8>,
    outgoing: Vec<u8>,
    sent: usize,
    number: u32,
}

impl Connection {
    /// A connection that has just been made, on which we speak as `senders`: the first is number 0.
    /// Our cookie is the first that is outgoing.
    pub fn new<N: AsRef<str>>(senders: impl IntoIterator<Item = N>) -> Self {
        let mut descriptions = Vec::new();
        for (number, name) in (0..).zip(senders) {
            let name = name.as_ref().as_bytes();
            write_description(SENDER_DESCRIPTION, number, name, &mut descriptions);
        }
        for kind in ReportKind::ALL {
            let name = kind.name().as_bytes();
            write_description(TYPE_DESCRIPTION, number_of(kind), name, &mut descriptions);
        }
        Self {
            cookie: [0; COOKIE_LENGTH],
            got: 0,
            open: false,
            descriptions,
            outgoing: COOKIE.to_vec(),
            sent: 0,
            number: 0,
        }
    }

    /// Takes the bytes of one read and gives those that follow the other side's cookie.
    ///
    /// # Errors
    /// Where they begin with no cookie.
    pub fn receive<'b>(&mut self, bytes: &'b [u8]) -> Result<&'b [u8], CookieError> {
        let missing = COOKIE_LENGTH - self.got;
        let (more, rest) = bytes.split_at(missing.min(bytes.len()));
        self.cookie[self.got..self.got + more.len()].copy_from_slice(more);
        self.got += more.len();
        if !self.open && self.got == COOKIE_LENGTH {
            check_cookie(&self.cookie)?;
            self.open = true;
            // Nobody is told more than a cookie before it has shown its own.
            self.outgoing.append(&mut self.descriptions);
        }
        Ok(rest)
    }

    /// Whether the other side's cookie has come, and is one.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Queues what the sender with this number says; nothing is queued until the connection is
    /// open, since nobody could have missed it.
    ///
    /// # Errors
    /// Where too much is queued already.
    pub fn report(
        &mut self,
        sender: i32,
        stamp: Stamp,
        report: &Report<'_>,
    ) -> Result<(), QueueFull> {
        if !self.is_open() {
            return Ok(());
        }
        if self.outgoing.len() - self.sent > LONGEST_QUEUE {
            return Err(QueueFull);
        }
        let header = Header {
            payload: 0,
            stamp,
            sender,
            kind: number_of(report.kind()),
            number: self.number,
        };
        self.number = self.number.wrapping_add(1);
        write_message(&header, |out| report.encode(out), &mut self.outgoing);
        Ok(())
    }

    /// What is to be sent next.
    #[must_use]
    pub fn outgoing(&self) -> &[u8] {
        &self.outgoing[self.sent..]
    }

    /// Tells it that the first `count` of [`Connection::outgoing`] are on their way.
    pub fn sent(&mut self, count: usize) {
        self.sent = self.outgoing.len().min(self.sent.saturating_add(count));
        if self.sent == self.outgoing.len() {
            self.outgoing.clear();
            self.sent = 0;
        } else if self.sent >= LONGEST_QUEUE {
            self.outgoing.drain(..self.sent);
            self.sent = 0;
        }
    }
}

/// The number that stands for a type on our side.
fn number_of(kind: ReportKind) -> i32 {
    kind as i32
}

#[cfg(test)]
mod tests {
    use super::super::inbound::{Event, Inbound};
    use super::super::report::BigEndian;
    use super::*;

    fn open(senders: &[&str]) -> Connection {
        let mut connection = Connection::new(senders);
        assert_eq!(connection.outgoing(), COOKIE);
        assert_eq!(connection.receive(&COOKIE), Ok(&[][..]));
        connection
    }

    #[test]
    fn a_cookie_may_come_in_pieces_and_with_what_follows() {
        for at in 0..COOKIE_LENGTH {
            let mut connection = Connection::new(["T"]);
            assert_eq!(connection.receive(&COOKIE[..at]), Ok(&[][..]));
            assert!(!connection.is_open());
            assert_eq!(connection.outgoing(), COOKIE);
            let rest = [&COOKIE[at..], b"more"].concat();
            assert_eq!(connection.receive(&rest), Ok(&b"more"[..]));
            assert!(connection.is_open());
            assert_eq!(connection.receive(b"and more"), Ok(&b"and more"[..]));
        }
    }

    #[test]
    fn a_stranger_is_told_nothing_but_the_cookie() {
        let mut connection = Connection::new(["T"]);
        assert!(
            connection
                .receive(b"GET / HTTP/1.1\r\nHost: lab\r\n")
                .is_err()
        );
        assert_eq!(connection.outgoing(), COOKIE);
    }

    #[test]
    fn one_sides_outgoing_is_the_others_inbound() {
        let mut ours = open(&["A", "B"]);
        let stamp = Stamp {
            seconds: 1,
            microseconds: 2,
        };
        let states = [1i32.to_be_bytes(), 0i32.to_be_bytes()];
        ours.report(1, stamp, &Report::ButtonStates(BigEndian(&states)))
            .unwrap();
        ours.report(0, stamp, &Report::Pong).unwrap();
        let mut theirs = Inbound::new(["B", "A"]);
        let mut heard = Vec::new();
        let bytes = ours.outgoing()[COOKIE_LENGTH..].to_vec();
        theirs
            .push(&bytes, &mut |event| {
                if let Event::Report {
                    sender,
                    stamp,
                    report,
                } = event
                {
                    heard.push((sender, stamp, report.kind()));
                }
            })
            .unwrap();
        let expected = [
            (0, stamp, ReportKind::ButtonStates),
            (1, stamp, ReportKind::Pong),
        ];
        assert_eq!(heard, expected);
    }

    #[test]
    fn what_is_sent_in_pieces_is_sent_once_and_in_order() {
        let mut connection = open(&["A"]);
        let mut sent = Vec::new();
        let mut expected = connection.outgoing().to_vec();
        for turn in 0..5000 {
            let before = connection.outgoing().len();
            connection
                .report(0, Stamp::default(), &Report::Ping)
                .unwrap();
            expected.extend_from_slice(&connection.outgoing()[before..]);
            let count = (turn % 50).min(connection.outgoing().len());
            sent.extend_from_slice(&connection.outgoing()[..count]);
            connection.sent(count);
        }
        sent.extend_from_slice(connection.outgoing());
        assert!(sent == expected);
    }

    #[test]
    fn what_nobody_reads_does_not_grow_without_end() {
        let mut connection = open(&["A"]);
        let mut queued = 0;
        while connection
            .report(0, Stamp::default(), &Report::Pong)
            .is_ok()
        {
            queued += 1;
            assert!(queued < 10_000);
        }
        assert!(connection.outgoing().len() <= LONGEST_QUEUE + 24);
        assert!(connection.outgoing.capacity() <= 4 * LONGEST_QUEUE);
        // Once it is read, it goes on.
        connection.sent(usize::MAX);
        assert_eq!(
            connection.report(0, Stamp::default(), &Report::Pong),
            Ok(())
        );
    }
}
