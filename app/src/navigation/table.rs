//! Moving the world on the table.

use super::path::way;
use glam::DVec3;
use sandtable_input::FlightAxes;
use sandtable_view::Placement;
use std::f64::consts::{LN_2, TAU};

/// Growth of the scale at an axis value of 1: it doubles in a second.
const SCALE_RATE: f64 = LN_2;

/// Growth of the exaggeration at an axis value of 1: it doubles in two seconds.
const EXAGGERATION_RATE: f64 = 0.5 * LN_2;

/// World metres per table metre that make sense: from a stone to the planet.
const SCALES: [f64; 2] = [1e-2, 1e8];

/// Vertical exaggerations that make sense.
const EXAGGERATIONS: [f64; 2] = [0.1, 50.0];

/// A placement that is flown: the people at the table move over the world, and the picture moves
/// the other way.
///
/// * *right*, *forward*: over the ground, along the table's axes;
/// * *up*: higher above it, so more of the world comes onto the glass;
/// * *yaw*: the table's heading, about the middle of the glass;
/// * *pitch*: the glass rises (nose up) or sinks through the relief;
/// * *roll*: more (right) or less vertical exaggeration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TableFlight {
    /// How the world lies on the table.
    pub(crate) placement: Placement,
    /// Table metres per second that an axis value of 1 moves.
    pub(crate) speed: f64,
    /// Turn at an axis value of 1, in radians per second.
    pub(crate) turn_rate: f64,
}

impl TableFlight {
    /// Moves for `seconds` as `axes` ask, `boost` times as fast over the ground.
    pub(crate) fn advance(&mut self, axes: &FlightAxes, boost: f64, seconds: f64) {
        let seconds = seconds.max(0.0);
        let (start, turn_rate) = (self.placement, self.turn_rate);
        let after = |t: f64| Placement {
            anchor: start.anchor,
            yaw: start.yaw + turn_rate * axes.yaw * t,
            scale: limited(start.scale * (SCALE_RATE * axes.up * t).exp(), SCALES),
            exaggeration: limited(
                start.exaggeration * (EXAGGERATION_RATE * axes.roll * t).exp(),
                EXAGGERATIONS,
            ),
        };
        let table_velocity = self.speed * boost * DVec3::new(axes.right, axes.forward, axes.pitch);
        let moved = way(seconds, |t| {
            after(t).world_vector_from_table(table_velocity)
        });
        self.placement = after(seconds);
        self.placement.anchor += moved;
        self.placement.yaw = self.placement.yaw.rem_euclid(TAU);
    }

    /// Sets scale and exaggeration, each within what makes sense.
    pub(crate) fn set_scale(&mut self, scale: f64, exaggeration: f64) {
        if scale.is_finite() && exaggeration.is_finite() {
            self.placement.scale = limited(scale, SCALES);
            self.placement.exaggeration = limited(exaggeration, EXAGGERATIONS);
        }
    }
}

fn limited(value: f64, [least, most]: [f64; 2]) -> f64 {
    value.clamp(least, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    fn flight() -> TableFlight {
        TableFlight {
            placement: Placement {
                anchor: DVec3::new(5000.0, 4000.0, 900.0),
                yaw: 0.0,
                scale: 10_000.0,
                exaggeration: 2.0,
            },
            speed: 0.25,
            turn_rate: FRAC_PI_4,
        }
    }

    fn near(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-9, "{a} is not {b}");
    }

    #[test]
    fn forward_moves_over_the_world_along_the_tables_heading() {
        let mut flight = flight();
        flight.placement.yaw = FRAC_PI_2;
        let axes = FlightAxes {
            forward: 1.0,
            pitch: 0.5,
            ..Default::default()
        };
        flight.advance(&axes, 2.0, 1.0);
        // Half a table metre is 5 km eastwards; a quarter one upwards is 2.5 km over two.
        near(
            flight.placement.anchor,
            DVec3::new(10_000.0, 4000.0, 2150.0),
        );
    }

    #[test]
    fn a_second_up_doubles_what_the_glass_shows_about_its_middle() {
        let mut flight = flight();
        let axes = FlightAxes {
            up: 1.0,
            ..Default::default()
        };
        flight.advance(&axes, 1.0, 1.0);
        assert!((flight.placement.scale - 20_000.0).abs() < 1e-9);
        near(flight.placement.anchor, self::flight().placement.anchor);
        flight.advance(&axes, 1.0, 1e6);
        assert_eq!(flight.placement.scale, SCALES[1]);
    }

    #[test]
    fn splitting_a_step_does_not_change_the_path() {
        let axes = FlightAxes {
            right: 0.7,
            forward: -1.0,
            up: 0.4,
            yaw: 0.9,
            pitch: 1.0,
            roll: -0.6,
        };
        let (mut whole, mut split) = (flight(), flight());
        whole.advance(&axes, 1.0, 0.1);
        for _ in 0..8 {
            split.advance(&axes, 1.0, 0.0125);
        }
        near(whole.placement.anchor, split.placement.anchor);
        assert!((whole.placement.scale / split.placement.scale - 1.0).abs() < 1e-12);
        assert!((whole.placement.yaw - split.placement.yaw).abs() < 1e-12);
    }

    #[test]
    fn nonsense_scales_are_kept_out() {
        let mut flight = flight();
        flight.set_scale(f64::NAN, 1.0);
        assert_eq!(flight, self::flight());
        flight.set_scale(-5.0, 0.0);
        assert_eq!(
            [flight.placement.scale, flight.placement.exaggeration],
            [SCALES[0], EXAGGERATIONS[0]]
        );
    }
}
