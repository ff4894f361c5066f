//! Flight: what every device that flies asks for, in one form.

/// How a device asks to move, each axis from −1 to 1: the share of the speed in force.
///
/// The frame is the viewer's: right, forward and up as the viewer sees them, whatever the heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlightAxes {
    /// Sideways, right positive.
    pub right: f64,
    /// Forward positive.
    pub forward: f64,
    /// Up positive.
    pub up: f64,
    /// Turn of the heading, clockwise seen from above positive.
    pub yaw: f64,
    /// Nose up positive.
    pub pitch: f64,
    /// Right wing down positive.
    pub roll: f64,
}
