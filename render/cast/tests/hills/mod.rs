//! Hills, and cameras over them.

use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera};

/// A ground of `height` in metres at (x, y) metres, with posts 10 by 8 m apart.
pub(crate) fn ground(cols: u32, rows: u32, height: impl Fn(f64, f64) -> f64 + Sync) -> Ground {
    let spacing = DVec2::new(10.0, 8.0);
    let height =
        |col: u32, row: u32| height(f64::from(col) * spacing.x, f64::from(row) * spacing.y) as f32;
    Ground::from_fn(cols, rows, spacing, height).expect("a sound grid")
}

/// Hills of two sizes.
pub(crate) fn hills(x: f64, y: f64) -> f64 {
    40.0 * (x / 130.0).sin() * (y / 170.0).cos() + 15.0 * (x / 41.0 + y / 57.0).sin()
}

pub(crate) fn camera(eye: DVec3, yaw: f64, pitch: f64, roll: f64) -> Camera {
    let attitude = Attitude { yaw, pitch, roll };
    Camera {
        eye,
        attitude,
        horizontal_fov: 1.0,
    }
}
