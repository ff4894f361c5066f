//! The driver: one thread that keeps a Flock streaming, whatever happens to its line.
//!
//! It opens the port, starts the device, reads it, and begins anew after a silence, an error or an
//! unplugged cable, for ever and with a pause in between. What it reads it hands on as it came.

use super::startup::{ANSWER_WITHIN, Action, EXAMINE_ERROR, EXAMINE_STATUS, startup, stop_bytes};
use super::status::{SYSTEM_STATUS_LENGTH, error_in_words, system_status_problem};
use super::stream::FlockStream;
use crate::Stream;
use crate::devices::{Condition, Outlet};
use crate::recording::DeviceEvent;
use crossbeam_channel::{Receiver, RecvTimeoutError};
use sandtable_config::Flock;
use sandtable_pose::Nanos;
use serialport::{ClearBuffer, SerialPort};
use std::convert::Infallible;
use std::io::{self, ErrorKind};
use std::time::{Duration, Instant};

/// Why a Flock is not streaming just now.
#[derive(Debug, thiserror::Error)]
pub enum FlockError {
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
    /// Nothing came for two seconds.
    #[error("{port} has been silent for 2 s; check that the Flock is on and set to FLY")]
    Silent {
        /// The port's path.
        port: String,
    },
    /// Bytes come, but no records.
    #[error(
        "{port} sends bytes, but no records of {whom} came in 2 s; check that the switches say \
         {baud} baud, and `group` and `birds` in the rig"
    )]
    NoRecords {
        /// The port's path.
        port: String,
        /// Whose records are missing.
        whom: String,
        /// The rig's speed.
        baud: u32,
    },
    /// The system status did not come.
    #[error(
        "the Flock on {port} does not answer ({got} of {SYSTEM_STATUS_LENGTH} status bytes came); \
         check its power, the cable, and that its switches say {baud} baud"
    )]
    NoAnswer {
        /// The port's path.
        port: String,
        /// How many bytes came.
        got: usize,
        /// The rig's speed.
        baud: u32,
    },
    /// A unit is not as the rig says.
    #[error("the Flock on {port} is not ready: {problem}{said}")]
    NotReady {
        /// The port's path.
        port: String,
        /// What its status shows.
        problem: String,
        /// What it says of itself, where it does.
        said: String,
    },
}

/// Silence after which the device is started anew.
const SILENCE: Duration = Duration::from_secs(2);

/// The pause before a port is tried again.
const RETRY: Duration = Duration::from_millis(500);

/// The least time between two lines of the log.
const LOG_PAUSE: Duration = Duration::from_secs(10);

/// How long one read waits, and so how long a stop may take.
const READ_TIMEOUT: Duration = Duration::from_millis(50);

/// Ends when the other side is dropped.
pub(crate) type Stop = Receiver<Infallible>;

/// The thread's own state.
pub(crate) struct Driver {
    flock: Flock,
    stream: FlockStream,
    outlet: Outlet,
    stop: Stop,
    modem_lines_told: bool,
    logged: Option<(Instant, String)>,
}

/// Why a session ended without an error.
struct Stopped;

impl Driver {
    pub(crate) fn new(flock: &Flock, outlet: Outlet, stop: Stop) -> Self {
        Self {
            stream: FlockStream::new(flock),
            flock: flock.clone(),
            outlet,
            stop,
            modem_lines_told: false,
            logged: None,
        }
    }

    /// Runs until it is stopped.
    pub(crate) fn run(mut self) {
        loop {
            self.outlet.set_condition(Condition::Starting);
            match self.session() {
                Ok(Stopped) => return,
                Err(error) => self.report(&error),
            }
            if self.pause(RETRY).is_err() {
                return;
            }
        }
    }

