//! Colours of what rays end on.

use glam::DVec3;

/// The sky's colour along `direction`: pale at the horizon, bluer above; below the horizon, where a
/// ray has passed the terrain's edge, a dark that lets the relief stand out on the table.
#[inline]
pub(crate) fn sky(direction: DVec3) -> [u8; 3] {
    let up = direction.z / direction.length();
    if up < 0.0 {
        return [24, 28, 34];
    }
    let share = up.sqrt() as f32;
    let mix = |low: f32, high: f32| (low + (high - low) * share + 0.5) as u8;
    [mix(200.0, 84.0), mix(216.0, 138.0), mix(232.0, 206.0)]
}
