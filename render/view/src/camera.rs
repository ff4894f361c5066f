//! Cameras: the flying way to build a view.

use crate::{Screen, StereoPair, View};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Where a camera looks, in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Attitude {
    /// Heading from north, clockwise seen from above.
    pub yaw: f64,
    /// Nose up positive.
    pub pitch: f64,
    /// Right wing down positive.
    pub roll: f64,
}

impl Attitude {
    /// The unit vectors right, up and forward in world axes. Defined at every pitch, straight up
    /// and straight down included.
    #[must_use]
    pub fn axes(&self) -> [DVec3; 3] {
        let (sy, cy) = self.yaw.sin_cos();
        let (sp, cp) = self.pitch.sin_cos();
        let (sr, cr) = self.roll.sin_cos();
        let level_right = DVec3::new(cy, -sy, 0.0);
        let forward = DVec3::new(sy * cp, cy * cp, sp);
        let level_up = level_right.cross(forward);
        let right = level_right * cr - level_up * sr;
        let up = level_up * cr + level_right * sr;
        [right, up, forward]
    }
}

/// A pinhole camera with square pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye, or the middle of the eyes, in world metres.
    pub eye: DVec3,
    /// Where it looks.
    pub attitude: Attitude,
    /// Angle between the outer edges of the first and last pixel column, in radians; in (0, π).
    pub horizontal_fov: f64,
}

/// Two eyes of a camera, in world metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stereo {
    /// Distance between the eyes.
    pub separation: f64,
    /// Distance straight ahead at which points have no parallax.
    pub screen_distance: f64,
}

impl Camera {
    /// The camera's window at `distance` metres straight ahead, for an image of `size` pixels.
    fn window(&self, distance: f64, size: [u32; 2]) -> Screen {
        let [right, up, forward] = self.attitude.axes();
        let half_width = distance * (0.5 * self.horizontal_fov).tan();
        let half_height = half_width * f64::from(size[1]) / f64::from(size[0].max(1));
        let centre = self.eye + distance * forward;
        let corner = |x: f64, y: f64| centre + x * half_width * right + y * half_height * up;
        Screen {
            lower_left: corner(-1.0, -1.0),
            lower_right: corner(1.0, -1.0),
            upper_left: corner(-1.0, 1.0),
        }
    }

    /// The camera's view in an image of `size` pixels.
    #[must_use]
    pub fn view(&self, size: [u32; 2]) -> View {
        View {
            eye: self.eye,
            window: self.window(1.0, size),
            size,
        }
    }

    /// Two views through one window: what lies at `screen_distance` falls on the same pixel in
    /// both, and the eyes' images differ along pixel rows only.
    #[must_use]
    pub fn stereo_views(&self, stereo: Stereo, size: [u32; 2]) -> StereoPair<View> {
        let window = self.window(stereo.screen_distance, size);
        let [right, ..] = self.attitude.axes();
        let half = 0.5 * stereo.separation * right;
        StereoPair {
            left: View {
                eye: self.eye - half,
                window,
                size,
            },
            right: View {
                eye: self.eye + half,
                window,
                size,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    fn near(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-12, "{a} is not {b}");
    }

    #[test]
    fn north_level_has_east_to_the_right() {
        let [right, up, forward] = Attitude::default().axes();
        near(right, DVec3::X);
        near(up, DVec3::Z);
        near(forward, DVec3::Y);
    }

    #[test]
    fn yaw_is_clockwise_pitch_is_up_roll_drops_the_right_wing() {
        let east = Attitude {
            yaw: FRAC_PI_2,
            ..Default::default()
        };
        near(east.axes()[2], DVec3::X);
        let up = Attitude {
            pitch: FRAC_PI_4,
            ..Default::default()
        };
        assert!(up.axes()[2].z > 0.7);
        let banked = Attitude {
            roll: FRAC_PI_4,
            ..Default::default()
        };
        assert!(banked.axes()[0].z < -0.7);
    }

    #[test]
    fn straight_down_keeps_its_heading() {
        let down = Attitude {
            pitch: -FRAC_PI_2,
            ..Default::default()
        };
        let [right, up, forward] = down.axes();
        near(right, DVec3::X);
        near(up, DVec3::Y);
        near(forward, -DVec3::Z);
    }

    #[test]
    fn the_field_of_view_spans_the_outer_edges() {
        let camera = Camera {
            eye: DVec3::ZERO,
            attitude: Attitude::default(),
            horizontal_fov: FRAC_PI_2,
        };
        let view = camera.view([640, 360]);
        near(view.direction(0.0, 180.0), DVec3::new(-1.0, 1.0, 0.0));
        near(view.direction(640.0, 180.0), DVec3::new(1.0, 1.0, 0.0));
        // square pixels
        let d = view.direction(321.0, 179.0) - view.direction(320.0, 180.0);
        assert!((d.x - d.z).abs() < 1e-15);
    }

    #[test]
    fn stereo_meets_at_the_screen_distance() {
        let camera = Camera {
            eye: DVec3::new(1.0, 2.0, 3.0),
            attitude: Attitude {
                yaw: 0.3,
                pitch: -0.4,
                roll: 0.2,
            },
            horizontal_fov: 1.0,
        };
        let pair = camera.stereo_views(
            Stereo {
                separation: 65.0,
                screen_distance: 2000.0,
            },
            [800, 600],
        );
        let [right, up, forward] = camera.attitude.axes();
        let on = camera.eye + 2000.0 * forward + 120.0 * up - 77.0 * right;
        let (l, r) = (
            pair.left.pixel_of(on).unwrap(),
            pair.right.pixel_of(on).unwrap(),
        );
        assert!((l - r).length() < 1e-9);
        // Nearer is crossed: the left eye sees it further right; rows agree.
        let nearer = camera.eye + 1500.0 * forward + 120.0 * up;
        let (l, r) = (
            pair.left.pixel_of(nearer).unwrap(),
            pair.right.pixel_of(nearer).unwrap(),
        );
        assert!(l.x > r.x && (l.y - r.y).abs() < 1e-9);
    }
}
