//! A device's thread: one session after another, for ever, until it is stopped.

use crate::devices::{Condition, Outlet};
use crate::recording::DeviceEvent;
use crossbeam_channel::{Receiver, RecvTimeoutError};
use std::convert::Infallible;
use std::fmt::Display;
use std::time::{Duration, Instant};

/// The pause before a device is tried again.
const RETRY: Duration = Duration::from_millis(500);

/// The least time between two lines of the log.
const LOG_PAUSE: Duration = Duration::from_secs(10);

/// Ends when the other side is dropped.
pub(crate) type Stop = Receiver<Infallible>;

/// The thread is to end.
pub(crate) struct Stopped;

/// What a device's driver has of its thread.
pub(crate) struct DeviceThread {
    pub(crate) outlet: Outlet,
    stop: Stop,
    logged: Option<(Instant, String)>,
}

impl DeviceThread {
    pub(crate) fn new(outlet: Outlet, stop: Stop) -> Self {
        Self {
            outlet,
            stop,
            logged: None,
        }
    }

    /// Runs sessions, each from opening the device to losing it, with a pause in between.
    pub(crate) fn run<E: Display>(
        mut self,
        mut session: impl FnMut(&mut Self) -> Result<Stopped, E>,
    ) {
        loop {
            self.outlet.set_condition(Condition::Starting);
            match session(&mut self) {
                Ok(Stopped) => return,
                Err(error) => self.report(&error.to_string()),
            }
            if self.pause(RETRY).is_err() {
                return;
            }
        }
    }

    /// Waits, or fails at once where the thread is to end.
    pub(crate) fn pause(&self, lasting: Duration) -> Result<(), Stopped> {
        match self.stop.recv_timeout(lasting) {
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => Err(Stopped),
            Ok(never) => match never {},
        }
    }

    /// Says that all is well now, and from where.
    pub(crate) fn streaming(&mut self, from: &str) {
        self.outlet.set_condition(Condition::Streaming);
        if self.logged.take().is_some() {
            tracing::info!(device = self.outlet.device(), "streaming from {from}");
        }
    }

    /// Shows the error, and logs it where it is news.
    fn report(&mut self, text: &str) {
        let known = self
            .logged
            .as_ref()
            .is_some_and(|(when, logged)| logged == text || when.elapsed() < LOG_PAUSE);
        if !known {
            tracing::warn!(device = self.outlet.device(), "{text}");
            self.logged = Some((Instant::now(), text.to_owned()));
        }
        self.outlet.event(DeviceEvent::Lost);
        self.outlet
            .set_condition(Condition::Waiting(text.to_owned()));
    }
}
