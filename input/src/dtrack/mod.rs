//! DTrack: ART's optical trackers, whose controller tells all bodies in a datagram a frame.
//!
//! ```text
//! UDP port --datagram--> Datagram (lines) --bodies, Flysticks--> DtrackStream --Sample--> hub
//! ```
//!
//! Lines are ASCII; places are in millimetres, attitudes are taken from the rotation matrices, which
//! are written column by column. Parsing is a pure function of the datagram; the driver's thread
//! alone knows a socket and a clock.

mod datagram;
pub(crate) mod driver;
mod stream;

pub use datagram::{Datagram, DtrackBody, Flystick, FlystickControls};
pub use driver::DtrackError;
pub use stream::DtrackStream;
