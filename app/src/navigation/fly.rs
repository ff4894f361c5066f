//! Flying a camera with six degrees of freedom.

use super::path::way;
use glam::DVec3;
use sandtable_input::FlightAxes;
use sandtable_view::Attitude;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Share by which one notch of the wheel changes the speed.
const NOTCH: f64 = 1.25;

/// How fast an axis value of 1 flies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pace {
    /// Always as fast, in metres per second.
    Constant(f64),
    /// In proportion to the height above ground, so that the picture flows past evenly.
    WithHeight {
        /// Metres per second for each metre above ground.
        per_second: f64,
        /// Metres per second that it never falls below: on the ground, and off the terrain.
        least: f64,
    },
}

impl Pace {
    /// Metres per second at `height` metres above ground; `None` off the terrain.
    pub(crate) fn speed(self, height: Option<f64>) -> f64 {
        match self {
            Self::Constant(speed) => speed,
            Self::WithHeight { per_second, least } => {
                height.map_or(least, |height| (height * per_second).max(least))
            }
        }
    }

    /// Faster by so many notches of the wheel, or slower where negative.
    #[must_use]
    pub(crate) fn faster(self, notches: f64) -> Self {
        let factor = NOTCH.powf(notches);
        match self {
            Self::Constant(speed) => Self::Constant((speed * factor).clamp(0.1, 1e6)),
            Self::WithHeight { per_second, least } => Self::WithHeight {
                per_second: (per_second * factor).clamp(1e-3, 1e3),
                least,
            },
        }
    }
}

/// A camera in flight.
///
/// The body's axes are those of the picture: *right*, *up* and *forward* move along what the
/// viewer sees as such, banked or not. *Yaw* turns about the world's vertical whatever the
/// attitude, *pitch* raises the nose up to straight up and no further, *roll* tilts the picture;
/// nothing else ever changes the roll, so a level flight stays level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlyCamera {
    /// The eye, in world metres.
    pub(crate) eye: DVec3,
    /// Where it looks; yaw in [0, 2π), pitch in [−π/2, π/2], roll in (−π, π].
    pub(crate) attitude: Attitude,
    /// How fast it flies.
    pub(crate) pace: Pace,
    /// Turn at an axis value of 1, in radians per second.
    pub(crate) turn_rate: f64,
}

impl FlyCamera {
    /// Flies for `seconds` as `axes` ask, at `speed` metres per second for an axis value of 1.
    ///
    /// The speed is the caller's, from [`Pace::speed`] and whatever else makes it faster. With a
    /// speed that depends on the height, the path depends on the length of the steps by what the
    /// height changes within one.
    pub(crate) fn advance(&mut self, axes: &FlightAxes, speed: f64, seconds: f64) {
        let mut left = seconds.max(0.0);
        // The nose stops at the vertical somewhere within the step: fly to there first.
        if let Some(stop) = self
            .seconds_to_vertical(axes.pitch)
            .filter(|stop| *stop < left)
        {
            self.fly(axes, speed, stop);
            left -= stop;
            self.fly(
                &FlightAxes {
                    pitch: 0.0,
                    ..*axes
                },
                speed,
                left,
            );
        } else {
            self.fly(axes, speed, left);
        }
    }

    /// Turns at once, as by a mouse: radians clockwise and radians of nose up.
    pub(crate) fn turn(&mut self, yaw: f64, pitch: f64) {
        self.set_attitude(Attitude {
            yaw: self.attitude.yaw + yaw,
            pitch: self.attitude.pitch + pitch,
            ..self.attitude
        });
    }

    /// Looks there, with each angle brought into its range. What is not finite changes nothing.
    pub(crate) fn set_attitude(&mut self, attitude: Attitude) {
        let Attitude { yaw, pitch, roll } = attitude;
        if yaw.is_finite() && pitch.is_finite() && roll.is_finite() {
            self.attitude = Attitude {
                yaw: yaw.rem_euclid(TAU),
                pitch: pitch.clamp(-FRAC_PI_2, FRAC_PI_2),
                roll: PI - (PI - roll).rem_euclid(TAU),
            };
        }
    }

    /// How long until the nose points straight up or down; `None` where it does not turn.
    fn seconds_to_vertical(&self, pitch_axis: f64) -> Option<f64> {
        let rate = self.turn_rate * pitch_axis;
        let room = FRAC_PI_2.copysign(rate) - self.attitude.pitch;
        (rate != 0.0).then(|| (room / rate).max(0.0))
    }

