//! A TCP line: dialled without making its caller wait, read without waiting long, and gone when
//! the other side closes it.

use crate::device_thread::{DeviceThread, Stopped};
use crossbeam_channel::{Receiver, RecvTimeoutError};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// How long one read or write waits, and so how long a stop may take.
const WAIT: Duration = Duration::from_millis(50);

/// How long one address may take to answer.
const ANSWER_WITHIN: Duration = Duration::from_secs(3);

/// How many of a name's addresses are tried.
const MOST_ADDRESSES: usize = 4;

/// How long a dialling is waited for before it is an error; it goes on beside.
const DIAL_WITHIN: Duration = Duration::from_secs(5);

/// What is wrong with a TCP line.
#[derive(Debug, thiserror::Error)]
pub enum TcpError {
    /// The host's name has no address.
    #[error(
        "cannot connect to {host}, port {port}: no host of this name is known ({problem}); check \
         the name, or write its IP address"
    )]
    NoHost {
        /// The host's name.
        host: String,
        /// The port.
        port: u16,
        /// What the system says.
        problem: String,
    },
    /// No connection can be made.
    #[error("cannot connect to {host}, port {port} ({problem}); {remedy}")]
    Connect {
        /// The host's name.
        host: String,
        /// The port.
        port: u16,
        /// What the system says.
        problem: String,
        /// What helps.
        remedy: &'static str,
    },
    /// The connection was there and is gone.
    #[error("{host}, port {port}, has ended the connection ({problem}); start the server anew")]
    Gone {
        /// The host's name.
        host: String,
        /// The port.
        port: u16,
        /// What the system says.
        problem: String,
    },
}

/// Dials one host, in a thread of its own: looking up a name may take long, and cannot be ended.
///
/// There is one such thread at most. It ends by itself once the system has answered.
pub(crate) struct Dialler {
    host: String,
    port: u16,
    dialling: Option<Receiver<Result<TcpStream, TcpError>>>,
}

/// An open connection.
pub(crate) struct TcpLine {
    host: String,
    port: u16,
    socket: TcpStream,
}

impl Dialler {
    pub(crate) fn new(host: &str, port: u16) -> Self {
        Self {
            host: host.to_owned(),
            port,
            dialling: None,
        }
    }

    /// Waits for a connection, or for the thread's end.
    pub(crate) fn dial(
        &mut self,
        thread: &DeviceThread,
    ) -> Result<Result<TcpLine, Stopped>, TcpError> {
        let dialling = match self.dialling.take() {
            // Of a dialling that took too long for the session before.
            Some(dialling) => dialling,
            None => self.start()?,
        };
        let start = Instant::now();
        while start.elapsed() < DIAL_WITHIN {
            match dialling.recv_timeout(WAIT) {
                Ok(socket) => {
                    return Ok(Ok(TcpLine {
                        socket: socket?,
                        host: self.host.clone(),
                        port: self.port,
                    }));
                }
                Err(RecvTimeoutError::Timeout) => {
                    if thread.pause(Duration::ZERO).is_err() {
                        return Ok(Err(Stopped));
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(self.cannot(&io::Error::other("the dialling broke off")));
                }
            }
        }
        self.dialling = Some(dialling);
        Err(self.cannot(&ErrorKind::TimedOut.into()))
    }

    fn start(&self) -> Result<Receiver<Result<TcpStream, TcpError>>, TcpError> {
        let (answer, dialling) = crossbeam_channel::bounded(1);
        let (host, port) = (self.host.clone(), self.port);
        std::thread::Builder::new()
            .name(format!("dial {host}"))
            .spawn(move || {
                // Nobody listens any more where the device was stopped meanwhile.
                let _ = answer.send(connect(&host, port));
            })
            .map_err(|error| self.cannot(&error))?;
        Ok(dialling)
    }

    fn cannot(&self, error: &io::Error) -> TcpError {
        cannot_connect(&self.host, self.port, error)
    }
}

/// Looks up `host` and connects to the first of its addresses that answers.
fn connect(host: &str, port: u16) -> Result<TcpStream, TcpError> {
    let no_host = |problem: String| TcpError::NoHost {
        host: host.to_owned(),
        port,
        problem,
    };
    let addresses = (host, port).to_socket_addrs();
    let addresses: Vec<SocketAddr> = addresses
        .map_err(|error| no_host(error.to_string()))?
        .take(MOST_ADDRESSES)
        .collect();
    let mut last = None;
    for address in addresses {
        match TcpStream::connect_timeout(&address, ANSWER_WITHIN).and_then(prepared) {
            Ok(socket) => return Ok(socket),
            Err(error) => last = Some(error),
        }
    }
    Err(match last {
        Some(error) => cannot_connect(host, port, &error),
        None => no_host("it has no address".to_owned()),
    })
}

fn prepared(socket: TcpStream) -> io::Result<TcpStream> {
    socket.set_nodelay(true)?;
    socket.set_read_timeout(Some(WAIT))?;
    socket.set_write_timeout(Some(WAIT))?;
    Ok(socket)
}

fn cannot_connect(host: &str, port: u16, error: &io::Error) -> TcpError {
    let remedy = match error.kind() {
        ErrorKind::ConnectionRefused => {
            "nobody listens there: start the server, or name its port behind the host"
        }
        ErrorKind::TimedOut | ErrorKind::WouldBlock => {
            "check that the host is on, and that no firewall is between"
        }
        ErrorKind::HostUnreachable | ErrorKind::NetworkUnreachable => {
            "check the network's cable and the host's address"
        }
        _ => "check the host's name and port, and that its server runs",
    };
    TcpError::Connect {
        host: host.to_owned(),
        port,
        problem: error.to_string(),
        remedy,
    }
}

impl TcpLine {
    /// Reads what is there, waiting a little; nothing is 0 bytes.
    pub(crate) fn read(&mut self, buffer: &mut [u8]) -> Result<usize, TcpError> {
        match self.socket.read(buffer) {
            // One that is silent times out instead.
            Ok(0) => Err(self.gone("it was closed")),
            Ok(count) => Ok(count),
            Err(error) => self.none_yet(&error),
        }
    }

    /// Writes what can be written, waiting a little; returns how much that was.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<usize, TcpError> {
        match self.socket.write(bytes) {
            Ok(count) => Ok(count),
            Err(error) => self.none_yet(&error),
        }
    }

    fn none_yet(&self, error: &io::Error) -> Result<usize, TcpError> {
        match error.kind() {
            ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => Ok(0),
            _ => Err(self.gone(&error.to_string())),
        }
    }

    fn gone(&self, problem: &str) -> TcpError {
        TcpError::Gone {
            host: self.host.clone(),
            port: self.port,
            problem: problem.to_owned(),
        }
    }
}
