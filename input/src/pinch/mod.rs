//! PINCH gloves: Fakespace's gloves that tell which fingertips touch, on a serial line.
//!
//! ```text
//! port --bytes--> Decoder --ContactGroups--> PinchStream --Sample (hands 1 left, 2 right)--> hub
//!      <--Step--  startup, roll_call
//! ```
//!
//! The box sends the whole state at each change and is silent in between; it cannot be asked for
//! its state. So a state is believed until the next one comes, the device is lost, or a message is
//! damaged; and what a damaged message said is never believed.
//!
//! The arrows are pure functions of bytes and times; only the driver's thread knows a port and a
//! clock. The simulator speaks the other side of the line.

mod decoder;
pub(crate) mod driver;
mod groups;
mod message;
mod roll_call;
mod simulator;
mod startup;
mod stream;

pub use decoder::{Decoded, Decoder, DecoderCounts, LONGEST_MESSAGE};
pub use driver::PinchError;
pub use groups::{ContactGroups, GROUPS};
pub use message::{ContactMessage, MessageFormat, encode_text};
#[cfg(unix)]
pub use simulator::Simulator;
pub use simulator::{Faults, Motion, SimulatedPinch, SimulatorSettings};
pub use startup::{Answer, Command, Step, startup};
pub use stream::PinchStream;
