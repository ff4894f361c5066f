//! A town as laser scanners see it from above: houses and trees are heights over streets, and walls stand between two
//! posts.

use super::noise::{hash, noise};
use anyhow::Result;
use glam::DVec2;
use sandtable_terrain::{Ground, Photo, TiledRaster};

/// From street to street, and how wide streets are; in a block of houses lots lie two by two. Posts.
const BLOCK: u32 = 64;
const STREET: u32 = 12;
const LOT: u32 = (BLOCK - STREET) / 2;

/// Houses' least and most sides, in posts.
const SIDES: [u32; 2] = [8, 22];
/// Their heights in metres, of which the first three may have gables.
const STOREYS: [f32; 5] = [4.0, 6.0, 9.0, 20.0, 35.0];
const GABLES: f32 = 9.0;
const ROOFS: [[f32; 3]; 4] = [
    [150.0, 70.0, 55.0],
    [120.0, 120.0, 125.0],
    [180.0, 175.0, 165.0],
    [90.0, 95.0, 105.0],
];

/// Trees stand on a grid so many posts wide, a third of whose places have one, and are so wide at most.
const TREES: u32 = 11;
const CROWN: f32 = 5.0;

/// What there is at a post.
#[derive(Clone, Copy)]
enum Place {
    Street,
    Lawn,
    Tree,
    Roof([f32; 3]),
}

/// The ground of `side` by `side` posts, a metre apart, under its photograph, which has `times` by `times` pixels to a
/// post: areas, as posts are.
pub(super) fn ground(side: u32, times: u32) -> Result<Ground> {
    let ground = Ground::from_fn(side, side, DVec2::ONE, |col, row| {
        let [x, y] = [col, row].map(|at| f64::from(at) / 300.0);
        let hills = 40.0 * noise(x, y, 1);
        hills + at(col, row).0
    })?;
    let pixels = TiledRaster::from_fn(times * side, times * side, |col, row| {
        let grain = (hash(col as i32, row as i32, 2) & 255) as f32 / 255.0 - 0.5;
        let [r, g, b] = colour(col, row, times).map(|channel| (channel + 24.0 * grain) as u8);
        [r, g, b, 255]
    });
    let spacing = DVec2::splat(1.0 / f64::from(times));
    Ok(ground.with_photo(Photo {
        pixels,
        origin: 0.5 * (spacing - 1.0),
        spacing,
    }))
}

/// The colour of a pixel, before its grain.
fn colour(col: u32, row: u32, times: u32) -> [f32; 3] {
    let [x, y] = [col, row].map(|at| at / times);
    match at(x, y).1 {
        Place::Lawn => [105.0, 130.0, 70.0],
        Place::Tree => [40.0, 75.0, 35.0],
        // Rows of tiles.
        Place::Roof(colour) => colour.map(|channel| channel - (col / 3 % 2) as f32 * 14.0),
        Place::Street => {
            let [x, y] = [x, y].map(|at| at % BLOCK);
            let middle = STREET / 2;
            let dash = |along: u32| (along / 6).is_multiple_of(2);
            if (x == middle && y >= STREET && dash(row))
                || (y == middle && x >= STREET && dash(col))
            {
                [230.0, 230.0, 220.0]
            } else {
                [95.0, 95.0, 98.0]
            }
        }
    }
}

/// What stands at a post, and how high it is over the ground.
fn at(col: u32, row: u32) -> (f32, Place) {
    let [x, y] = [col, row].map(|at| at % BLOCK);
    if x < STREET || y < STREET {
        return (0.0, Place::Street);
    }
    let lot = |at: u32| {
        (
            at / BLOCK * 2 + (at % BLOCK - STREET) / LOT,
            (at % BLOCK - STREET) % LOT,
        )
    };
    let ((lot_x, x), (lot_y, y)) = (lot(col), lot(row));
    let house = hash(lot_x as i32, lot_y as i32, 3);
    let side = |bits: u32| SIDES[0] + bits % (SIDES[1] - SIDES[0] + 1);
    let (width, depth) = (side(house >> 4), side(house >> 9));
    let [west, south] = [width, depth].map(|side| (LOT - side) / 2);
    let is_in = (west..west + width).contains(&x) && (south..south + depth).contains(&y);
    if is_in && house & 7 != 0 {
        let height = STOREYS[(house >> 14) as usize % STOREYS.len()];
        let roof = ROOFS[(house >> 20) as usize % ROOFS.len()];
        let gable = if height <= GABLES && house & 1 << 24 != 0 {
            0.6 * (x - west).min(west + width - 1 - x) as f32
        } else {
            0.0
        };
        return (height + gable, Place::Roof(roof));
    }
    let tree = hash((col / TREES) as i32, (row / TREES) as i32, 4);
    let [east, north] = [col, row].map(|at| (at % TREES) as f32 - 0.5 * (TREES - 1) as f32);
    let radius = CROWN * (0.4 + 0.6 * (tree >> 8 & 255) as f32 / 255.0);
    let rest = radius * radius - east * east - north * north;
    if tree.is_multiple_of(3) && rest > 0.0 {
        return (2.2 * rest.sqrt(), Place::Tree);
    }
    (0.0, Place::Lawn)
}
