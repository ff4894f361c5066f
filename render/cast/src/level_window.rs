//! Windows whose pixel rows are level, at any inclination.

use crate::CastError;
use glam::{DVec2, DVec3};
use sandtable_view::View;

/// How far a window may miss being level, rectangular or upright, in radians: a hundredth of a
/// pixel in an image ten thousand pixels across.
const TOLERANCE: f64 = 1e-6;

/// A rectangular window with level rows, as it stands before the eye.
///
/// With α the angle between pixel columns and the vertical, the unit normal from the eye to the
/// window's plane is `forward·cos α − up·sin α` and columns run along `forward·sin α + up·cos α`
/// (Guedes, Gattass and Carvalho 1997). Offsets of pixels are measured from the foot of that
/// normal, wherever the window lies in its plane.
pub(crate) struct LevelWindow {
    /// The level direction along which rows run, and the one square to it that α refers to.
    pub(crate) right: DVec2,
    pub(crate) forward: DVec2,
    pub(crate) sin: f64,
    /// Never negative: α lies in [−90°, 90°], a window hung upside down is read from below.
    pub(crate) cos: f64,
    /// Metres from the eye to the window's plane.
    pub(crate) distance: f64,
    /// Offsets of column 0 and row 0, and from one column or row to the next, in metres.
    columns: [f64; 2],
    rows: [f64; 2],
}

impl LevelWindow {
    /// Takes the window of `view`, which is to be cast by `caster`.
    pub(crate) fn new(caster: &'static str, view: &View) -> Result<Self, CastError> {
        let refuse = |reason: String| Err(CastError::View { caster, reason });
        if !view.is_proper() {
            return refuse(
                "the eye lies in the window's plane, or the window has no area: move either"
                    .to_owned(),
            );
        }
        let (across, upwards) = (view.window.across(), view.window.upwards());
        let rise = (across.z / across.length()).asin();
        if rise.abs() > TOLERANCE {
            return refuse(format!(
                "its pixel rows rise by {:.1}°, and they have to be level: use roll-lines or \
                 coherent",
                rise.to_degrees()
            ));
        }
        let corner_angle = across.angle_between(upwards);
        if (corner_angle - std::f64::consts::FRAC_PI_2).abs() > TOLERANCE {
            return refuse(format!(
                "its pixel rows and columns meet at {:.1}°, and the window has to be a \
                 rectangle: use coherent",
                corner_angle.to_degrees()
            ));
        }
        let right = across / across.length();
        let up = upwards / upwards.length() * 1f64.copysign(upwards.z);
        let corner = view.window.upper_left - view.eye;
        let normal = right.cross(up);
        let normal = normal * 1f64.copysign(corner.dot(normal));
        let forward = (normal * up.z - up * normal.z).truncate();
        let [width, height] = view.size.map(f64::from);
        let offsets = |along: DVec3, step: DVec3| {
            let step = step.dot(along);
            [corner.dot(along) + 0.5 * step, step]
        };
        Ok(Self {
            right: right.truncate().normalize_or(DVec2::X),
            forward: forward.normalize_or(DVec2::Y),
            sin: -normal.z,
            cos: up.z,
            distance: corner.dot(normal),
            columns: offsets(right, across / width),
            rows: offsets(up, -upwards / height),
        })
    }

    /// α in degrees: positive where the window looks down.
    pub(crate) fn lean_degrees(&self) -> f64 {
        self.sin.atan2(self.cos).to_degrees()
    }

    /// Whether columns are vertical.
    pub(crate) fn is_upright(&self) -> bool {
        self.sin.abs() <= TOLERANCE
    }

    /// Pixel column `k`'s offset to the right of the normal's foot, in window distances.
    #[inline]
    pub(crate) fn column(&self, k: u32) -> f64 {
        (self.columns[0] + f64::from(k) * self.columns[1]) / self.distance
    }

    /// Pixel row `j`'s offset from the normal's foot towards the upper edge, in metres.
    pub(crate) fn row(&self, j: u32) -> f64 {
        self.rows[0] + f64::from(j) * self.rows[1]
    }

    /// How far a ray through row `j` goes forward and up until it reaches the window, in metres.
    pub(crate) fn forward_and_up(&self, j: u32) -> [f64; 2] {
        let offset = self.row(j);
        [
            self.distance * self.cos + offset * self.sin,
            offset * self.cos - self.distance * self.sin,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sandtable_view::{Attitude, Camera, Screen};

    fn camera(yaw: f64, pitch: f64, roll: f64) -> View {
        let attitude = Attitude { yaw, pitch, roll };
        Camera {
            eye: DVec3::new(3.0, 4.0, 5.0),
            attitude,
            horizontal_fov: 1.0,
        }
        .view([40, 30])
    }

    /// Every pixel's ray, put together from the window's own numbers.
    fn assert_rays_are_those_of(view: &View) {
        let window = LevelWindow::new("test", view).unwrap();
        for (k, j) in [(0, 0), (39, 0), (0, 29), (39, 29), (17, 11)] {
            let [ahead, up] = window.forward_and_up(j);
            let ground = window.right * window.column(k) * window.distance + window.forward * ahead;
            let direction = view.ray(k, j).direction;
            assert!((ground.extend(up) - direction).length() < 1e-12, "{k}, {j}");
        }
    }

    #[test]
    fn rays_of_level_windows_of_all_kinds_come_out_again() {
        for pitch in [0.0, -0.5, -1.2, 0.7, -std::f64::consts::FRAC_PI_2] {
            assert_rays_are_those_of(&camera(0.8, pitch, 0.0));
            assert_rays_are_those_of(&camera(0.8, pitch, std::f64::consts::PI));
            // Off-axis, and mirrored.
            let mut view = camera(-2.0, pitch, 0.0);
            view.eye += DVec3::new(0.1, 0.2, 0.05);
            assert_rays_are_those_of(&view);
            let Screen {
                lower_left: left,
                lower_right: right,
                ..
            } = view.window;
            view.window = Screen {
                lower_left: right,
                lower_right: left,
                upper_left: view.window.upper_right(),
            };
            assert_rays_are_those_of(&view);
        }
    }

    #[test]
    fn the_lean_is_the_angle_by_which_the_camera_looks_down() {
        for degrees in [0.0f64, 30.0, 60.0, 90.0, -20.0] {
            let view = camera(1.0, -degrees.to_radians(), 0.0);
            let window = LevelWindow::new("test", &view).unwrap();
            assert!((window.lean_degrees() - degrees).abs() < 1e-9);
            assert_eq!(window.is_upright(), degrees == 0.0);
        }
    }

    #[test]
    fn windows_that_are_not_level_rectangles_before_the_eye_are_refused() {
        let refusal = |view: &View| LevelWindow::new("test", view).map(|_| ()).unwrap_err();
        assert_eq!(
            refusal(&camera(0.0, 0.0, 0.5)).to_string(),
            "test cannot cast this view: its pixel rows rise by -28.6°, and they have to be \
             level: use roll-lines or coherent"
        );
        let mut view = camera(0.0, 0.0, 0.0);
        view.window.upper_left.x += 0.1;
        let text = refusal(&view).to_string();
        assert!(
            text.contains("meet at 83.0°") && text.contains("use coherent"),
            "{text}"
        );
        view.eye = view.window.centre();
        assert!(refusal(&view).to_string().contains("window's plane"));
    }
}
