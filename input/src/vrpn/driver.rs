//! The driver: one thread that keeps a VRPN server's device streaming, whatever happens to it.
//!
//! It connects, shows its cookie, reads, asks with a ping where nothing comes, and begins anew
//! after a silence, an error or a lost connection, for ever and with a pause in between. What it
//! reads behind the cookie it hands on as it came.

use super::connection::Connection;
use super::cookie::CookieError;
use super::message::{LengthError, Stamp};
use super::report::Report;
use super::stream::VrpnStream;
use crate::Stream;
use crate::device_thread::{DeviceThread, Stopped};
use crate::recording::DeviceEvent;
use crate::tcp_line::{Dialler, TcpError, TcpLine};
use sandtable_config::Vrpn;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Why a VRPN server's device is not streaming just now.
#[derive(Debug, thiserror::Error)]
pub enum VrpnError {
    /// Its line.
    #[error(transparent)]
    Line(#[from] TcpError),
    /// Someone else listens there.
    #[error(
        "{host}, port {port}, is no VRPN server of our version: {problem}; name the port of one"
    )]
    Cookie {
        /// The server's host.
        host: String,
        /// Its port.
        port: u16,
        /// What it says instead.
        problem: CookieError,
    },
    /// It took the connection and says nothing.
    #[error(
        "{host}, port {port}, took the connection and has been silent for {seconds} s; a VRPN \
         server waits so while one of its devices starts: look at its messages, or start it anew"
    )]
    NoCookie {
        /// The server's host.
        host: String,
        /// Its port.
        port: u16,
        /// How long it was waited for, in seconds.
        seconds: f64,
    },
    /// Nothing came, whatever it was asked.
    #[error(
        "{host}, port {port}, has been silent for {seconds} s and answers no ping; start its VRPN \
         server anew"
    )]
    Silent {
        /// The server's host.
        host: String,
        /// Its port.
        port: u16,
        /// How long it was waited for, in seconds.
        seconds: f64,
    },
    /// It has no device of the name.
    #[error("the VRPN server on {host}, port {port}, has no device `{sender}`; {remedy}")]
    NoSender {
        /// The server's host.
        host: String,
        /// Its port.
        port: u16,
        /// The device's name in the rig.
        sender: String,
        /// What it has.
        remedy: String,
    },
    /// What it says is not VRPN's.
    #[error("{host}, port {port}: {problem}; start its VRPN server anew")]
    Garbled {
        /// The server's host.
        host: String,
        /// Its port.
        port: u16,
        /// What cannot be.
        problem: LengthError,
    },
}

/// How long nothing comes until it is asked for an answer, and between two such questions.
const PING_AFTER: Duration = Duration::from_secs(1);

/// How long a server may take to name its devices.
const NAMED_WITHIN: Duration = Duration::from_secs(2);

/// The least time between two texts of a server in the log.
const TEXT_PAUSE: Duration = Duration::from_secs(10);

/// The driver's own state.
struct Driver {
    vrpn: Vrpn,
    stream: VrpnStream,
    dialler: Dialler,
    text_logged: Option<Instant>,
}

/// Keeps a VRPN device streaming until its thread is to end.
pub(crate) fn run(vrpn: &Vrpn, thread: DeviceThread) {
    let mut driver = Driver {
        stream: VrpnStream::new(vrpn),
        dialler: Dialler::new(&vrpn.address.host, vrpn.address.port),
        vrpn: vrpn.clone(),
        text_logged: None,
    };
    thread.run(|thread| {
        let before = driver.stream.counts().records;
        let result = driver.session(thread);
        if driver.stream.counts().records > before {
            thread.outlet.tell_calibration(&driver.stream);
        }
        result
    });
}

