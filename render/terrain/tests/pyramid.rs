//! The pyramid of resolutions against its definition.

use glam::DVec2;
use proptest::prelude::*;
use sandtable_terrain::{
    Ground, LinearLight, Photo, Pyramid, PyramidLevel, TiledRaster, pre_texture,
};

fn ground(cols: u32, rows: u32) -> Ground {
    Ground::from_fn(cols, rows, DVec2::new(10.0, 12.0), |col, row| {
        let (x, y) = (f64::from(col), f64::from(row));
        ((x * 0.13).sin() * 40.0 + (y * 0.09).cos() * 60.0 + f64::from((col * 7 + row * 3) % 5))
            as f32
    })
    .expect("a sound grid")
}

fn size(level: &PyramidLevel) -> [u32; 2] {
    [level.heights.cols(), level.heights.rows()]
}

fn assert_same(a: &Pyramid, b: &Pyramid) {
    assert_eq!(a.levels(), b.levels());
    for at in 0..a.levels() {
        let (a, b) = (a.level(at), b.level(at));
        for tile in a.heights.tile_indices() {
            assert_eq!(
                a.heights.tile_posts(tile),
                b.heights.tile_posts(tile),
                "level {at}"
            );
            assert_eq!(
                a.colours.tile_posts(tile),
                b.colours.tile_posts(tile),
                "level {at}"
            );
        }
        for row in 0..a.bounds.rows() {
            for col in 0..a.bounds.cols() {
                assert_eq!(a.bounds.get(col, row), b.bounds.get(col, row), "level {at}");
            }
        }
    }
}

#[test]
fn levels_halve_until_two_by_two() {
    let sizes = |cols, rows| -> Vec<_> {
        let pyramid = Pyramid::new(&ground(cols, rows));
        (0..pyramid.levels())
            .map(|at| size(pyramid.level(at)))
            .collect()
    };
    assert_eq!(sizes(9, 3), [[9, 3], [5, 2], [3, 2], [2, 2]]);
    assert_eq!(sizes(6, 6), [[6, 6], [4, 4], [3, 3], [2, 2]]);
    assert_eq!(sizes(2, 2), [[2, 2]]);
}

#[test]
fn the_finest_level_is_the_ground() {
    let ground = ground(300, 270);
    let pyramid = Pyramid::new(&ground);
    let colours = pre_texture(&ground);
    for tile in colours.tile_indices() {
        let finest = pyramid.level(0);
        assert_eq!(
            finest.heights.tile_posts(tile),
            ground.heights().tile_posts(tile)
        );
        assert_eq!(finest.colours.tile_posts(tile), colours.tile_posts(tile));
        // Shared, not copied.
        assert!(std::ptr::eq(
            finest.heights.tile_posts(tile),
            ground.heights().tile_posts(tile)
        ));
    }
}

#[test]
fn coarser_posts_are_the_weighted_mean_of_nine() {
    let light = LinearLight::tables();
    let pyramid = Pyramid::new(&ground(301, 270));
    for at in 1..pyramid.levels() {
        let (fine, coarse) = (pyramid.level(at - 1), pyramid.level(at));
        let [cols, rows] = size(fine).map(i64::from);
        for row in 0..coarse.heights.rows() {
            for col in 0..coarse.heights.cols() {
                let (mut height, mut channels) = (0.0, [0.0; 3]);
                for (dy, up) in [(-1, 0.25), (0, 0.5), (1, 0.25)] {
                    for (dx, along) in [(-1, 0.25), (0, 0.5), (1, 0.25)] {
                        let x = (2 * i64::from(col) + dx).clamp(0, cols - 1) as u32;
                        let y = (2 * i64::from(row) + dy).clamp(0, rows - 1) as u32;
                        height += up * along * f64::from(fine.heights.post(x, y));
                        let colour = fine.colours.post(x, y);
                        for (sum, code) in channels.iter_mut().zip(colour) {
                            *sum += up * along * f64::from(light.decode(code));
                        }
                    }
                }
                let mean = f64::from(coarse.heights.post(col, row));
                assert!(
                    (mean - height).abs() < 1e-5,
                    "level {at}: {mean}, not {height}"
                );
                let [r, g, b, a] = coarse.colours.post(col, row);
                assert_eq!(a, 255);
                for (code, sum) in [r, g, b].into_iter().zip(channels) {
                    // Sums in f32 may fall to the other side of a code's threshold.
                    let [least, most] =
                        [1.0 - 1e-6, 1.0 + 1e-6].map(|near| light.encode((sum * near) as f32));
                    assert!((least..=most).contains(&code), "level {at}: {code}");
                }
            }
        }
    }
}

