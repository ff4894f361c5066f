//! The Flock of Birds: Ascension's magnetic trackers on a serial line.
//!
//! ```text
//! port --bytes--> Decoder --Record--> Scale --Rigid--> gate --Sample (table, m)--> hub
//!      <--Step--  startup
//! ```
//!
//! The arrows are pure functions of bytes and times; only the driver's thread knows a port and a
//! clock. The simulator speaks the other side of the line.

mod decoder;
pub(crate) mod driver;
mod format;
mod measurement;
mod record;
mod simulator;
mod startup;
mod status;
mod stream;

pub use decoder::{Decoder, DecoderCounts};
pub use driver::FlockError;
pub use measurement::Scale;
pub use record::{LONGEST_RECORD, Layout, Record, Words, buttons_pressed};
#[cfg(unix)]
pub use simulator::Simulator;
pub use simulator::{Faults, Motion, RecordedMotion, SimulatedFlock, SimulatorSettings};
pub use startup::{Action, Step, hemisphere_code, startup, stop_bytes};
pub use status::{UnitStatus, error_in_words, system_status_length, system_status_problem};
pub use stream::{FROZEN_AFTER, FlockStream, layout, record_period};
