//! A guest: one program that is connected to the server, and its socket, which never waits.

use super::offer::Offer;
use crate::vrpn::{Connection, CookieError, Event, Inbound, LengthError, QueueFull, Report, Stamp};
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// How long a guest may take to show its cookie.
const COOKIE_WITHIN: Duration = Duration::from_secs(3);

/// The most that is read of one guest before the others have their turn, in reads of 4 KiB.
const READS: usize = 4;

/// Why a guest goes.
#[derive(Debug, thiserror::Error)]
pub(super) enum Farewell {
    #[error("it has closed the connection")]
    Closed,
    #[error("the connection is broken ({0})")]
    Broken(io::Error),
    #[error("it has shown no cookie for 3 s")]
    NoCookie,
    #[error(transparent)]
    Cookie(#[from] CookieError),
    #[error(transparent)]
    Length(#[from] LengthError),
    #[error("it reads too slowly: {0}")]
    Slow(#[from] QueueFull),
}

impl Farewell {
    /// Whether the guest went by itself.
    pub(super) fn is_its_own(&self) -> bool {
        matches!(self, Self::Closed | Self::Broken(_))
    }
}

pub(super) struct Guest {
    socket: TcpStream,
    connection: Connection,
    inbound: Inbound,
    came: Instant,
}

impl Guest {
    pub(super) fn new(socket: TcpStream, offer: &Offer) -> io::Result<Self> {
        socket.set_nonblocking(true)?;
        socket.set_nodelay(true)?;
        Ok(Self {
            socket,
            connection: Connection::new(offer.names()),
            inbound: Inbound::new(offer.names()),
            came: Instant::now(),
        })
    }

    /// Hears what it has said, and answers its pings at the time `stamp`.
    pub(super) fn read(&mut self, offer: &Offer, stamp: Stamp) -> Result<(), Farewell> {
        let mut buffer = [0; 4096];
        for _ in 0..READS {
            match self.socket.read(&mut buffer) {
                Ok(0) => return Err(Farewell::Closed),
                Ok(count) => self.hear(&buffer[..count], offer, stamp)?,
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(Farewell::Broken(error)),
            }
        }
        if !self.connection.is_open() && self.came.elapsed() >= COOKIE_WITHIN {
            return Err(Farewell::NoCookie);
        }
        Ok(())
    }

    fn hear(&mut self, bytes: &[u8], offer: &Offer, stamp: Stamp) -> Result<(), Farewell> {
        let was_open = self.connection.is_open();
        let rest = self.connection.receive(bytes)?;
        let mut result = Ok(());
        let connection = &mut self.connection;
        if connection.is_open() && !was_open {
            offer.tell_standing(&mut |sender, report| {
                result = result.and(connection.report(sender, stamp, report));
            });
        }
        self.inbound.push(rest, &mut |event| {
            if let Event::Report {
                sender,
                report: Report::Ping,
                ..
            } = event
            {
                let sender = i32::try_from(sender).unwrap_or(i32::MAX);
                result = result.and(connection.report(sender, stamp, &Report::Pong));
            }
        })?;
        Ok(result?)
    }

    /// Queues what a sender says.
    pub(super) fn tell(
        &mut self,
        sender: i32,
        stamp: Stamp,
        report: &Report<'_>,
    ) -> Result<(), Farewell> {
        Ok(self.connection.report(sender, stamp, report)?)
    }

    /// Sends what its socket takes now.
    pub(super) fn write(&mut self) -> Result<(), Farewell> {
        while !self.connection.outgoing().is_empty() {
            match self.socket.write(self.connection.outgoing()) {
                Ok(0) => break,
                Ok(count) => self.connection.sent(count),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(Farewell::Broken(error)),
            }
        }
        Ok(())
    }
}
