//! Input: devices to timestamped samples. To be filled.

mod flight;
pub mod flock;

pub use flight::FlightAxes;
