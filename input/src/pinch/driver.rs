//! The driver: one thread that listens to a box of PINCH gloves, whatever happens to its line.
//!
//! It opens the port, starts the box, reads it, and begins anew after an error, an unplugged cable
//! or a box that does not answer, for ever and with a pause in between. What it reads, it hands on
//! as it came, the answers to its commands too: they tell the stream how long a tick is.

use super::roll_call::RollCall;
use super::startup::{Answer, Command, Step, startup, timestamps};
use super::stream::PinchStream;
use crate::Stream;
use crate::device_thread::{DeviceThread, Stopped};
use crate::recording::DeviceEvent;
use crate::serial_line::{SerialError, SerialLine};
use sandtable_config::{Pinch, Side};
use std::convert::Infallible;
use std::time::{Duration, Instant};

/// Why PINCH gloves cannot be had just now.
#[derive(Debug, thiserror::Error)]
pub enum PinchError {
    /// Their line.
    #[error(transparent)]
    Line(#[from] SerialError),
    /// Nothing came back.
    #[error(
        "the PINCH box on {port} does not answer when asked {what}; check its power and the cable, \
         and that it is set to {baud} baud"
    )]
    NoAnswer {
        /// The port's path.
        port: String,
        /// What it was asked.
        what: &'static str,
        /// The rig's speed.
        baud: u32,
    },
    /// Bytes came, but no messages.
    #[error(
        "{port} sends bytes that are no messages of a PINCH box; check that it is one, and that it \
         is set to {baud} baud"
    )]
    NotUnderstood {
        /// The port's path.
        port: String,
        /// The rig's speed.
        baud: u32,
    },
    /// The box does not do what it must.
    #[error(
        "the PINCH box on {port} was asked {what} and answered {answer}; switch it off and on, and \
         write a longer `byte_pause` in the rig if that does not help"
    )]
    WrongAnswer {
        /// The port's path.
        port: String,
        /// What it was asked.
        what: &'static str,
        /// What it said.
        answer: Answer,
    },
    /// There is a box, and nothing else.
    #[error("no glove is plugged into the PINCH box on {port}; plug one in")]
    NoGloves {
        /// The port's path.
        port: String,
    },
}

/// The least time between two bytes that are to get into step: an answer takes some 30 ms.
const STEP_PAUSE: Duration = Duration::from_millis(100);

/// What ends a session.
enum End {
    Stopped,
    Failed(PinchError),
}

impl From<Stopped> for End {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}

impl From<SerialError> for End {
    fn from(error: SerialError) -> Self {
        Self::Failed(error.into())
    }
}

/// The driver's own state.
struct Driver {
    pinch: Pinch,
    stream: PinchStream,
}

/// Listens to a rig's PINCH gloves until its thread is to end.
pub(crate) fn run(pinch: &Pinch, thread: DeviceThread) {
    let mut driver = Driver {
        stream: PinchStream::new(pinch),
        pinch: pinch.clone(),
    };
    thread.run(|thread| match driver.session(thread) {
        End::Stopped => Ok(Stopped),
        End::Failed(error) => Err(error),
    });
}

impl Driver {
    /// From opening the port to losing it.
    fn session(&mut self, thread: &mut DeviceThread) -> End {
        let mut line = match SerialLine::open(&self.pinch.port, self.pinch.baud) {
            Ok(line) => line,
            Err(error) => return error.into(),
        };
        self.stream.restart();
        // Before the first byte: what the box answers belongs to this session.
        thread.outlet.event(DeviceEvent::Started);
        let started = self.start(thread, &mut line);
        match started.and_then(|()| self.listen(thread, &mut line)) {
            Ok(never) => match never {},
            Err(end) => end,
        }
    }

    fn start(&mut self, thread: &mut DeviceThread, line: &mut SerialLine) -> Result<(), End> {
        let before = self.stream.counts();
        let mut missing = Vec::new();
        for step in startup(&self.pinch) {
            tracing::debug!(device = thread.outlet.device(), "asking {}", step.what);
            let Some(answer) = self.ask(thread, line, &step)? else {
                let now = self.stream.counts();
                let understood = now.records > before.records;
                return Err(if !understood && now.stray_bytes > before.stray_bytes {
                    End::Failed(PinchError::NotUnderstood {
                        port: self.pinch.port.clone(),
                        baud: self.pinch.baud,
                    })
                } else {
                    self.no_answer(step.what)
                });
            };
            if let Answer::Glove {
                side,
                present: false,
            } = answer
            {
                missing.push(side);
            }
            let right = step.wanted.is_none_or(|wanted| wanted == answer);
            if !right && step.required {
                return Err(End::Failed(PinchError::WrongAnswer {
                    port: self.pinch.port.clone(),
                    what: step.what,
                    answer,
                }));
            }
            if !right || answer == Answer::Unknown && step.wanted.is_none() {
                tracing::info!(
                    device = thread.outlet.device(),
                    "asked {}, the box answered {answer}; going on without",
                    step.what
                );
            }
        }
        self.judge_gloves(thread, &missing)
    }

