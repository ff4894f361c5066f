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

impl FlightAxes {
    /// The sum of two wishes, each axis kept within −1 to 1.
    #[must_use]
    pub fn combined(self, other: Self) -> Self {
        let sum = |a: f64, b: f64| (a + b).clamp(-1.0, 1.0);
        Self {
            right: sum(self.right, other.right),
            forward: sum(self.forward, other.forward),
            up: sum(self.up, other.up),
            yaw: sum(self.yaw, other.yaw),
            pitch: sum(self.pitch, other.pitch),
            roll: sum(self.roll, other.roll),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_wishes_add_up_to_no_more_than_one_full_one() {
        let axes = |right, yaw| FlightAxes {
            right,
            yaw,
            ..FlightAxes::default()
        };
        assert_eq!(axes(0.7, 0.5).combined(axes(0.7, -0.5)), axes(1.0, 0.0));
    }
}
