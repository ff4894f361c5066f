//! The driver: one thread that keeps a Flock streaming, whatever happens to its line.
//!
//! It opens the port, starts the device, reads it, and begins anew after a silence, an error or an
//! unplugged cable, for ever and with a pause in between. What it reads it hands on as it came.

use super::startup::{
    ANSWER_WITHIN, Action, EXAMINE_ERROR, EXAMINE_STATUS, POINT, startup, stop_bytes,
};
use super::status::{error_in_words, system_status_length, system_status_problem};
use super::stream::{FlockStream, record_period};
use crate::Stream;
use crate::device_thread::{DeviceThread, Stopped};
use crate::recording::DeviceEvent;
use crate::serial_line::{SerialError, SerialLine};
use sandtable_config::{Flock, FlockMode};
use std::time::{Duration, Instant};

/// Why a Flock is not streaming just now.
#[derive(Debug, thiserror::Error)]
pub enum FlockError {
    /// Its line.
    #[error(transparent)]
    Line(#[from] SerialError),
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
        "the Flock on {port} does not answer ({got} of {expected} status bytes came); \
         check its power, the cable, and that its switches say {baud} baud"
    )]
    NoAnswer {
        /// The port's path.
        port: String,
        /// How many bytes came.
        got: usize,
        /// How many its addressing has.
        expected: usize,
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

/// The driver's own state.
struct Driver {
    flock: Flock,
    stream: FlockStream,
    modem_lines_told: bool,
}

/// Keeps a Flock streaming until its thread is to end.
pub(crate) fn run(flock: &Flock, thread: DeviceThread) {
    let mut driver = Driver {
        stream: FlockStream::new(flock),
        flock: flock.clone(),
        modem_lines_told: false,
    };
    thread.run(|thread| driver.session(thread));
}

/// Asking for records, one of each bird at a time.
struct Pointing {
    birds: u64,
    /// Not faster than they are measured: a bird gives the last one again until then.
    period: Duration,
    asked: Instant,
    /// Records there were then.
    records: u64,
}

impl Pointing {
    /// How long an answer is waited for before it counts as lost, in periods.
    const PATIENCE: u32 = 4;

    fn new(flock: &Flock, now: Instant) -> Option<Self> {
        let period = record_period(flock);
        (flock.mode == FlockMode::Point).then(|| Self {
            birds: u64::from(flock.birds),
            period,
            asked: now - period * Self::PATIENCE,
            records: 0,
        })
    }

    /// How long not to read yet, as all has come and the next question is not due.
    fn wait(&self, records: u64) -> Duration {
        if records >= self.records + self.birds {
            self.period.saturating_sub(self.asked.elapsed())
        } else {
            Duration::ZERO
        }
    }

    /// Whether to ask now; it counts as asked then.
    fn is_due(&mut self, records: u64) -> bool {
        let all = records >= self.records + self.birds && self.asked.elapsed() >= self.period;
        let due = all || self.asked.elapsed() >= self.period * Self::PATIENCE;
        if due {
            self.asked = Instant::now();
            self.records = records;
        }
        due
    }
}

impl Driver {
    /// From opening the port to losing it.
    fn session(&mut self, thread: &mut DeviceThread) -> Result<Stopped, FlockError> {
        let mut line = SerialLine::open(&self.flock.port, self.flock.baud)?;
        // Most systems raise RTS on opening, and RTS holds the units in reset.
        if let Err(error) = line.set_rts(false) {
            self.tell_modem_lines(thread, &error);
        }
        let result = self.start_and_stream(thread, &mut line);
        // Whatever happened: a device left behind should neither send nor transmit.
        line.write_last(&stop_bytes());
        result
    }

    fn tell_modem_lines(&mut self, thread: &DeviceThread, error: &serialport::Error) {
        if !self.modem_lines_told {
            self.modem_lines_told = true;
            tracing::warn!(
                device = thread.outlet.device(),
                "{} has no modem lines ({error}); going on without a reset by RTS",
                self.flock.port
            );
        }
    }

    fn start_and_stream(
        &mut self,
        thread: &mut DeviceThread,
        line: &mut SerialLine,
    ) -> Result<Stopped, FlockError> {
        for step in startup(&self.flock) {
            tracing::debug!(device = thread.outlet.device(), step = step.what);
            let mut silence = step.silence;
            match step.action {
                Action::Send(bytes) => line.write(&bytes)?,
                Action::ExamineStatus => self.check_status(line)?,
                Action::PulseRts(lasting) => match line.set_rts(true) {
                    Ok(()) => {
                        if thread.pause(lasting).is_err() {
                            return Ok(Stopped);
                        }
                        if let Err(error) = line.set_rts(false) {
                            self.tell_modem_lines(thread, &error);
                        }
                    }
                    Err(error) => {
                        self.tell_modem_lines(thread, &error);
                        silence = Duration::ZERO;
                    }
                },
            }
            if !silence.is_zero() {
                if thread.pause(silence).is_err() {
                    return Ok(Stopped);
                }
                line.discard()?;
            }
        }
        self.stream.restart();
        thread.outlet.event(DeviceEvent::Started);
        self.read_stream(thread, line)
    }

    fn check_status(&mut self, line: &mut SerialLine) -> Result<(), FlockError> {
        line.write(&EXAMINE_STATUS)?;
        let mut status = vec![0; system_status_length(self.flock.addressing)];
        let got = line.answer(&mut status, ANSWER_WITHIN)?;
        if got < status.len() {
            return Err(FlockError::NoAnswer {
                port: self.flock.port.clone(),
                got,
                expected: status.len(),
                baud: self.flock.baud,
            });
        }
        let birds = self.flock.addresses();
        let Some(problem) = system_status_problem(&status, self.flock.units(), &birds) else {
            return Ok(());
        };
        line.write(&EXAMINE_ERROR)?;
        let mut code = [0];
        let said = match line.answer(&mut code, ANSWER_WITHIN)? {
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

    fn read_stream(
        &mut self,
        thread: &mut DeviceThread,
        line: &mut SerialLine,
    ) -> Result<Stopped, FlockError> {
        let mut buffer = [0; 512];
        let start = Instant::now();
        let (mut heard, mut understood) = (start, start);
        let mut complete = false;
        let mut records = self.stream.counts().records;
        let mut pointing = Pointing::new(&self.flock, start);
        loop {
            if thread.pause(Duration::ZERO).is_err() {
                return Ok(Stopped);
            }
            if let Some(pointing) = &mut pointing {
                if thread.pause(pointing.wait(records)).is_err() {
                    return Ok(Stopped);
                }
                if pointing.is_due(records) {
                    line.write(&[POINT])?;
                }
            }
            let count = line.read(&mut buffer)?;
            let arrival = thread.outlet.now();
            if count > 0 {
                heard = Instant::now();
                thread
                    .outlet
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
                        thread.streaming(&self.flock.port);
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
}
