//! From the eye to clip coordinates, through any window.

use glam::{DMat3, DVec3, Mat4, Vec4};
use sandtable_view::View;

/// How near to the eye ground is drawn, in cells.
const NEAREST_CELLS: f64 = 1e-3;

/// Takes offsets from the eye of a proper `view`, in world metres, to clip coordinates.
///
/// It follows from the window's corners, so that it is off-axis and, for a parallelogram, sheared
/// as the view is. What lies before the window is drawn too. Depth is 1 at the nearest plane, a
/// thousandth of a cell away, and falls to 0 at infinity: a 32-bit float is as precise far away
/// then as near, wherever the nearest plane is.
pub(super) fn clip_from_eye(view: &View, cell_length: f64) -> Mat4 {
    // An offset is w (centre + x right + y up), for x and y in [-1, 1] within the window.
    let right = 0.5 * view.window.across();
    let up = 0.5 * view.window.upwards();
    let forward = view.window.centre() - view.eye;
    let window_from_eye = DMat3::from_cols(right, up, forward).inverse();
    let [x, y, w] = [0, 1, 2].map(|row| window_from_eye.row(row));
    // With each metre from the eye, w grows by the length of its gradient.
    let nearest = NEAREST_CELLS * cell_length * w.length();
    let linear = |gradient: DVec3| gradient.as_vec3().extend(0.0);
    let constant = |value: f64| Vec4::new(0.0, 0.0, 0.0, value as f32);
    Mat4::from_cols(linear(x), linear(y), constant(nearest), linear(w)).transpose()
}
