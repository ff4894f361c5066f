//! What a session sounds like: the wind of flying, and a chime on the highest summit.

use super::{Session, Viewpoint};
use glam::DVec3;
use sandtable_audio::{Listener, Settings, Soundscape, Source, Voice};
use sandtable_terrain::Ground;
use sandtable_view::Attitude;

impl Session {
    /// The mixer's settings for this terrain: half of the wind's strength at the usual speed.
    pub(crate) fn sound_settings(&self) -> Settings {
        let longer_side = self.ground().grid().extent().max_element();
        Settings {
            half_wind_speed: self.rig.flight.speed.of(longer_side),
            voice: Voice::default(),
            ..Settings::default()
        }
    }

    /// What is heard now: at a table in its frame; in flight in the world's, where the distance
    /// that is near goes with the terrain's size.
    pub(crate) fn soundscape(&self, summit: DVec3) -> Soundscape {
        let (listener, source) = match &self.viewpoint {
            Viewpoint::Camera { camera, .. } => {
                let [right, ..] = Attitude::axes(&camera.attitude);
                let near = 0.02 * self.ground().grid().extent().max_element();
                let source = Source {
                    reference_distance: near,
                    ..Source::at(summit)
                };
                (
                    Listener {
                        position: camera.eye,
                        right,
                    },
                    source,
                )
            }
            Viewpoint::Table { flight, eyes, .. } => {
                let head = self.head.table_from_body().point(eyes.middle);
                let summit = flight.placement.table_from_world(summit);
                (Listener::at_table(head), Source::at(summit))
            }
        };
        Soundscape {
            listener,
            source: Some(source),
            airspeed: self.airspeed,
        }
    }
}

/// The highest post, in world metres.
pub(crate) fn summit(ground: &Ground) -> DVec3 {
    let (grid, heights) = (ground.grid(), ground.heights());
    let highest = ground.range()[1];
    let tile_posts = sandtable_terrain::TILE_CELLS;
    for tile in heights.tile_indices() {
        let Some(at) = heights
            .tile_posts(tile)
            .iter()
            .position(|&height| height == highest)
        else {
            continue;
        };
        let stride = heights.tile_stride() as u32;
        let (col, row) = (at as u32 % stride, at as u32 / stride);
        let x = f64::from(tile.col * tile_posts + col) * grid.spacing.x;
        let y = f64::from(tile.row * tile_posts + row) * grid.spacing.y;
        return DVec3::new(x, y, f64::from(highest));
    }
    (0.5 * grid.extent()).extend(f64::from(highest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn the_summit_is_the_highest_post() {
        let peak = |col: u32, row: u32| if (col, row) == (401, 310) { 9.0 } else { 1.0 };
        let ground = Ground::from_fn(450, 400, DVec2::new(2.0, 3.0), peak).unwrap();
        assert_eq!(summit(&ground), DVec3::new(802.0, 930.0, 9.0));
    }
}
