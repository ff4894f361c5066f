//! A serial line: opened with remedies, read without waiting long, and gone when it is unplugged.

use serialport::{ClearBuffer, SerialPort};
use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};

/// How long one read waits, and so how long a stop may take.
const READ_TIMEOUT: Duration = Duration::from_millis(50);

/// What is wrong with a serial line.
#[derive(Debug, thiserror::Error)]
pub enum SerialError {
    /// The port cannot be opened.
    #[error("cannot open {port} ({problem}); {remedy}")]
    Open {
        /// The port's path.
        port: String,
        /// What the system says.
        problem: String,
        /// What helps.
        remedy: &'static str,
    },
    /// The port was open and is gone.
    #[error("{port} is gone ({source}); plug the device in again")]
    Gone {
        /// The port's path.
        port: String,
        /// What the system says.
        source: io::Error,
    },
}

/// An open port of 8 data bits, no parity and one stop bit, without flow control: a byte of data
/// may be that of XON or XOFF.
pub(crate) struct SerialLine {
    path: String,
    port: Box<dyn SerialPort>,
}

impl SerialLine {
    pub(crate) fn open(path: &str, baud: u32) -> Result<Self, SerialError> {
        let port = serialport::new(path, baud)
            .timeout(READ_TIMEOUT)
            .open()
            .map_err(|error| cannot_open(path, &error))?;
        Ok(Self {
            path: path.to_owned(),
            port,
        })
    }

    /// Sets RTS; a pseudo-terminal has none.
    pub(crate) fn set_rts(&mut self, high: bool) -> Result<(), serialport::Error> {
        self.port.write_request_to_send(high)
    }

    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<(), SerialError> {
        self.port.write_all(bytes).map_err(|error| self.gone(error))
    }

    /// Writes `bytes` and waits until they are out; one that is gone cannot be told, which is no
    /// news.
    pub(crate) fn write_last(&mut self, bytes: &[u8]) {
        let _ = self.port.write_all(bytes);
        let _ = self.port.flush();
    }

    /// Reads what is there, waiting a little; nothing is 0 bytes.
    pub(crate) fn read(&mut self, buffer: &mut [u8]) -> Result<usize, SerialError> {
        match self.port.read(buffer) {
            // A port that is there times out instead; this one was unplugged.
            Ok(0) => Err(self.gone(ErrorKind::UnexpectedEof.into())),
            Ok(count) => Ok(count),
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => Ok(0),
                _ => Err(self.gone(error)),
            },
        }
    }

    /// Fills `buffer` from what comes `within` that time; returns how much did.
    pub(crate) fn answer(
        &mut self,
        buffer: &mut [u8],
        within: Duration,
    ) -> Result<usize, SerialError> {
        let until = Instant::now() + within;
        let mut got = 0;
        while got < buffer.len() && Instant::now() < until {
            got += self.read(&mut buffer[got..])?;
        }
        Ok(got)
    }

    /// Discards what has come and was not read.
    pub(crate) fn discard(&mut self) -> Result<(), SerialError> {
        self.port
            .clear(ClearBuffer::Input)
            .map_err(|error| self.gone(error.into()))
    }

    fn gone(&self, source: io::Error) -> SerialError {
        SerialError::Gone {
            port: self.path.clone(),
            source,
        }
    }
}

fn cannot_open(path: &str, error: &serialport::Error) -> SerialError {
    use serialport::ErrorKind as Serial;
    let remedy = match error.kind() {
        Serial::Io(ErrorKind::NotFound) => {
            "plug the device in or name its port; `sandtable doctor` lists the ports"
        }
        Serial::Io(ErrorKind::PermissionDenied) => {
            "join the port's group: `sudo usermod -aG dialout $USER`, then log in again"
        }
        Serial::NoDevice => {
            "another program, or another device of the rig, has it open: end that program, or give each device a port of its own"
        }
        _ => "name a serial port; `sandtable doctor` lists them",
    };
    SerialError::Open {
        port: path.to_owned(),
        problem: error.description.clone(),
        remedy,
    }
}
