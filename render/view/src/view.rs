//! A view: an eye, a window, and the rays through its pixels.

use crate::Screen;
use glam::{DMat3, DVec2, DVec3};

/// A ray from an eye. `direction` is not normalised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts, in the view's frame.
    pub origin: DVec3,
    /// Where it goes; it reaches the window at `origin + direction`.
    pub direction: DVec3,
}

/// An eye and the window through which it sees, in world metres, and the image's size in pixels.
///
/// Pixel (i, j), j counted down from the top, is seen through
/// `UL + (i+½)/w·(LR−LL) + (j+½)/h·(LL−UL)`. What lies between the eye and the window is seen too:
/// over a table, the relief stands there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye.
    pub eye: DVec3,
    /// The window.
    pub window: Screen,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

impl View {
    /// What all pixels' rays share, for casting many of them.
    #[must_use]
    pub fn rays(&self) -> Rays {
        let [w, h] = self.size;
        Rays {
            origin: self.eye,
            corner: self.window.upper_left - self.eye,
            right: self.window.across() / f64::from(w),
            down: -self.window.upwards() / f64::from(h),
        }
    }

    /// The ray's direction through image coordinates `(x, y)` in pixels, y down, so that pixel
    /// (i, j)'s centre is `(i + ½, j + ½)`.
    #[must_use]
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        self.rays().direction(x, y)
    }

    /// The ray through the centre of pixel (i, j).
    #[must_use]
    pub fn ray(&self, i: u32, j: u32) -> Ray {
        self.rays().ray(i, j)
    }

    /// Where `point` is seen, in image coordinates (pixels, y down), or `None` where it is not in
    /// front of the eye or the eye lies in the window's plane. The result may lie off the image.
    #[must_use]
    pub fn pixel_of(&self, point: DVec3) -> Option<DVec2> {
        let (across, upwards) = (self.window.across(), self.window.upwards());
        let corner = self.window.upper_left - self.eye;
        // corner + a·across − b·upwards = t·(point − eye), solved for (a, b) by Cramer's rule.
        let to_point = point - self.eye;
        let volume = DMat3::from_cols(across, -upwards, -to_point).determinant();
        let scale = across.length() * upwards.length() * to_point.length();
        if scale == 0.0 || volume.abs() <= 1e-12 * scale {
            return None;
        }
        let a = DMat3::from_cols(-corner, -upwards, -to_point).determinant() / volume;
        let b = DMat3::from_cols(across, -corner, -to_point).determinant() / volume;
        let t = DMat3::from_cols(across, -upwards, -corner).determinant() / volume;
        (t > 0.0).then(|| DVec2::new(a * f64::from(self.size[0]), b * f64::from(self.size[1])))
    }

    /// Whether the eye lies off the window's plane and the window has an area, so that every
    /// pixel has a direction of its own.
    #[must_use]
    pub fn is_proper(&self) -> bool {
        let (across, upwards) = (self.window.across(), self.window.upwards());
        let volume = across.cross(upwards).dot(self.window.upper_left - self.eye);
        volume.is_finite()
            && self.eye.is_finite()
            && volume.abs() > 1e-12 * across.length() * upwards.length() * across.length()
    }
}

/// The rays of one view: its eye, and steps from pixel to pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays {
    origin: DVec3,
    /// The direction through the image's upper left corner.
    corner: DVec3,
    /// One pixel to the right, and one down.
    right: DVec3,
    down: DVec3,
}

impl Rays {
    /// As [`View::direction`].
    #[inline]
    #[must_use]
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        self.corner + x * self.right + y * self.down
    }

    /// As [`View::ray`].
    #[inline]
    #[must_use]
    pub fn ray(&self, i: u32, j: u32) -> Ray {
        Ray {
            origin: self.origin,
            direction: self.direction(f64::from(i) + 0.5, f64::from(j) + 0.5),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table_view() -> View {
        View {
            eye: DVec3::new(0.1, -0.95, 0.62),
            window: Screen::horizontal(1.8, 1.1),
            size: [1800, 1100],
        }
    }

    #[test]
    fn corner_pixels_are_seen_through_the_corners() {
        let view = table_view();
        let ray = view.ray(0, 0);
        let through = ray.origin + ray.direction;
        assert!((through - DVec3::new(-0.8995, 0.5495, 0.0)).length() < 1e-12);
        let ray = view.ray(1799, 1099);
        let through = ray.origin + ray.direction;
        assert!((through - DVec3::new(0.8995, -0.5495, 0.0)).length() < 1e-12);
    }

    #[test]
    fn a_points_pixel_is_where_its_ray_goes() {
        let view = table_view();
        for point in [DVec3::new(0.3, 0.2, 0.25), DVec3::new(-0.5, 0.1, -0.4)] {
            let p = view.pixel_of(point).unwrap();
            let d = view.direction(p.x, p.y).normalize();
            assert!((d - (point - view.eye).normalize()).length() < 1e-12);
        }
    }

    #[test]
    fn a_point_behind_the_eye_has_no_pixel() {
        let view = table_view();
        assert_eq!(view.pixel_of(DVec3::new(0.1, -0.95, 0.9)), None);
    }

    #[test]
    fn an_eye_in_the_glass_makes_no_proper_view() {
        let mut view = table_view();
        assert!(view.is_proper());
        view.eye.z = 0.0;
        assert!(!view.is_proper());
    }
}