    fn fly(&mut self, axes: &FlightAxes, speed: f64, seconds: f64) {
        let (start, turn_rate) = (self.attitude, self.turn_rate);
        let after = |t: f64| Attitude {
            yaw: start.yaw + turn_rate * axes.yaw * t,
            pitch: start.pitch + turn_rate * axes.pitch * t,
            roll: start.roll + turn_rate * axes.roll * t,
        };
        self.eye += way(seconds, |t| {
            let [right, up, forward] = after(t).axes();
            speed * (axes.right * right + axes.up * up + axes.forward * forward)
        });
        self.set_attitude(after(seconds));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    fn camera() -> FlyCamera {
        FlyCamera {
            eye: DVec3::new(1000.0, 2000.0, 1500.0),
            attitude: Attitude::default(),
            pace: Pace::Constant(100.0),
            turn_rate: FRAC_PI_4,
        }
    }

    fn near(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-9, "{a} is not {b}");
    }

    #[test]
    fn forward_is_along_the_view_and_up_is_the_pictures() {
        let mut camera = camera();
        camera.attitude.yaw = FRAC_PI_2;
        camera.attitude.pitch = -FRAC_PI_4;
        let axes = FlightAxes {
            forward: 1.0,
            ..Default::default()
        };
        camera.advance(&axes, 100.0, 2.0);
        let leg = 200.0 * 0.5_f64.sqrt();
        near(camera.eye, DVec3::new(1000.0 + leg, 2000.0, 1500.0 - leg));
        let axes = FlightAxes {
            up: 0.5,
            ..Default::default()
        };
        camera.advance(&axes, 100.0, 4.0);
        near(camera.eye, DVec3::new(1000.0 + 2.0 * leg, 2000.0, 1500.0));
    }

    #[test]
    fn a_steady_turn_flies_a_circle() {
        let mut camera = camera();
        let axes = FlightAxes {
            forward: 1.0,
            yaw: 1.0,
            ..Default::default()
        };
        // A quarter of a circle to the right: radius v/ω, from north to east.
        let radius = 100.0 / FRAC_PI_4;
        for _ in 0..20 {
            camera.advance(&axes, 100.0, 0.1);
        }
        near(
            camera.eye,
            DVec3::new(1000.0 + radius, 2000.0 + radius, 1500.0),
        );
        assert!((camera.attitude.yaw - FRAC_PI_2).abs() < 1e-12);
        assert_eq!(camera.attitude.roll, 0.0);
    }

    #[test]
    fn splitting_a_step_does_not_change_the_path() {
        let axes = FlightAxes {
            right: 0.7,
            forward: 1.0,
            up: -0.4,
            yaw: 0.9,
            pitch: 1.0,
            roll: -0.6,
        };
        // The second start reaches the vertical within the step.
        for pitch in [0.2, FRAC_PI_2 - 0.05] {
            let mut whole = camera();
            whole.attitude = Attitude {
                yaw: 6.2,
                pitch,
                roll: 3.1,
            };
            let mut split = whole;
            whole.advance(&axes, 250.0, 0.1);
            for _ in 0..8 {
                split.advance(&axes, 250.0, 0.0125);
            }
            near(whole.eye, split.eye);
            let (a, b) = (whole.attitude.axes(), split.attitude.axes());
            assert!((0..3).all(|axis| (a[axis] - b[axis]).length() < 1e-12));
        }
    }

    #[test]
    fn the_nose_stops_at_the_vertical_and_yaw_goes_on() {
        let mut camera = camera();
        let axes = FlightAxes {
            pitch: -1.0,
            yaw: -1.0,
            ..Default::default()
        };
        camera.advance(&axes, 100.0, 4.0);
        assert_eq!(camera.attitude.pitch, -FRAC_PI_2);
        assert!((camera.attitude.yaw - PI).abs() < 1e-12);
        camera.turn(0.0, 10.0);
        assert_eq!(camera.attitude.pitch, FRAC_PI_2);
    }

    #[test]
    fn still_axes_and_backward_time_change_nothing() {
        let mut camera = camera();
        camera.advance(&FlightAxes::default(), 100.0, 1.0);
        let axes = FlightAxes {
            forward: 1.0,
            ..Default::default()
        };
        camera.advance(&axes, 100.0, -1.0);
        camera.advance(&axes, 100.0, f64::NAN);
        camera.turn(f64::NAN, 0.0);
        assert_eq!(camera, self::camera());
    }

    #[test]
    fn speed_follows_the_height_but_never_stops() {
        let pace = Pace::WithHeight {
            per_second: 0.5,
            least: 20.0,
        };
        assert_eq!(pace.speed(Some(1000.0)), 500.0);
        assert_eq!(pace.speed(Some(-30.0)), 20.0);
        assert_eq!(pace.speed(None), 20.0);
        assert_eq!(Pace::Constant(100.0).faster(1.0), Pace::Constant(125.0));
        assert_eq!(pace.faster(-1.0).speed(Some(1000.0)), 400.0);
    }
}
