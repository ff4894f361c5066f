//! Where a flight begins.

use glam::DVec3;
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera};

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