    /// From opening the port to losing it.
    fn session(&mut self) -> Result<Stopped, FlockError> {
        let mut port = self.open()?;
        let result = self.start_and_stream(port.as_mut());
        // Whatever happened: a device left behind should neither send nor transmit. One that is
        // gone cannot be told, which is no news.
        let _ = port.write_all(&stop_bytes());
        let _ = port.flush();
        result
    }

    fn open(&mut self) -> Result<Box<dyn SerialPort>, FlockError> {
        let mut port = serialport::new(&self.flock.port, self.flock.baud)
            .timeout(READ_TIMEOUT)
            .open()
            .map_err(|error| self.cannot_open(&error))?;
        // Most systems raise RTS on opening, and RTS holds the units in reset.
        if let Err(error) = port.write_request_to_send(false) {
            self.tell_modem_lines(&error);
        }
        Ok(port)
    }

    fn cannot_open(&self, error: &serialport::Error) -> FlockError {
        use serialport::ErrorKind as Serial;
        let remedy = match error.kind() {
            Serial::Io(ErrorKind::NotFound) => {
                "plug the device in or name its port; `sandtable doctor` lists the ports"
            }
            Serial::Io(ErrorKind::PermissionDenied) => {
                "join the port's group: `sudo usermod -aG dialout $USER`, then log in again"
            }
            Serial::NoDevice => "another program has it open; end that one",
            _ => "name a serial port; `sandtable doctor` lists them",
        };
        FlockError::Open {
            port: self.flock.port.clone(),
            problem: error.description.clone(),
            remedy,
        }
    }

    fn tell_modem_lines(&mut self, error: &serialport::Error) {
        if !self.modem_lines_told {
            self.modem_lines_told = true;
            tracing::warn!(
                device = self.outlet.device(),
                "{} has no modem lines ({error}); going on without a reset by RTS",
                self.flock.port
            );
        }
    }

    fn start_and_stream(&mut self, port: &mut dyn SerialPort) -> Result<Stopped, FlockError> {
        for step in startup(&self.flock) {
            tracing::debug!(device = self.outlet.device(), step = step.what);
            let mut silence = step.silence;
            match step.action {
                Action::Send(bytes) => self.write(port, &bytes)?,
                Action::ExamineStatus => self.check_status(port)?,
                Action::PulseRts(lasting) => match port.write_request_to_send(true) {
                    Ok(()) => {
                        if self.pause(lasting).is_err() {
                            return Ok(Stopped);
                        }
                        if let Err(error) = port.write_request_to_send(false) {
                            self.tell_modem_lines(&error);
                        }
                    }
                    Err(error) => {
                        self.tell_modem_lines(&error);
                        silence = Duration::ZERO;
                    }
                },
            }
            if !silence.is_zero() {
                if self.pause(silence).is_err() {
                    return Ok(Stopped);
                }
                port.clear(ClearBuffer::Input)
                    .map_err(|error| self.gone(error.into()))?;
            }
        }
        self.stream.restart();
        self.outlet.event(DeviceEvent::Started);
        self.read_stream(port)
    }

    fn check_status(&mut self, port: &mut dyn SerialPort) -> Result<(), FlockError> {
        self.write(port, &EXAMINE_STATUS)?;
        let mut status = [0; SYSTEM_STATUS_LENGTH];
        let got = self.answer(port, &mut status)?;
        if got < status.len() {
            return Err(FlockError::NoAnswer {
                port: self.flock.port.clone(),
                got,
                baud: self.flock.baud,
            });
        }
        let birds = self.flock.addresses();
        let Some(problem) = system_status_problem(&status, self.flock.units(), &birds) else {
            return Ok(());
        };
        self.write(port, &EXAMINE_ERROR)?;
        let mut code = [0];
        let said = match self.answer(port, &mut code)? {
            1 if code[0] != 0 => {
                format!(". It says: {} (error {})", error_in_words(code[0]), code[0])
            }
            _ => String::new(),
        };
        Err(FlockError::NotReady {
            port: self.flock.port.clone(),
            problem,
            said,
        })
    }