impl Driver {
    /// From dialling to losing the connection.
    fn session(&mut self, thread: &mut DeviceThread) -> Result<Stopped, VrpnError> {
        let mut line = match self.dialler.dial(thread)? {
            Ok(line) => line,
            Err(Stopped) => return Ok(Stopped),
        };
        let mut connection = Connection::new(self.stream.senders());
        let mut buffer = [0; 4096];
        let start = Instant::now();
        loop {
            if thread.pause(Duration::ZERO).is_err() {
                return Ok(Stopped);
            }
            send(&mut line, &mut connection)?;
            let count = line.read(&mut buffer)?;
            let rest = connection.receive(&buffer[..count]).map_err(|problem| {
                let (host, port) = self.place();
                VrpnError::Cookie {
                    host,
                    port,
                    problem,
                }
            })?;
            if connection.is_open() {
                self.stream.restart();
                thread.outlet.event(DeviceEvent::Started);
                // Asked for now, so that in a recording no byte comes before the start.
                let arrival = thread.outlet.now();
                if !rest.is_empty() {
                    thread.outlet.bytes(rest, arrival, &mut self.stream);
                }
                return self.read_stream(thread, &mut line, &mut connection);
            }
            if start.elapsed() >= self.vrpn.silent_after {
                let (host, port) = self.place();
                return Err(VrpnError::NoCookie {
                    host,
                    port,
                    seconds: self.vrpn.silent_after.as_secs_f64(),
                });
            }
        }
    }

    fn read_stream(
        &mut self,
        thread: &mut DeviceThread,
        line: &mut TcpLine,
        connection: &mut Connection,
    ) -> Result<Stopped, VrpnError> {
        let mut buffer = [0; 4096];
        let start = Instant::now();
        let (mut heard, mut asked) = (start, start);
        let mut complete = false;
        loop {
            if thread.pause(Duration::ZERO).is_err() {
                return Ok(Stopped);
            }
            thread.outlet.reset_where_asked(&mut self.stream);
            send(line, connection)?;
            let count = line.read(&mut buffer)?;
            let arrival = thread.outlet.now();
            if count > 0 {
                heard = Instant::now();
                thread
                    .outlet
                    .bytes(&buffer[..count], arrival, &mut self.stream);
            }
            self.check(heard)?;
            self.log_text(thread);
            if heard.elapsed() >= PING_AFTER && asked.elapsed() >= PING_AFTER {
                asked = Instant::now();
                // A full queue is that of a server that does not read; its silence ends it.
                let _ = connection.report(0, now(), &Report::Ping);
            }
            if !complete {
                match self.stream.missing_sender() {
                    None => {
                        complete = true;
                        thread.streaming(&self.vrpn.address.to_string());
                    }
                    Some(sender) if start.elapsed() >= NAMED_WITHIN => {
                        return Err(self.no_sender(sender.to_owned()));
                    }
                    Some(_) => {}
                }
            }
        }
    }

    /// Whether the server is still there and makes sense.
    fn check(&self, heard: Instant) -> Result<(), VrpnError> {
        if let Some(problem) = self.stream.problem() {
            let (host, port) = self.place();
            return Err(VrpnError::Garbled {
                host,
                port,
                problem,
            });
        }
        if heard.elapsed() >= self.vrpn.silent_after {
            let (host, port) = self.place();
            return Err(VrpnError::Silent {
                host,
                port,
                seconds: self.vrpn.silent_after.as_secs_f64(),
            });
        }
        Ok(())
    }

    fn log_text(&mut self, thread: &DeviceThread) {
        let Some(text) = self.stream.take_text() else {
            return;
        };
        let recent = |logged: Instant| logged.elapsed() < TEXT_PAUSE;
        if self.text_logged.is_some_and(recent) {
            return;
        }
        self.text_logged = Some(Instant::now());
        let (device, words) = (thread.outlet.device(), text.words);
        match text.severity {
            0 => tracing::info!(device, "its server says: {words:?}"),
            _ => tracing::warn!(device, "its server says: {words:?}"),
        }
    }

    fn no_sender(&self, sender: String) -> VrpnError {
        let (host, port) = self.place();
        let others = self.stream.other_senders();
        VrpnError::NoSender {
            host,
            port,
            sender,
            remedy: if others.is_empty() {
                "it names none; look at its configuration".to_owned()
            } else {
                format!("it has: {}", others.join(", "))
            },
        }
    }

    fn place(&self) -> (String, u16) {
        (self.vrpn.address.host.clone(), self.vrpn.address.port)
    }
}

/// Sends what can be sent at once.
fn send(line: &mut TcpLine, connection: &mut Connection) -> Result<(), VrpnError> {
    if !connection.outgoing().is_empty() {
        let count = line.write(connection.outgoing())?;
        connection.sent(count);
    }
    Ok(())
}

/// The time of day; 1970 where this computer's clock is set before it.
fn now() -> Stamp {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    Stamp::since_1970(since.unwrap_or_default())
}
