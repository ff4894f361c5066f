//! Depth of what is hit on a terrain slice.

use crate::level_window::LevelWindow;

/// Which depth is written.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Depth {
    /// That of the slice at which the ray was found to be under the ground.
    Slice,
    /// That of the ray's meeting with the ground's height there.
    Surface,
    /// None: +∞ in every pixel.
    Off,
}

/// A pixel row's part in depth.
pub(crate) struct RowDepth {
    /// (L / f)², L a ray's length and f its way across slices, is `near + side·q²` for a column q
    /// window distances off the normal's foot.
    near: f32,
    side: f32,
    /// Metres across slices for each metre upwards.
    run: f64,
}

impl RowDepth {
    /// For row `j`, whose rays go `across` metres over slices until they reach the window.
    pub(crate) fn new(window: &LevelWindow, j: u32, across: f64, slope: f64) -> Self {
        let (distance, offset) = (window.distance / across, window.row(j) / across);
        Self {
            near: (distance * distance + offset * offset) as f32,
            side: (distance * distance) as f32,
            // A ray that does not fall meets the front of what rises before it.
            run: if slope < 0.0 { 1.0 / slope } else { f64::MIN },
        }
    }

    /// Metres along the ray for each metre across slices.
    #[inline]
    fn length(&self, offset_squared: f32) -> f32 {
        (self.near + self.side * offset_squared).sqrt()
    }
}

/// How depth follows from the slice that is hit.
pub(crate) trait DepthRule {
    /// Metres along the ray to a hit at the slice `y` metres away, where slices are `step` metres
    /// apart and the ground is `rise` metres above the eye.
    fn depth(row: &RowDepth, offset_squared: f32, y: f64, step: f64, rise: f64) -> f32;
}

/// [`Depth::Slice`].
pub(crate) struct AtSlice;

impl DepthRule for AtSlice {
    #[inline(always)]
    fn depth(row: &RowDepth, offset_squared: f32, y: f64, _: f64, _: f64) -> f32 {
        y as f32 * row.length(offset_squared)
    }
}

/// [`Depth::Surface`]: the ground is taken for a column that is level from the slice before up to
/// this one, and whose top or front the ray meets.
pub(crate) struct AtSurface;

impl DepthRule for AtSurface {
    #[inline(always)]
    fn depth(row: &RowDepth, offset_squared: f32, y: f64, step: f64, rise: f64) -> f32 {
        let met = (rise * row.run).max(y - step).max(0.0).min(y);
        met as f32 * row.length(offset_squared)
    }
}

/// [`Depth::Off`].
pub(crate) struct NoDepth;

impl DepthRule for NoDepth {
    #[inline(always)]
    fn depth(_: &RowDepth, _: f32, _: f64, _: f64, _: f64) -> f32 {
        f32::INFINITY
    }
}

/// The depth buffer's value of each slice, `Depth[i] = (f − f·n/i) / (f − n)`, in [0, 1] between
/// the near and the far plane (Szenberg, Gattass and Carvalho 1997; papers' row Z2).
///
/// Slice i lies `i · step` metres from the eye; the table ends at the last slice that is not
/// beyond `far`. Slices nearer than `near` get 0, as OpenGL clips them. For upright windows only:
/// then a slice is parallel to the screen and has one depth, whatever the column, the eye or the
/// direction of view.
///
/// # Panics
/// Where not `0 < near < far` and `0 < step`, all of them finite.
#[must_use]
pub fn depth_buffer_table(near: f64, far: f64, step: f64) -> Vec<f32> {
    assert!(
        0.0 < near && near < far && far.is_finite() && step > 0.0,
        "no depth table from {near} to {far} m in steps of {step} m"
    );
    let slices = (far / step).floor() as u32;
    let depth = |i| {
        let distance = (f64::from(i) * step).max(near);
        ((far - far * near / distance) / (far - near)) as f32
    };
    (0..=slices).map(depth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat4, DVec3, DVec4};

    #[test]
    fn the_table_is_opengls_depth() {
        let (near, far, step) = (2.0, 500.0, 7.5);
        // The symmetric frustum of the OpenGL specification, one metre wide at the near plane.
        let projection = DMat4::from_cols(
            DVec4::new(2.0 * near, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 2.0 * near, 0.0, 0.0),
            DVec4::new(0.0, 0.0, -(far + near) / (far - near), -1.0),
            DVec4::new(0.0, 0.0, -2.0 * far * near / (far - near), 0.0),
        );
        let table = depth_buffer_table(near, far, step);
        assert_eq!(table.len(), 67);
        assert_eq!(table[0], 0.0);
        for (i, &depth) in table.iter().enumerate().skip(1) {
            let point = DVec3::new(3.0, -4.0, -(i as f64) * step);
            let expected = 0.5 * (projection.project_point3(point).z + 1.0);
            assert!((f64::from(depth) - expected).abs() < 1e-7, "slice {i}");
        }
    }
}
