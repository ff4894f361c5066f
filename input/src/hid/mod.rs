//! HID devices: which one is meant, and its reports until it goes away.
//!
//! ```text
//! SystemBus --Found--> choose(Wanted) --open--> reports --bytes--> Stream
//! ```
//!
//! Only `bus` knows the system's interface; the driver knows two traits, so that tests can be the
//! device.

mod bus;
mod choice;
pub(crate) mod driver;
mod error;

pub(crate) use bus::SystemBus;
pub(crate) use choice::Wanted;
pub use error::{HidError, udev_rule};