    fn judge_gloves(&self, thread: &DeviceThread, missing: &[Side]) -> Result<(), End> {
        match missing {
            [] => Ok(()),
            [side] => {
                let hand = match side {
                    Side::Left => "left",
                    Side::Right => "right",
                };
                let device = thread.outlet.device();
                tracing::warn!(
                    device,
                    "there is no {hand} glove; plug it in, or do without"
                );
                Ok(())
            }
            _ => Err(End::Failed(PinchError::NoGloves {
                port: self.pinch.port.clone(),
            })),
        }
    }

    /// Sends a step's command and waits for its answer; `None` where there is none in time.
    fn ask(
        &mut self,
        thread: &DeviceThread,
        line: &mut SerialLine,
        step: &Step,
    ) -> Result<Option<Answer>, End> {
        let within = self.pinch.answer_within;
        match step.command {
            Command::UntilAnswered(byte) => {
                let start = Instant::now();
                // Twice as long as an answer may take: the first byte may get none.
                while start.elapsed() < 2 * within {
                    line.write(&[byte])?;
                    let pause = self.pinch.byte_pause.max(STEP_PAUSE);
                    let answer = self.answer(thread, line, pause)?;
                    // What another host was answered may still lie in the line.
                    if answer.is_some() && answer == step.wanted {
                        return Ok(answer);
                    }
                }
                Ok(None)
            }
            Command::Pair([first, second]) => {
                line.write(&[first])?;
                let sent = Instant::now();
                while sent.elapsed() < self.pinch.byte_pause {
                    self.read(thread, line)?;
                }
                // What came before the command's end answers something else.
                self.stream.take_answer();
                line.write(&[second])?;
                self.answer(thread, line, within)
            }
        }
    }

    /// Reads until an answer has come, or that time is over.
    fn answer(
        &mut self,
        thread: &DeviceThread,
        line: &mut SerialLine,
        within: Duration,
    ) -> Result<Option<Answer>, End> {
        let start = Instant::now();
        loop {
            self.read(thread, line)?;
            let answer = self.stream.take_answer();
            if answer.is_some() || start.elapsed() >= within {
                return Ok(answer);
            }
        }
    }

    /// Reads what is there, waiting a little.
    fn read(&mut self, thread: &DeviceThread, line: &mut SerialLine) -> Result<(), End> {
        thread.pause(Duration::ZERO)?;
        let mut buffer = [0; 256];
        let count = line.read(&mut buffer)?;
        if count > 0 {
            let arrival = thread.outlet.now();
            thread
                .outlet
                .bytes(&buffer[..count], arrival, &mut self.stream);
        }
        thread.outlet.pass_time(&mut self.stream);
        Ok(())
    }

    fn listen(
        &mut self,
        thread: &mut DeviceThread,
        line: &mut SerialLine,
    ) -> Result<Infallible, End> {
        thread.streaming(&self.pinch.port);
        let start = Instant::now();
        let mut roll_call = RollCall::new(
            timestamps(&self.pinch),
            self.pinch.ask_every,
            self.pinch.byte_pause,
            self.pinch.answer_within,
            Duration::ZERO,
        );
        let mut messages = self.stream.counts().records;
        loop {
            self.read(thread, line)?;
            let now = start.elapsed();
            let now_messages = self.stream.counts().records;
            if now_messages > messages {
                messages = now_messages;
                roll_call.heard(now);
            }
            if let Some(byte) = roll_call.byte_to_send(now) {
                line.write(&[byte])?;
            }
            if roll_call.is_missing(now) {
                return Err(self.no_answer("whether it is there"));
            }
        }
    }

    fn no_answer(&self, what: &'static str) -> End {
        End::Failed(PinchError::NoAnswer {
            port: self.pinch.port.clone(),
            what,
            baud: self.pinch.baud,
        })
    }
}
