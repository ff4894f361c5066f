//! Input: devices to timestamped samples. To be filled.

mod flight;

pub use flight::FlightAxes;