    /// Fills `buffer` from what comes in time; returns how much did.
    fn answer(&self, port: &mut dyn SerialPort, buffer: &mut [u8]) -> Result<usize, FlockError> {
        let until = Instant::now() + ANSWER_WITHIN;
        let mut got = 0;
        while got < buffer.len() && Instant::now() < until {
            got += self.read(port, &mut buffer[got..])?;
        }
        Ok(got)
    }

    fn read_stream(&mut self, port: &mut dyn SerialPort) -> Result<Stopped, FlockError> {
        let mut buffer = [0; 512];
        let start = Instant::now();
        let (mut heard, mut understood) = (start, start);
        let mut complete = false;
        let mut records = self.stream.counts().records;
        loop {
            if self.pause(Duration::ZERO).is_err() {
                return Ok(Stopped);
            }
            let count = self.read(port, &mut buffer)?;
            let arrival: Nanos = self.outlet.now();
            if count > 0 {
                heard = Instant::now();
                self.outlet
                    .bytes(&buffer[..count], arrival, &mut self.stream);
            }
            let now_records = self.stream.counts().records;
            if now_records > records {
                records = now_records;
                understood = Instant::now();
            }
            if heard.elapsed() >= SILENCE {
                return Err(FlockError::Silent {
                    port: self.flock.port.clone(),
                });
            }
            // A lost command leaves a bird in another format, or the birds without addresses.
            if understood.elapsed() >= SILENCE {
                return Err(self.no_records("any bird".to_owned()));
            }
            if !complete {
                match self.stream.missing_bird() {
                    None => {
                        complete = true;
                        self.streaming();
                    }
                    Some(bird) if start.elapsed() >= SILENCE => {
                        return Err(self.no_records(format!("bird {bird}")));
                    }
                    Some(_) => {}
                }
            }
        }
    }

    fn no_records(&self, whom: String) -> FlockError {
        FlockError::NoRecords {
            port: self.flock.port.clone(),
            whom,
            baud: self.flock.baud,
        }
    }

    /// Reads what is there, waiting a little; nothing is 0 bytes, a port that is gone an error.
    fn read(&self, port: &mut dyn SerialPort, buffer: &mut [u8]) -> Result<usize, FlockError> {
        match port.read(buffer) {
            // A port that is there times out instead; this one was unplugged.
            Ok(0) => Err(self.gone(ErrorKind::UnexpectedEof.into())),
            Ok(count) => Ok(count),
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => Ok(0),
                _ => Err(self.gone(error)),
            },
        }
    }

    fn write(&self, port: &mut dyn SerialPort, bytes: &[u8]) -> Result<(), FlockError> {
        port.write_all(bytes).map_err(|error| self.gone(error))
    }

    fn gone(&self, source: io::Error) -> FlockError {
        FlockError::Gone {
            port: self.flock.port.clone(),
            source,
        }
    }

    fn streaming(&mut self) {
        self.outlet.set_condition(Condition::Streaming);
        if self.logged.take().is_some() {
            tracing::info!(
                device = self.outlet.device(),
                "streaming from {}",
                self.flock.port
            );
        }
    }

    /// Shows the error, and logs it where it is news.
    fn report(&mut self, error: &FlockError) {
        let text = error.to_string();
        let known = self
            .logged
            .as_ref()
            .is_some_and(|(when, logged)| *logged == text || when.elapsed() < LOG_PAUSE);
        if !known {
            tracing::warn!(device = self.outlet.device(), "{text}");
            self.logged = Some((Instant::now(), text.clone()));
        }
        self.outlet.event(DeviceEvent::Lost);
        self.outlet.set_condition(Condition::Waiting(text));
    }

    /// Waits, or fails at once where the driver is to stop.
    fn pause(&self, lasting: Duration) -> Result<(), Stopped> {
        match self.stop.recv_timeout(lasting) {
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => Err(Stopped),
            Ok(never) => match never {},
        }
    }
}
