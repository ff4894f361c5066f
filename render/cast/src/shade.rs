//! Colours of what rays end on.

use crate::canvas::Canvas;
use glam::{DVec3, Vec4};
use sandtable_terrain::{Ground, Rgb, TiledRaster};
use sandtable_view::Ray;

/// What a ray sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The colour of the ground, or of the sky (sRGB-encoded).
    pub colour: Rgb,
    /// Metres in the world from the ray's origin along it; +∞ for sky.
    pub depth: f64,
}

/// What `ray` sees: the ground at `hit`, or the sky.
#[inline]
pub(crate) fn sight_at(ground: &Ground, ray: &Ray, hit: Option<f64>) -> Sight {
    match hit {
        Some(t) => {
            let p = ray.origin + t * ray.direction;
            Sight {
                colour: ground.colour_at(p.x, p.y),
                depth: t * ray.direction.length(),
            }
        }
        None => Sight {
            colour: sky(ray.direction),
            depth: f64::INFINITY,
        },
    }
}

/// Writes what `ray` sees into a pixel: the ground's colour and depth at `hit`, or the sky.
#[inline]
pub(crate) fn shade(
    canvas: &Canvas<'_>,
    pixel: [u32; 2],
    ground: &Ground,
    ray: &Ray,
    hit: Option<f64>,
) {
    let Sight { colour, depth } = sight_at(ground, ray, hit);
    canvas.set(pixel, colour, depth as f32);
}

/// The colour of pre-textured voxel columns at a place in posts, bilinear (papers' row W2).
#[inline]
pub(crate) fn bilinear_colour(columns: &TiledRaster<[u8; 4]>, x: f64, y: f64) -> [u8; 3] {
    let ([col, row], [u, v]) = columns.locate(x, y);
    let (u, v) = (u as f32, v as f32);
    let texels = columns.cell(col, row);
    // Four channels at a time, though the fourth is not asked for.
    let [sw, se, nw, ne] = texels.map(|texel| Vec4::from_array(texel.map(f32::from)));
    let (south, north) = (sw + (se - sw) * u, nw + (ne - nw) * u);
    let colour = south + (north - south) * v + 0.5;
    let [r, g, b, _] = colour.to_array().map(|channel| channel as u8);
    [r, g, b]
}

/// The sky's colours: pale at the horizon and bluer above. Below the horizon, where a ray has passed
/// the terrain's edge, haze goes over into a dark that lets the relief stand out on a table.
pub(crate) const HORIZON: [f32; 3] = [200.0, 216.0, 232.0];
pub(crate) const ZENITH: [f32; 3] = [84.0, 138.0, 206.0];
pub(crate) const DEPTHS: [f32; 3] = [24.0, 28.0, 34.0];
/// The sine of the angle under the horizon at which the haze ends.
pub(crate) const HAZE: f32 = 0.35;

/// The sky's colour along `direction`.
#[inline]
pub(crate) fn sky(direction: DVec3) -> [u8; 3] {
    let up = direction.z / direction.length();
    let (far, share) = if up >= 0.0 {
        (ZENITH, up.sqrt())
    } else {
        let below = (-up / f64::from(HAZE)).min(1.0);
        (DEPTHS, below * (2.0 - below))
    };
    std::array::from_fn(|k| (HORIZON[k] + (far[k] - HORIZON[k]) * share as f32 + 0.5) as u8)
}
