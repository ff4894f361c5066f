//! Vantage points: views of a whole terrain that need no view file.

use glam::DVec3;
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, Placement, Screen, View};

/// The glass and the standing eye of a workbench, in table metres: for views of a table that no
/// rig describes.
const GLASS: [f64; 2] = [1.8, 1.1];
const EYE: DVec3 = DVec3::new(0.0, -0.75, 0.6);

/// Where a flight begins: south of the terrain's middle, above its relief, looking north and down
/// over all of it.
pub(crate) fn overview(ground: &Ground, horizontal_fov: f64) -> Camera {
    let extent = ground.grid().extent();
    let [low, high] = ground.range().map(f64::from);
    let reach = extent.max_element();
    Camera {
        eye: DVec3::new(
            0.5 * extent.x,
            -0.05 * extent.y,
            high.max(low + 0.05 * reach) + 0.18 * reach,
        ),
        attitude: Attitude {
            yaw: 0.0,
            pitch: (-22.0f64).to_radians(),
            roll: 0.0,
        },
        horizontal_fov,
    }
}

/// The views that `bench` times where none is given, with their names.
pub(crate) fn bench_views(ground: &Ground) -> Vec<(&'static str, View)> {
    let extent = ground.grid().extent();
    let [low, high] = ground.range().map(f64::from);
    let reach = extent.max_element();
    let fov = 60f64.to_radians();
    let camera = |x: f64, y: f64, z: f64, pitch: f64, roll: f64| Camera {
        eye: DVec3::new(x * extent.x, y * extent.y, z),
        attitude: Attitude {
            yaw: 0.2,
            pitch: pitch.to_radians(),
            roll: roll.to_radians(),
        },
        horizontal_fov: fov,
    };
    let over = |share: f64| high + share * reach;
    let glass = Screen::horizontal(GLASS[0], GLASS[1]);
    let placement = Placement::fitted(extent, [low, high], &glass, 0.05, 1.0);
    let table = View {
        eye: placement.world_from_table(EYE),
        window: glass.map(|corner| placement.world_from_table(corner)),
        size: [1280, 782],
    };
    vec![
        (
            "pitched",
            camera(0.5, 0.02, over(0.1), -30.0, 0.0).view([500, 400]),
        ),
        (
            "horizon",
            camera(0.5, 0.05, over(0.02), -8.0, 0.0).view([1280, 720]),
        ),
        (
            "rolled",
            camera(0.5, 0.05, over(0.02), -8.0, 30.0).view([1280, 720]),
        ),
        (
            "down",
            camera(0.5, 0.5, over(0.5), -90.0, 0.0).view([1280, 720]),
        ),
        ("table", table),
    ]
}
