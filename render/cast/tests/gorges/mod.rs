//! Gorges, seen from so far away that neighbouring pixels lie up to three cells apart where they come down to them.

use glam::{DVec2, DVec3};
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, View};

/// Rolling hills, with gorges of 150 m along their contours.
pub(crate) fn gorges() -> Ground {
    let height = |col: u32, row: u32| {
        let [x, y] = [col, row].map(f64::from);
        let hills = 60.0 * (x / 31.0).sin() * (y / 43.0).cos() + 20.0 * ((x + y) / 17.0).sin();
        let bed = if hills.abs() < 8.0 { -150.0 } else { 0.0 };
        (hills + bed) as f32
    };
    Ground::from_fn(401, 401, DVec2::ONE, height).expect("a sound grid")
}

/// From beyond their southern border.
pub(crate) fn from_afar() -> View {
    let attitude = Attitude {
        pitch: -0.4,
        ..Attitude::default()
    };
    let camera = Camera {
        eye: DVec3::new(120.0, -600.0, 300.0),
        attitude,
        horizontal_fov: 0.5,
    };
    camera.view([320, 200])
}