#[test]
fn a_last_post_beyond_the_border_repeats_it() {
    // Six posts become four; the last lies at 6, one past the last of the six.
    let ground = Ground::from_fn(6, 2, DVec2::ONE, |col, _| (col * 4) as f32).expect("sound");
    let pyramid = Pyramid::new(&ground);
    let row = (0..4).map(|col| pyramid.level(1).heights.post(col, 0));
    assert!(row.eq([1.0, 8.0, 16.0, 20.0]));
}

#[test]
fn colours_are_means_of_light_and_not_of_codes() {
    let checker = Photo {
        pixels: TiledRaster::from_fn(17, 17, |col, row| {
            let code = 255 * ((col + row) % 2) as u8;
            [code, code, code, 255]
        }),
        origin: DVec2::ZERO,
        spacing: DVec2::ONE,
    };
    let ground = Ground::from_fn(17, 17, DVec2::ONE, |_, _| 0.0).expect("sound");
    let pyramid = Pyramid::new(&ground.with_photo(checker));
    // A checker of white and black has half of white's light, which is code 188.
    assert_eq!(pyramid.level(1).colours.post(4, 4), [188, 188, 188, 255]);
}

#[test]
fn an_edit_at_a_tile_corner_gives_the_pyramid_built_anew() {
    let ground = ground(1100, 600);
    let before = Pyramid::new(&ground);
    // Within the range of heights, and out of it, which changes all tints.
    for to in [3.0, 500.0] {
        for (cols, rows) in [
            (511..513, 255..257),
            (512..513, 256..257),
            // Three levels up, this is beside a border that the filter looks over.
            (1026..1027, 300..301),
            (1099..1100, 599..600),
        ] {
            let (edited, changed) = ground.edited(cols, rows, |_, _, _| to).expect("finite");
            assert_same(&before.updated(&edited, &changed), &Pyramid::new(&edited));
        }
    }
    // Tiles that the edit cannot reach are the very same.
    let (edited, changed) = ground
        .edited(10..12, 10..12, |_, _, _| 3.0)
        .expect("finite");
    let after = before.updated(&edited, &changed);
    for at in 0..2 {
        let (before, after) = (before.level(at), after.level(at));
        let last = before.heights.tile_indices().last().expect("a tile");
        let pairs = [
            before.heights.tile_posts(last).as_ptr() == after.heights.tile_posts(last).as_ptr(),
            before.colours.tile_posts(last).as_ptr() == after.colours.tile_posts(last).as_ptr(),
        ];
        assert_eq!(pairs, [true; 2], "level {at}");
    }
}

#[test]
fn another_grid_gives_a_pyramid_built_anew() {
    let (small, large) = (ground(20, 20), ground(30, 25));
    assert_same(
        &Pyramid::new(&small).updated(&large, &[]),
        &Pyramid::new(&large),
    );
}

#[test]
fn any_number_of_threads_builds_the_same_pyramid() {
    let ground = ground(520, 300);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(|| Pyramid::new(&ground))
    };
    let one = build(1);
    assert_same(&one, &build(2));
    assert_same(&one, &build(7));
}

proptest! {
    #[test]
    fn bounds_hold_for_the_surfaces_of_their_level_and_all_finer_ones(
        (cols, rows, heights) in (2_u32..14, 2_u32..14).prop_flat_map(|(cols, rows)| {
            let count = (cols * rows) as usize;
            (Just(cols), Just(rows), prop::collection::vec(-1e4_f32..1e4, count))
        }),
        places in prop::collection::vec((0.0..1.0, 0.0..1.0), 16),
    ) {
        let ground = Ground::from_fn(cols, rows, DVec2::ONE, |col, row| {
            heights[(row * cols + col) as usize]
        }).expect("sound");
        let pyramid = Pyramid::new(&ground);
        for (x, y) in places {
            let (x, y) = (x * f64::from(cols - 1), y * f64::from(rows - 1));
            for upper in 0..pyramid.levels() {
                let cell = |level: usize| {
                    let scale = f64::from(1_u32 << level);
                    [x / scale, y / scale]
                };
                let [cx, cy] = cell(upper);
                let [low, high] = pyramid.level(upper).bounds.get(cx as u32, cy as u32);
                for level in 0..=upper {
                    let [px, py] = cell(level);
                    let finer = &pyramid.level(level).heights;
                    let ([col, row], [u, v]) = finer.locate(px, py);
                    let [sw, se, nw, ne] = finer.cell(col, row).map(f64::from);
                    let south = sw + (se - sw) * u;
                    let height = south + (nw + (ne - nw) * u - south) * v;
                    prop_assert!(height >= f64::from(low) - 1e-6 && height <= f64::from(high) + 1e-6);
                }
            }
        }
    }
}
