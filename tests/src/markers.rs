//! Red dots on a level plane: points at known places whose pixels can be measured.

use glam::{DVec2, DVec3};
use sandtable_cast::{Image, Scene};
use sandtable_terrain::{Ground, Photo, TiledRaster};
use std::sync::Arc;

/// A soft red dot.
#[derive(Clone, Copy, Debug)]
pub struct Marker {
    /// Its middle, in world metres on the plane.
    pub at: DVec2,
    /// Where its red has faded out, in metres from the middle.
    pub radius: f64,
}

/// A level plane at height `z` over `size` metres, black but for one marker.
///
/// # Panics
/// Never: the plane has two posts a side.
#[must_use]
pub fn marked_plane(size: DVec2, z: f64, marker: Marker) -> Arc<Scene> {
    let ground = Ground::from_fn(2, 2, size, |_, _| z as f32).expect("two posts a side");
    // The photograph's pixels are a tenth of the marker.
    let spacing = marker.radius / 10.0;
    let side = |length: f64| (length / spacing).ceil() as u32 + 2;
    let pixels = TiledRaster::from_fn(side(size.x), side(size.y), |col, row| {
        let at = DVec2::new(f64::from(col), f64::from(row)) * spacing;
        let red = 255.0 * (1.0 - at.distance(marker.at) / marker.radius).max(0.0);
        [red.round() as u8, 0, 0, 255]
    });
    let photo = Photo {
        pixels,
        origin: DVec2::ZERO,
        spacing: DVec2::splat(spacing),
    };
    Scene::new(ground.with_photo(photo))
}

/// The middle of an image's red over the ground, in image coordinates, weighted by how red it is;
/// `None` where there is none.
#[must_use]
pub fn centroid(image: &Image) -> Option<DVec2> {
    let width = image.width();
    let mut sum = DVec3::ZERO;
    for (index, (colour, depth)) in image.colour().iter().zip(&image.depth).enumerate() {
        if depth.is_finite() {
            let (i, j) = (index as u32 % width, index as u32 / width);
            let red = f64::from(colour[0]);
            sum += red * DVec3::new(f64::from(i) + 0.5, f64::from(j) + 0.5, 1.0);
        }
    }
    (sum.z > 0.0).then(|| sum.truncate() / sum.z)
}
