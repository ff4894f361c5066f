//! VRPN's bytes written and read by hand, from the protocol's description alone: nothing here uses
//! the crate's own wire.
#![allow(dead_code, reason = "each test file uses its own part of it")]

use crate::waiting::PATIENCE;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

pub(crate) const COOKIE: [u8; 24] = *b"vrpn: ver. 07.38  0\0\0\0\0\0";

/// Header, payload and padding.
pub(crate) fn message(sender: i32, kind: i32, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend((24 + payload.len() as u32).to_be_bytes());
    // Some Saturday of 2026, and 250 ms.
    bytes.extend(1_795_276_800u32.to_be_bytes());
    bytes.extend(250_000u32.to_be_bytes());
    bytes.extend(sender.to_be_bytes());
    bytes.extend(kind.to_be_bytes());
    bytes.extend(0u32.to_be_bytes());
    bytes.extend(payload);
    while bytes.len() % 8 != 0 {
        bytes.push(0);
    }
    bytes
}

fn description(kind: i32, number: i32, name: &str) -> Vec<u8> {
    let mut payload = (name.len() as i32 + 1).to_be_bytes().to_vec();
    payload.extend(name.as_bytes());
    payload.push(0);
    message(number, kind, &payload)
}

pub(crate) fn sender(number: i32, name: &str) -> Vec<u8> {
    description(-1, number, name)
}

pub(crate) fn kind(number: i32, name: &str) -> Vec<u8> {
    description(-2, number, name)
}

/// Sensor, filler, metres, quaternion x y z w.
pub(crate) fn pose(sensor: i32, position: [f64; 3], quaternion: [f64; 4]) -> Vec<u8> {
    let mut payload = sensor.to_be_bytes().to_vec();
    payload.extend([0xde, 0xad, 0xbe, 0xef]);
    for number in position.into_iter().chain(quaternion) {
        payload.extend(number.to_be_bytes());
    }
    payload
}

pub(crate) fn integers(numbers: &[i32]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_be_bytes()).collect()
}

pub(crate) fn doubles(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_be_bytes()).collect()
}

/// A message as it was read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Message {
    pub(crate) seconds: u32,
    pub(crate) microseconds: u32,
    pub(crate) sender: i32,
    pub(crate) kind: i32,
    pub(crate) payload: Vec<u8>,
}

impl Message {
    pub(crate) fn integer(&self, at: usize) -> i32 {
        i32::from_be_bytes(self.payload[at..at + 4].try_into().unwrap())
    }

    pub(crate) fn double(&self, at: usize) -> f64 {
        f64::from_be_bytes(self.payload[at..at + 8].try_into().unwrap())
    }

    /// A description's name.
    pub(crate) fn name(&self) -> &str {
        assert_eq!(self.integer(0) as usize, self.payload.len() - 4);
        let (zero, name) = self.payload[4..].split_last().unwrap();
        assert_eq!(*zero, 0);
        std::str::from_utf8(name).unwrap()
    }
}

/// The other end of a connection.
pub(crate) struct Peer {
    pub(crate) socket: TcpStream,
}

impl Peer {
    pub(crate) fn new(socket: TcpStream) -> Self {
        socket
            .set_read_timeout(Some(Duration::from_millis(20)))
            .unwrap();
        socket.set_nodelay(true).unwrap();
        Self { socket }
    }

    pub(crate) fn send(&mut self, bytes: &[u8]) {
        self.socket.write_all(bytes).unwrap();
    }

    /// The next `count` bytes; `None` where the other side closes, or is silent `within` that time.
    pub(crate) fn bytes(&mut self, count: usize, within: Duration) -> Option<Vec<u8>> {
        let mut bytes = vec![0; count];
        let mut got = 0;
        let start = Instant::now();
        while got < count {
            match self.socket.read(&mut bytes[got..]) {
                Ok(0) => return None,
                Ok(more) => got += more,
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
                {
                    if start.elapsed() > within {
                        return None;
                    }
                }
                Err(_) => return None,
            }
        }
        Some(bytes)
    }

    pub(crate) fn message(&mut self, within: Duration) -> Option<Message> {
        let head = self.bytes(24, within)?;
        let word = |n: usize| u32::from_be_bytes(head[4 * n..4 * n + 4].try_into().unwrap());
        let length = word(0) as usize - 24;
        let mut payload = self.bytes(length.div_ceil(8) * 8, PATIENCE)?;
        assert!(payload[length..].iter().all(|&byte| byte == 0));
        payload.truncate(length);
        Some(Message {
            seconds: word(1),
            microseconds: word(2),
            sender: word(3) as i32,
            kind: word(4) as i32,
            payload,
        })
    }

    /// Whether the other side ends the connection in time.
    pub(crate) fn is_closed(&mut self) -> bool {
        let start = Instant::now();
        let mut buffer = [0; 4096];
        while start.elapsed() < PATIENCE {
            match self.socket.read(&mut buffer) {
                Ok(0) => return true,
                Ok(_) => {}
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(_) => return true,
            }
        }
        false
    }
}
