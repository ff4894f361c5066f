//! Colours of what rays end on.

use crate::ColumnStrip;
use glam::DVec3;
use sandtable_terrain::Ground;
use sandtable_view::Ray;

/// Writes what `ray` sees into a pixel: the ground's colour and depth at `hit`, or the sky.
#[inline]
pub(crate) fn shade(
    strip: &mut ColumnStrip<'_>,
    [i, j]: [u32; 2],
    ground: &Ground,
    ray: &Ray,
    hit: Option<f64>,
) {
    match hit {
        Some(t) => {
            let p = ray.origin + t * ray.direction;
            let depth = t * ray.direction.length();
            strip.set(i, j, ground.colour_at(p.x, p.y), depth as f32);
        }
        None => strip.set(i, j, sky(ray.direction), f32::INFINITY),
    }
}

/// The sky's colour along `direction`: pale at the horizon, bluer above; below the horizon, where a
/// ray has passed the terrain's edge, a dark that lets the relief stand out on the table.
#[inline]
fn sky(direction: DVec3) -> [u8; 3] {
    let up = direction.z / direction.length();
    if up < 0.0 {
        return [24, 28, 34];
    }
    let share = up.sqrt() as f32;
    let mix = |low: f32, high: f32| (low + (high - low) * share + 0.5) as u8;
    [mix(200.0, 84.0), mix(216.0, 138.0), mix(232.0, 206.0)]
}
