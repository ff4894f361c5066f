//! The ground that is looked at.

use glam::DVec2;
use sandtable_cast::Scene;
use sandtable_terrain::{Ground, Photo, TiledRaster};
use std::sync::Arc;

pub(crate) fn hash(x: u32, y: u32) -> u32 {
    let mut n = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
    n = (n ^ (n >> 15)).wrapping_mul(0x2c1b_3c6d);
    (n ^ (n >> 12)).wrapping_mul(0x297a_2d39)
}

/// Noise in [−1, 1], smooth between points `size` apart.
fn noise(x: f64, y: f64, size: f64) -> f64 {
    let (x, y) = (x / size, y / size);
    let at = |x: f64, y: f64| f64::from(hash(x as u32 + 7, y as u32 + 3) >> 8) / 8_388_608.0 - 1.0;
    let blend = |a: f64, b: f64, share: f64| a + (b - a) * share * share * (3.0 - 2.0 * share);
    let (u, v) = (x.fract(), y.fract());
    let (x, y) = (x.floor(), y.floor());
    let south = blend(at(x, y), at(x + 1.0, y), u);
    let north = blend(at(x, y + 1.0), at(x + 1.0, y + 1.0), u);
    blend(south, north, v)
}

/// Mountains of all sizes, a metre from post to post.
pub(crate) fn mountains() -> Ground {
    let height = |col: u32, row: u32| {
        let octave = |k: i32| {
            let size = 128.0 / f64::from(1 << k);
            0.3 * size * noise(f64::from(col), f64::from(row), size)
        };
        (0..7).map(octave).sum::<f64>() as f32
    };
    Ground::from_fn(700, 600, DVec2::ONE, height).expect("a sound grid")
}

/// A house of a town: how high it is over the street at a post, and its colour.
fn house(col: u32, row: u32) -> Option<(f32, [u8; 3])> {
    const LOT: u32 = 24;
    let kind = hash(col / LOT, row / LOT);
    let is_within = |at: u32, bits: u32| (4..12 + bits % 10).contains(&(at % LOT));
    let height = [6.0, 10.0, 20.0, 35.0][(kind >> 20) as usize % 4];
    let colour = [[150, 70, 55], [180, 175, 165], [90, 95, 105]][(kind >> 24) as usize % 3];
    (is_within(col, kind >> 4) && is_within(row, kind >> 9)).then_some((height, colour))
}

/// Houses with flat roofs, a metre from post to post, whose walls stand between two posts; under a photo with so many
/// pixels to a post along each side, which are areas, as posts are.
pub(crate) fn town(times: u32) -> Ground {
    let size = [480, 400];
    let height = |col: u32, row: u32| house(col, row).map_or(0.0, |(height, _)| height);
    let ground = Ground::from_fn(size[0], size[1], DVec2::ONE, height).expect("a sound grid");
    let pixel = |x: u32, y: u32| {
        let [r, g, b] = house(x / times, y / times).map_or([105, 130, 70], |(_, colour)| colour);
        let grain = (hash(x, y) >> 28) as u8;
        [r + grain, g + grain, b + grain, 255]
    };
    let spacing = DVec2::splat(1.0 / f64::from(times));
    ground.with_photo(Photo {
        pixels: TiledRaster::from_fn(times * size[0], times * size[1], pixel),
        origin: 0.5 * (spacing - 1.0),
        spacing,
    })
}

/// Waves on posts that lie so far apart along x and along y, as those of maps in degrees do far north, under a photo with
/// a pixel a post.
pub(crate) fn oblong(spacing: DVec2) -> Ground {
    let posts = (700.0 / spacing).as_uvec2();
    let at = |col: u32, row: u32| DVec2::new(f64::from(col), f64::from(row)) * spacing / 40.0;
    let height = |col: u32, row: u32| {
        let DVec2 { x, y } = at(col, row);
        (12.0 * ((x + 0.4 * y).sin() + (1.7 * x - y).cos())) as f32
    };
    let pixel = |col: u32, row: u32| {
        let DVec2 { x, y } = at(col, row);
        let level = 120.0 + 50.0 * (2.0 * x + 0.3 * y).sin() + 40.0 * (y - x).cos();
        let level = level as u8 + (hash(col, row) >> 27) as u8;
        [level, 255 - level, level / 2, 255]
    };
    let ground = Ground::from_fn(posts.x, posts.y, spacing, height).expect("a sound grid");
    ground.with_photo(Photo {
        pixels: TiledRaster::from_fn(posts.x, posts.y, pixel),
        origin: DVec2::ZERO,
        spacing,
    })
}

/// A photo with detail of all sizes, down to single pixels of half a metre.
pub(crate) fn photo() -> Photo {
    photo_of([1400, 1200])
}

/// The same with so many pixels.
pub(crate) fn photo_of([cols, rows]: [u32; 2]) -> Photo {
    let pixel = |x: u32, y: u32| {
        let fine = f64::from(hash(x, y) >> 24) - 128.0;
        let coarse = 90.0 * noise(f64::from(x), f64::from(y), 31.0);
        let level = (120.0 + 0.5 * fine + coarse).clamp(0.0, 255.0) as u8;
        [level, level / 2 + 60, 200 - level / 2, 255]
    };
    Photo {
        pixels: TiledRaster::from_fn(cols, rows, pixel),
        origin: DVec2::ZERO,
        spacing: DVec2::splat(0.5),
    }
}

/// Level ground of so many posts a side, a metre apart.
pub(crate) fn level(posts: u32) -> Ground {
    Ground::from_fn(posts, posts, DVec2::ONE, |_, _| 0.0).expect("a sound grid")
}

/// The same under a photo with a pixel a post.
pub(crate) fn level_under(posts: u32, pixel: impl Fn(u32, u32) -> [u8; 4] + Sync) -> Arc<Scene> {
    Scene::new(level(posts).with_photo(Photo {
        pixels: TiledRaster::from_fn(posts, posts, pixel),
        origin: DVec2::ZERO,
        spacing: DVec2::ONE,
    }))
}
