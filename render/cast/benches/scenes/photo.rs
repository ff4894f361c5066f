//! A photograph for ground that has none.

use super::noise::hash;
use glam::DVec2;
use sandtable_terrain::{Ground, Photo, TiledRaster};

/// The seed of the grain.
const GRAIN: u32 = 99;

/// `ground` under a photograph of a pixel a post: its tints in shaded relief, each pixel brighter
/// or darker by up to 8 %.
pub(super) fn with_photo(ground: Ground) -> Ground {
    let grid = ground.grid();
    let pixels = TiledRaster::from_fn(grid.cols, grid.rows, |col, row| {
        let at = DVec2::new(f64::from(col), f64::from(row)) * grid.spacing;
        let grain = (hash(col as i32, row as i32, GRAIN) & 255) as f32 / 255.0;
        let gain = 0.92 + 0.16 * grain;
        let [r, g, b] = ground
            .colour_at(at.x, at.y)
            .map(|channel| (f32::from(channel) * gain) as u8);
        [r, g, b, 255]
    });
    over(ground, pixels)
}

/// `ground` under `pixels`, one a post.
pub(super) fn over(ground: Ground, pixels: TiledRaster<[u8; 4]>) -> Ground {
    let spacing = ground.grid().spacing;
    ground.with_photo(Photo {
        pixels,
        origin: DVec2::ZERO,
        spacing,
    })
}
