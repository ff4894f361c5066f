//! Navigation: from wishes to where the viewer is. Pure: no clock, no device, no window.
//!
//! ```text
//! FlightAxes (−1..1) + seconds --FlyCamera---> eye and attitude in the world   (desktop)
//!                              \-TableFlight--> Placement of the world on the table
//! a hand's poses --carried-----> Placement of the world that it holds
//!                \-hand_flight-> FlightAxes
//! ```
//!
//! One long step and many short ones lead along the same path: velocities are integrated over the
//! step while it turns, not held at their first value.

mod fly;
mod hand;
mod path;
mod table;

pub(crate) use fly::{FlyCamera, Pace};
pub(crate) use hand::{carried, hand_flight};
pub(crate) use table::TableFlight;
