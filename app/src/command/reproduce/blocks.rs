//! Blocks on a checkered ground: the scene on which Guedes, Gattass and Carvalho (1997) judge how
//! exact a projection is.

use anyhow::Result;
use glam::DVec2;
use sandtable_cast::Scene;
use sandtable_terrain::{Ground, Photo, TiledRaster};
use std::sync::Arc;

/// Cells along each side.
const CELLS: u32 = 256;
/// Photograph pixels along a cell.
const FINE: u32 = 8;
/// Cells along a check.
const CHECK: u32 = 16;
const CHECKS: [[u8; 3]; 2] = [[226, 222, 206], [72, 98, 122]];
const TOP: [u8; 3] = [214, 92, 56];
/// Sides facing south or north, and east or west.
const SIDES: [[u8; 3]; 2] = [[140, 48, 36], [104, 34, 40]];
/// Blocks: first column and row, columns and rows, height, all in cells of a metre.
const BLOCKS: [[u32; 5]; 9] = [
    [32, 40, 24, 24, 24],
    [116, 32, 24, 24, 16],
    [200, 40, 24, 24, 24],
    [28, 116, 16, 32, 40],
    [112, 112, 32, 32, 32],
    [208, 116, 16, 32, 40],
    [40, 200, 32, 16, 28],
    [120, 208, 16, 16, 48],
    [184, 200, 32, 16, 28],
];

/// The scene, a metre a cell; a block's sides rise within one cell.
pub(super) fn scene() -> Result<Arc<Scene>> {
    let ground = Ground::from_fn(CELLS + 1, CELLS + 1, DVec2::ONE, |col, row| {
        let over = BLOCKS.iter().find(|block| is_within(block, [col, row], 0));
        over.map_or(0.0, |block| block[4] as f32)
    })?;
    let step = 1.0 / f64::from(FINE);
    let photo = Photo {
        pixels: TiledRaster::from_fn(CELLS * FINE, CELLS * FINE, |col, row| {
            let [r, g, b] = colour([col / FINE, row / FINE]);
            [r, g, b, 255]
        }),
        origin: DVec2::splat(0.5 * step),
        spacing: DVec2::splat(step),
    };
    Ok(Scene::new(ground.with_photo(photo)))
}

/// The colour of a cell: a check, a block's top, or a side of it.
fn colour([col, row]: [u32; 2]) -> [u8; 3] {
    // A top's cells have the block's posts at all their corners; sides are the cells around.
    let touched = BLOCKS.iter().find(|block| is_within(block, [col, row], 1));
    match touched {
        Some(&[left, bottom, cols, rows, _]) => {
            let on_top = |at: u32, first: u32, count: u32| (first..first + count).contains(&at);
            match (on_top(col, left, cols), on_top(row, bottom, rows)) {
                (true, true) => TOP,
                (true, false) => SIDES[0],
                _ => SIDES[1],
            }
        }
        None => CHECKS[((col / CHECK + row / CHECK) % 2) as usize],
    }
}

/// Whether a post (`around` 0) or a cell (`around` 1, for a block with its sides) is a block's.
fn is_within(block: &[u32; 5], [col, row]: [u32; 2], around: u32) -> bool {
    let [left, bottom, cols, rows, _] = *block;
    (left - around..=left + cols).contains(&col) && (bottom - around..=bottom + rows).contains(&row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_stand_with_steep_sides_on_sharp_checks() {
        let scene = scene().unwrap();
        let ground = &scene.ground;
        // The first block: 24 m high from (32, 40) to (56, 64).
        assert_eq!(ground.height_at(32.0, 40.0), Some(24.0));
        assert_eq!(ground.height_at(56.0, 64.0), Some(24.0));
        assert_eq!(ground.height_at(31.0, 50.0), Some(0.0));
        assert_eq!(ground.height_at(57.0, 50.0), Some(0.0));
        assert_eq!(ground.colour_at(44.0, 52.0), TOP);
        assert_eq!(ground.colour_at(44.0, 39.5), SIDES[0]);
        assert_eq!(ground.colour_at(31.5, 52.0), SIDES[1]);
        assert_eq!(ground.colour_at(15.9, 8.0), CHECKS[0]);
        assert_eq!(ground.colour_at(16.1, 8.0), CHECKS[1]);
        // The middle of the ground is on a block, so every view of it shows one.
        assert_eq!(ground.colour_at(128.0, 128.0), TOP);
    }
}
