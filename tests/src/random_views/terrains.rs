//! The grounds that random views are of: few, since they take long to build, and each hard in a
//! way of its own.

use glam::DVec2;
use sandtable_cast::Scene;
use sandtable_terrain::{Ground, Photo, TerrainSource, TiledRaster};
use std::sync::{Arc, LazyLock};

/// A ground and what to call it.
pub(super) struct Terrain {
    pub(super) name: &'static str,
    /// Built by whoever asks first.
    pub(super) scene: LazyLock<Arc<Scene>>,
}

const fn terrain(name: &'static str, build: fn() -> Arc<Scene>) -> Terrain {
    Terrain {
        name,
        scene: LazyLock::new(build),
    }
}

pub(super) static TERRAINS: [Terrain; 13] = [
    terrain("mountains", || builtin("builtin:ridges?size=513", None)),
    terrain("mountains with half a photo", || {
        builtin("builtin:ridges?size=1025&seed=7", Some(0.6))
    }),
    terrain("real hills", || builtin("builtin:jacksboro", None)),
    terrain("4097² posts", || {
        made([4097, 4097], [25.0, 20.0], |x, y| {
            1500.0 * fractal(x / 600.0, y / 600.0, 5)
        })
    }),
    // High up, where a float's steps are coarse, with another slope in every cell.
    terrain("a rough plateau", || {
        made([257, 385], [10.0, 30.0], |x, y| {
            5000.0 + 300.0 * fractal(x / 90.0, y / 40.0, 3) + 16.0 * lattice(x, y, 9)
        })
    }),
    terrain("a tilted plane", || {
        made([33, 33], [90.0, 30.0], |x, y| 40.0 + 7.0 * x - 3.0 * y)
    }),
    terrain("a level plane", || {
        made([65, 33], [12.0, 10.0], |_, _| 120.0)
    }),
    terrain("boxes", || {
        made([193, 129], [2.0, 6.0], |x, y| {
            (90.0 * lattice((x / 9.0).floor(), (y / 7.0).floor(), 4) - 30.0).max(0.0)
        })
    }),
    terrain("terraces", || {
        made([129, 257], [20.0, 8.0], |x, y| {
            25.0 * (8.0 * fractal(x / 40.0, y / 90.0, 2)).floor()
        })
    }),
    terrain("spikes and fences", || made([161, 161], [5.0, 5.0], spike)),
    // A twist in every cell: no cell is a plane, and half of them are bent towards each side.
    terrain("saddles", || {
        made([97, 65], [4.0, 12.0], |x, y| {
            15.0 * ((x + y) % 2.0) + 40.0 * fractal(x / 30.0, y / 20.0, 2)
        })
    }),
    terrain("smooth waves under a photo", || {
        let ground = ground([385, 321], [12.0, 10.0], |x, y| {
            90.0 * (x / 23.0).sin() * (y / 31.0).cos() + 25.0 * (x / 7.0 + y / 11.0).sin()
        });
        Scene::new(with_photo(ground, 1.0))
    }),
    terrain("pebbles", || {
        made([129, 129], [0.05, 0.04], |x, y| {
            0.4 * fractal(x / 12.0, y / 12.0, 4)
        })
    }),
];

/// A built-in terrain, and a photograph that covers a share of each side.
fn builtin(name: &str, photo: Option<f64>) -> Arc<Scene> {
    let source: TerrainSource = name.parse().expect("a terrain's name");
    let terrain = sandtable_terrain::open(&source, None).expect("it needs no file");
    Scene::new(match photo {
        Some(share) => with_photo(terrain.ground, share),
        None => terrain.ground,
    })
}

/// Ground of `posts` (columns, rows) that lie `spacing` metres apart; its height is a function of
/// column and row.
fn made(posts: [u32; 2], spacing: [f64; 2], height: fn(f64, f64) -> f64) -> Arc<Scene> {
    Scene::new(ground(posts, spacing, height))
}

fn ground(
    [cols, rows]: [u32; 2],
    spacing: [f64; 2],
    height: impl Fn(f64, f64) -> f64 + Sync,
) -> Ground {
    let height = |col: u32, row: u32| height(f64::from(col), f64::from(row)) as f32;
    Ground::from_fn(cols, rows, DVec2::from(spacing), height).expect("a sound grid")
}

/// Soft coloured patches over the middle `share` of each side, with pixels that fit no cell.
fn with_photo(ground: Ground, share: f64) -> Ground {
    let extent = ground.grid().extent();
    let spacing = ground.grid().spacing * DVec2::new(0.7, 1.3);
    let sides = (extent * share / spacing).ceil().as_uvec2() + 1;
    let pixels = TiledRaster::from_fn(sides.x, sides.y, |col, row| {
        let (x, y) = (f64::from(col) / 25.0, f64::from(row) / 15.0);
        let channel = |shift: f64| (127.0 + 120.0 * fractal(x + shift, y, 2)) as u8;
        [channel(0.0), channel(100.0), channel(200.0), 255]
    });
    ground.with_photo(Photo {
        pixels,
        origin: 0.5 * (1.0 - share) * extent,
        spacing,
    })
}

/// An almost level plain with spikes one post wide, and fences of one row, one column and one
/// diagonal of posts.
fn spike(x: f64, y: f64) -> f64 {
    let plain = 0.5 * fractal(x / 20.0, y / 20.0, 2);
    let fence = x == 50.0 || y == 110.0 || x - y == 20.0;
    let chance = lattice(x, y, 2);
    if fence {
        12.0
    } else if chance > 0.99 {
        plain + 40.0 + 1e4 * (chance - 0.99)
    } else {
        plain
    }
}

/// Octaves of value noise, the broadest of wavelength 1 and the next ones ever half as long and
/// high: within ±1.
fn fractal(x: f64, y: f64, octaves: u64) -> f64 {
    let (mut sum, mut share, mut scale) = (0.0, 0.5, 1.0);
    for octave in 0..octaves {
        sum += share * (2.0 * value_noise(scale * x, scale * y, octave) - 1.0);
        share *= 0.5;
        scale *= 2.0;
    }
    sum
}

/// Random values at whole places, from 0 to 1, and smooth between them.
fn value_noise(x: f64, y: f64, seed: u64) -> f64 {
    let (col, row) = (x.floor(), y.floor());
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (u, v) = (smooth(x - col), smooth(y - row));
    let at = |dx: f64, dy: f64| lattice(col + dx, row + dy, seed);
    let south = at(0.0, 0.0) + u * (at(1.0, 0.0) - at(0.0, 0.0));
    let north = at(0.0, 1.0) + u * (at(1.0, 1.0) - at(0.0, 1.0));
    south + v * (north - south)
}

/// A whole place's own random value, from 0 to 1.
fn lattice(x: f64, y: f64, seed: u64) -> f64 {
    let mut bits = (x as i64 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as i64 as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
        ^ seed.wrapping_mul(0x1656_67b1_9e37_79f9);
    bits = (bits ^ (bits >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    bits = (bits ^ (bits >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    (bits >> 40) as f64 / (1u64 << 24) as f64
}
