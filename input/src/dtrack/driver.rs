//! The driver: one thread that receives a DTrack controller's datagrams.
//!
//! It opens the port, hands on each datagram as it came, and begins anew after a silence, for ever
//! and with a pause in between. It sends nothing.

use super::stream::DtrackStream;
use crate::Stream;
use crate::device_thread::{DeviceThread, Stopped};
use crate::recording::DeviceEvent;
use sandtable_config::Dtrack;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

/// Why a DTrack controller is not streaming just now.
#[derive(Debug, thiserror::Error)]
pub enum DtrackError {
    /// The port cannot be opened, or not be read.
    #[error("cannot receive at UDP {address} ({source}); {remedy}")]
    Receive {
        /// This computer's address and port.
        address: SocketAddr,
        /// What the system says.
        source: io::Error,
        /// What helps.
        remedy: &'static str,
    },
    /// No datagram came.
    #[error(
        "no datagram has come to UDP {address} for {seconds} s; start DTrack's measurement, and \
         send its output to this computer, port {port}"
    )]
    Silent {
        /// This computer's address and port.
        address: SocketAddr,
        /// Its port.
        port: u16,
        /// How long it was waited for, in seconds.
        seconds: f64,
    },
    /// Datagrams came, and none that is meant.
    #[error(
        "datagrams come to UDP {address}, but only of {other}, where the rig says from = {from}"
    )]
    OtherHost {
        /// This computer's address and port.
        address: SocketAddr,
        /// Who sends.
        other: std::net::IpAddr,
        /// Who should.
        from: std::net::IpAddr,
    },
    /// Datagrams come, but no bodies.
    #[error(
        "datagrams come to UDP {address}, but no line `6d` or `6df2` that can be read; switch on \
         the output of standard bodies (6d) and Flysticks (6df2) in DTrack"
    )]
    NoBodies {
        /// This computer's address and port.
        address: SocketAddr,
    },
}

/// How long one read waits, and so how long a stop may take.
const WAIT: Duration = Duration::from_millis(50);

/// No datagram is longer.
const LONGEST_DATAGRAM: usize = 1 << 16;

/// The driver's own state.
struct Driver {
    dtrack: Dtrack,
    address: SocketAddr,
    stream: DtrackStream,
    buffer: Vec<u8>,
}

/// Keeps a DTrack controller's datagrams coming until its thread is to end.
pub(crate) fn run(dtrack: &Dtrack, thread: DeviceThread) {
    let mut driver = Driver {
        address: SocketAddr::new(dtrack.bind, dtrack.port),
        stream: DtrackStream::new(dtrack),
        dtrack: dtrack.clone(),
        buffer: vec![0; LONGEST_DATAGRAM],
    };
    thread.run(|thread| driver.session(thread));
}

impl Driver {
    /// From opening the port to a silence.
    fn session(&mut self, thread: &mut DeviceThread) -> Result<Stopped, DtrackError> {
        let socket = UdpSocket::bind(self.address).map_err(|error| self.cannot(error))?;
        let wait = socket.set_read_timeout(Some(WAIT));
        wait.map_err(|error| self.cannot(error))?;
        self.stream.restart();
        thread.outlet.event(DeviceEvent::Started);
        let start = Instant::now();
        let (mut heard, mut understood) = (start, start);
        let mut other = None;
        let mut complete = false;
        loop {
            if thread.pause(Duration::ZERO).is_err() {
                return Ok(Stopped);
            }
            match socket.recv_from(&mut self.buffer) {
                Ok((_, sender)) if self.is_other(sender) => other = Some(sender.ip()),
                Ok((count, _)) => {
                    let arrival = thread.outlet.now();
                    heard = Instant::now();
                    let datagram = &self.buffer[..count];
                    thread.outlet.bytes(datagram, arrival, &mut self.stream);
                    if self.stream.is_understood() {
                        understood = heard;
                        if !complete {
                            complete = true;
                            thread.streaming(&format!("UDP {}", self.address));
                        }
                    }
                }
                Err(error) => match error.kind() {
                    ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => {}
                    _ => return Err(self.cannot(error)),
                },
            }
            if heard.elapsed() >= self.dtrack.silent_after {
                return Err(self.silent(other));
            }
            if understood.elapsed() >= self.dtrack.silent_after {
                let address = self.address;
                return Err(DtrackError::NoBodies { address });
            }
        }
    }

    /// Whether datagrams of `sender` are to be ignored.
    fn is_other(&self, sender: SocketAddr) -> bool {
        let same = |from| sender.ip().to_canonical() == from;
        !self.dtrack.from.is_none_or(same)
    }

    fn silent(&self, other: Option<std::net::IpAddr>) -> DtrackError {
        let address = self.address;
        match (other, self.dtrack.from) {
            (Some(other), Some(from)) => DtrackError::OtherHost {
                address,
                other,
                from,
            },
            _ => DtrackError::Silent {
                address,
                port: self.dtrack.port,
                seconds: self.dtrack.silent_after.as_secs_f64(),
            },
        }
    }

    fn cannot(&self, source: io::Error) -> DtrackError {
        let remedy = match source.kind() {
            ErrorKind::AddrInUse => {
                "another program receives there: end it, or take another port in DTrack and rig"
            }
            ErrorKind::AddrNotAvailable => "write an address of this computer as `bind`",
            ErrorKind::PermissionDenied => "take a port from 1024 on in DTrack and in the rig",
            _ => "look at `bind` and `port` in the rig",
        };
        DtrackError::Receive {
            address: self.address,
            source,
            remedy,
        }
    }
}
