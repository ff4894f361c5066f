//! Simulated devices: the other side of a line.
//!
//! A [`SimulatedDevice`] is a pure state machine with a clock that is handed in; [`Simulator`] runs
//! one on a pseudo-terminal, so that the real driver can open it as it would a serial port. Each
//! kind of device has its own beside its driver.

mod line;
mod mixed;
#[cfg(unix)]
mod pty;

pub(crate) use line::SimulatedLine;
pub(crate) use mixed::mixed;
#[cfg(unix)]
pub use pty::{Simulator, SimulatorError};

use std::fmt::Debug;
use std::time::Duration;

/// A device without a port: takes what a host sends, gives what its line has carried so far.
pub trait SimulatedDevice: Debug + Send {
    /// Takes what the host has sent by `now`.
    fn receive(&mut self, bytes: &[u8], now: Duration);

    /// The bytes that the line has carried by `now` and not given before.
    fn send(&mut self, now: Duration) -> Vec<u8>;

    /// How long nothing more comes after `now`, if the host stays silent; `None` for ever.
    fn quiet_for(&self, now: Duration) -> Option<Duration>;
}
