//! Level of detail of the default caster: calmer than one point a pixel, and nowhere worse.

use glam::{DVec2, DVec3};
use sandtable_cast::{CastPool, Image, Planes, Scene, caster_by_name, standpoints};
use sandtable_terrain::{Ground, LinearLight, Photo, TiledRaster};
use sandtable_view::{Attitude, Camera, Screen, View};
use std::sync::Arc;

fn hash(x: u32, y: u32) -> u32 {
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
fn mountains() -> Ground {
    let height = |col: u32, row: u32| {
        let octave = |k: i32| {
            let size = 128.0 / f64::from(1 << k);
            0.3 * size * noise(f64::from(col), f64::from(row), size)
        };
        (0..7).map(octave).sum::<f64>() as f32
    };
    Ground::from_fn(700, 600, DVec2::ONE, height).expect("a sound grid")
}

/// A photo with detail of all sizes, down to single pixels of half a metre.
fn photo() -> Photo {
    let pixel = |x: u32, y: u32| {
        let fine = f64::from(hash(x, y) >> 24) - 128.0;
        let coarse = 90.0 * noise(f64::from(x), f64::from(y), 31.0);
        let level = (120.0 + 0.5 * fine + coarse).clamp(0.0, 255.0) as u8;
        [level, level / 2 + 60, 200 - level / 2, 255]
    };
    Photo {
        pixels: TiledRaster::from_fn(1400, 1200, pixel),
        origin: DVec2::ZERO,
        spacing: DVec2::splat(0.5),
    }
}

fn cast(caster: &str, scene: &Arc<Scene>, views: &[View]) -> Vec<Image> {
    let caster = caster_by_name(caster).expect("there is one");
    let pool = CastPool::new(2).expect("threads");
    let prepared = pool
        .run(|| caster.prepare(Arc::clone(scene)))
        .expect("suits");
    let mut images = vec![Image::default(); views.len()];
    pool.cast(&*prepared, views, &mut images).expect("accepted");
    images
}

/// The mean colours of 8 × 8 rays a pixel, in linear light.
fn truth(scene: &Arc<Scene>, view: &View) -> Vec<[u8; 4]> {
    const SIDE: u32 = 8;
    let right = (view.ray(1, 0).direction - view.ray(0, 0).direction) / f64::from(SIDE);
    let down = (view.ray(0, 1).direction - view.ray(0, 0).direction) / f64::from(SIDE);
    let shifted: Vec<_> = (0..SIDE * SIDE)
        .map(|k| {
            let middle = f64::from(SIDE - 1) / 2.0;
            let [i, j] = [k % SIDE, k / SIDE].map(|at| f64::from(at) - middle);
            let shift = right * i + down * j;
            let mut view = *view;
            view.window.upper_left += shift;
            view.window.lower_left += shift;
            view.window.lower_right += shift;
            view
        })
        .collect();
    let light = LinearLight::tables();
    let images = cast("planes", scene, &shifted);
    (0..images[0].colour().len())
        .map(|at| {
            let mean = |channel: usize| {
                let light_of = |image: &Image| light.decode(image.colour()[at][channel]);
                let sum: f32 = images.iter().map(light_of).sum();
                light.encode(sum / images.len() as f32)
            };
            [mean(0), mean(1), mean(2), 255]
        })
        .collect()
}

/// The ratio of signal to noise in decibels.
fn decibels(colours: &[[u8; 4]], truth: &[[u8; 4]]) -> f64 {
    let error = |(a, b): (&[u8; 4], &[u8; 4])| {
        let channel = |k: usize| (f64::from(a[k]) - f64::from(b[k])).powi(2);
        channel(0) + channel(1) + channel(2)
    };
    let sum: f64 = colours.iter().zip(truth).map(error).sum();
    10.0 * (255.0 * 255.0 * 3.0 * colours.len() as f64 / sum.max(1e-9)).log10()
}

fn camera(eye: DVec3, pitch: f64, size: [u32; 2]) -> View {
    let attitude = Attitude {
        yaw: 0.4,
        pitch,
        roll: 0.2,
    };
    let horizontal_fov = 1.0;
    Camera {
        eye,
        attitude,
        horizontal_fov,
    }
    .view(size)
}

/// Point sampling's and level of detail's decibels.
fn compared(scene: &Arc<Scene>, view: View) -> [f64; 2] {
    let truth = truth(scene, &view);
    ["planes", Planes::WITH_DETAIL].map(|caster| {
        let images = cast(caster, scene, &[view]);
        decibels(images[0].colour(), &truth)
    })
}

#[test]
fn pixels_that_cover_much_are_nearer_to_the_truth() {
    for (name, ground) in [
        ("photo", mountains().with_photo(photo())),
        ("tints", mountains()),
    ] {
        let scene = Scene::new(ground);
        let views = [
            camera(DVec3::new(60.0, 20.0, 150.0), -0.4, [160, 120]),
            camera(DVec3::new(300.0, 250.0, 600.0), -1.5, [160, 120]),
            standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.7, 0.6), [200, 120]),
        ];
        for (k, view) in views.into_iter().enumerate() {
            let [points, detail] = compared(&scene, view);
            println!("{name}, view {k}: {points:.2} dB, with detail {detail:.2}");
            assert!(detail > points + 1.0, "{name}, view {k}");
        }
    }
}

#[test]
fn pixels_that_cover_little_are_no_worse() {
    let scene = Scene::new(mountains().with_photo(photo()));
    let over = |x: f64, y: f64, height: f64| {
        let ground = scene.ground.height_at(x, y).expect("on the ground");
        DVec3::new(x, y, ground + height)
    };
    for (k, view) in [
        camera(over(200.0, 200.0, 12.0), -1.4, [200, 150]),
        camera(over(320.0, 210.0, 3.0), -0.6, [400, 300]),
    ]
    .into_iter()
    .enumerate()
    {
        let [points, detail] = compared(&scene, view);
        println!("view {k}: {points:.2} dB, with detail {detail:.2}");
        // Weights of colours are rounded otherwise: that is all that may differ.
        assert!(detail > points - 0.02, "view {k}");
    }
}

/// Where all pixels are narrower than posts, rays go as they do without detail.
#[test]
fn narrow_pixels_see_the_ground_exactly() {
    let scene = Scene::new(mountains().with_photo(photo()));
    let over = |x: f64, y: f64, height: f64| {
        let ground = scene.ground.height_at(x, y).expect("on the ground");
        DVec3::new(x, y, ground + height)
    };
    let close = standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.7, 0.6), [1600, 1000]);
    for (view, all_magnified) in [
        (camera(over(320.0, 210.0, 30.0), -1.4, [320, 240]), true),
        (camera(over(200.0, 300.0, 9.0), -0.9, [400, 300]), true),
        (close, false),
    ] {
        let [exact, detail] =
            ["planes", Planes::WITH_DETAIL].map(|caster| cast(caster, &scene, &[view]).remove(0));
        // Rays wait for their colours a step longer, and go on from other places: that is rounded otherwise.
        let mut depths = exact.depth.iter().zip(&detail.depth);
        let is_near = |(a, b): (&f32, &f32)| a == b || (a - b).abs() < 1e-5 * a.min(*b);
        assert!(depths.all(is_near));
        // Where footprints are no larger than a pixel of the photo colours are the same but for rounding.
        let pairs = exact.colour().iter().zip(detail.colour());
        let near = pairs.filter(|(a, b)| (0..3).all(|k| a[k].abs_diff(b[k]) <= 1));
        let (near, all) = (near.count(), exact.colour().len());
        println!("{near} of {all} colours are the same");
        assert!(2 * near > all && (near == all) == all_magnified);
    }
}

#[test]
fn a_plane_is_a_plane_at_all_levels_and_ends_where_it_ends() {
    // 701 by 514 posts: a coarse level's last cells reach out over the border.
    let height = |col: u32, row: u32| 0.125 * col as f32 - 0.25 * row as f32;
    let ground = Ground::from_fn(701, 514, DVec2::new(2.0, 3.0), height).expect("a sound grid");
    let scene = Scene::new(ground);
    for view in [
        camera(DVec3::new(300.0, -200.0, 400.0), -0.5, [150, 100]),
        camera(DVec3::new(-700.0, -500.0, 900.0), -0.6, [90, 70]),
        camera(DVec3::new(700.0, 700.0, 5000.0), -1.5, [200, 200]),
    ] {
        let [exact, detail] = ["planes", "planes?lod=on&cell=8"]
            .map(|caster| cast(caster, &scene, &[view]).remove(0));
        let [width, height] = view.size;
        for (i, j) in (0..height).flat_map(|j| (0..width).map(move |i| (i, j))) {
            let at = (j * width + i) as usize;
            let (a, b) = (exact.depth[at], detail.depth[at]);
            // A pixel that has the border in it may end on either side; it lies between planes up to
            // 1.1 pixels apart, and on ground seen from aside it is longer than wide.
            let pixel = 2.0 * (0.5_f64).tan() / f64::from(width) * f64::from(a.min(b));
            let extent = scene.ground.grid().extent();
            let on_border = exact
                .point(i, j)
                .or(detail.point(i, j))
                .is_some_and(|point| {
                    let inside = point.truncate().min(extent - point.truncate());
                    let above: f64 = (view.eye.z - point.z) / f64::from(a.min(b));
                    inside.min_element() < pixel * (0.6 / above).max(1.1)
                });
            let same = a == b || (a - b).abs() < 2e-3 * a;
            let point = exact.point(i, j);
            assert!(
                same || on_border,
                "{a} m and {b} m at {i}, {j}: {point:?} of {extent}"
            );
        }
    }
}

/// Wherever the eye is, over the ground or beside it: where a pixel and all around it see ground, it does so
/// with detail, too, and about as far away; and where all see the sky it sees that.
#[test]
fn no_ground_is_lost_and_none_is_made_up() {
    let scene = Scene::new(mountains().with_photo(photo()));
    let share = |k: u32, of: u32| f64::from(hash(k, of) >> 8) / 16_777_216.0;
    let extent = scene.ground.grid().extent();
    let middle = (0.5 * extent).extend(60.0);
    let mut views = Vec::new();
    for k in 0..240 {
        // Tables that the ground is smaller than, and eyes all around it that look at its middle.
        let around = std::f64::consts::TAU * share(k, 1);
        let away = extent.x * (0.2 + 1.3 * share(k, 2));
        let eye = middle + away * DVec3::new(around.cos(), around.sin(), 0.2 + share(k, 3));
        let towards =
            middle + 0.4 * extent.x * DVec3::new(share(k, 4) - 0.5, share(k, 5) - 0.5, 0.0);
        let d = towards - eye;
        let size = [240, 160].map(|side| (f64::from(side) * (1.0 + 2.0 * share(k, 6))) as u32);
        if k % 2 == 0 {
            let camera = Camera {
                eye,
                attitude: Attitude {
                    yaw: d.x.atan2(d.y),
                    pitch: d.z.atan2(d.truncate().length()),
                    roll: 3.0 * share(k, 7),
                },
                horizontal_fov: 1.4,
            };
            views.push(camera.view(size));
        } else {
            // A horizontal window below the eye, in which the pixel straight down may be.
            let up = DVec3::new(-around.cos(), -around.sin(), 0.0);
            let right = DVec3::new(up.y, -up.x, 0.0);
            let glass = DVec3::new(middle.x, middle.y, 0.0) - away * 0.1 * up;
            let [half_width, half_height] = [0.9 * away, 0.6 * away];
            let corner = |x: f64, y: f64| glass + x * half_width * right + y * half_height * up;
            views.push(View {
                eye,
                window: Screen {
                    lower_left: corner(-1.0, -1.0),
                    lower_right: corner(1.0, -1.0),
                    upper_left: corner(-1.0, 1.0),
                },
                size,
            });
        }
    }
    let exact = cast("planes", &scene, &views);
    let detail = cast(Planes::WITH_DETAIL, &scene, &views);
    let (mut looked, mut lost) = (0, Vec::new());
    for (k, (exact, detail)) in exact.iter().zip(&detail).enumerate() {
        let [width, height] = views[k].size.map(|side| side as usize);
        let mut wrong = 0;
        for (j, i) in (3..height - 3).flat_map(|j| (3..width - 3).map(move |i| (j, i))) {
            let around =
                (j - 3..=j + 3).flat_map(|j| &exact.depth[j * width + i - 3..=j * width + i + 3]);
            let [least, most] = around.fold([f32::INFINITY, 0.0], |[least, most], &depth| {
                [depth.min(least), depth.max(most)]
            });
            let depth = detail.depth[j * width + i];
            looked += 1;
            let is_wrong = if least == f32::INFINITY {
                depth.is_finite()
            } else {
                most.is_finite() && !(0.9 * least..=1.1 * most).contains(&depth)
            };
            wrong += u32::from(is_wrong);
        }
        if wrong > 0 {
            lost.push((k, wrong));
        }
    }
    println!("{looked} pixels");
    assert!(looked > 1_000_000);
    assert!(lost.is_empty(), "views and pixels: {lost:?}");
}

/// As a table's terrain grows, resolutions change, and at last rays take over from planes altogether: no
/// picture differs from the one before it by more than those around do.
#[test]
fn a_zoom_is_calm() {
    const FRAMES: i32 = 160;
    // A photo with more pixels than the ground has posts, and none.
    let scenes = [mountains().with_photo(photo()), mountains()].map(Scene::new);
    let eyes = [[0.0, -0.7, 0.6], [0.5, -1.2, 0.5]];
    for (scene, eye) in scenes.iter().flat_map(|scene| eyes.map(|eye| (scene, eye))) {
        let table = standpoints::at_table(&scene.ground, DVec3::from_array(eye), [320, 200]);
        let middle = 0.5 * (table.window.lower_right + table.window.upper_left);
        let views: Vec<_> = (0..=FRAMES)
            .map(|frame| {
                let scale = 2.0 * 8.0_f64.powf(-f64::from(frame) / f64::from(FRAMES));
                let window = table
                    .window
                    .map(|corner| middle + scale * (corner - middle));
                View { window, ..table }
            })
            .collect();
        let images = cast(Planes::WITH_DETAIL, scene, &views);
        let changes: Vec<_> = images
            .windows(2)
            .map(|pair| {
                let colours = pair[0].colour().iter().zip(pair[1].colour());
                let change = |(a, b): (&[u8; 4], &[u8; 4])| {
                    (0..3).map(|k| f64::from(a[k].abs_diff(b[k]))).sum::<f64>()
                };
                colours.map(change).sum::<f64>()
            })
            .collect();
        let mut most = 0.0_f64;
        for around in changes.windows(9) {
            let mut sorted = around.to_vec();
            sorted.sort_by(f64::total_cmp);
            most = most.max(around[4] / sorted[4]);
        }
        println!("a change is up to {most:.2} times those around it");
        assert!(most < 1.2, "{most}");
    }
}

/// As an eye rises over a flat photo of noise, the image gets evener: not all at once, where all
/// pixels come to a coarser level.
#[test]
fn levels_change_by_halves() {
    let flat = Ground::from_fn(700, 600, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let noise = |x: u32, y: u32| {
        let level = (hash(x, y) >> 24) as u8;
        [level, level, level, 255]
    };
    let scene = Scene::new(flat.with_photo(Photo {
        pixels: TiledRaster::from_fn(1400, 1200, noise),
        ..photo()
    }));
    const STEPS: i32 = 24;
    let views: Vec<_> = (0..=STEPS)
        .map(|k| {
            let height = 200.0 * 2.0_f64.powf(f64::from(k) / f64::from(STEPS));
            camera(DVec3::new(350.0, 300.0, height), -1.57, [160, 120])
        })
        .collect();
    let contrasts: Vec<_> = cast(Planes::WITH_DETAIL, &scene, &views)
        .iter()
        .map(|image| {
            let levels = image.colour().iter().map(|colour| f64::from(colour[0]));
            let count = image.colour().len() as f64;
            let mean = levels.clone().sum::<f64>() / count;
            let square: f64 = levels.map(|level| (level - mean).powi(2)).sum();
            (square / count).sqrt().log2()
        })
        .collect();
    let all = contrasts[0] - contrasts[STEPS as usize];
    let steps = contrasts.windows(2).map(|pair| pair[0] - pair[1]);
    let most = steps.fold(0.0, f64::max);
    println!("log2 of contrast falls by {all:.2}, at once by {most:.2}");
    // A photo finer than posts is seen as means of a post's width from there on.
    assert!(all > 0.55, "{all}");
    assert!(most < 0.75 * all, "{most} of {all}");
}

/// What a thread has cast before leaves no trace, so that an image is the same on any thread.
#[test]
fn what_was_cast_before_changes_nothing() {
    // Spikes make many rays begin where others than those right before them have ended.
    let spikes = |col: u32, row: u32| {
        let hills = 20.0 * ((f64::from(col) * 0.03).sin() + (f64::from(row) * 0.041).cos());
        let spike = if hash(col, row).is_multiple_of(97) {
            15.0
        } else {
            0.0
        };
        (hills + spike) as f32
    };
    let scene = Scene::new(Ground::from_fn(500, 500, DVec2::ONE, spikes).expect("a sound grid"));
    let share = |k: u32, of: u32| f64::from(hash(k, of) >> 8) / 16_777_216.0;
    let views: Vec<_> = (0..60)
        .map(|k| {
            let eye = [500.0, 500.0, 400.0].map(|most| most * share(k, most as u32 + 1));
            let turned = |of: u32| std::f64::consts::TAU * share(k, of);
            Camera {
                eye: DVec3::from_array(eye) + 40.0 * DVec3::Z,
                attitude: Attitude {
                    yaw: turned(1),
                    pitch: -1.5 * share(k, 2),
                    roll: turned(3),
                },
                horizontal_fov: 0.5 + share(k, 4),
            }
            .view([320, 240])
        })
        .collect();
    let one_by_one: Vec<_> = views
        .iter()
        .map(|view| cast(Planes::WITH_DETAIL, &scene, &[*view]).remove(0))
        .collect();
    let pool = CastPool::new(1).expect("a thread");
    let caster = caster_by_name(Planes::WITH_DETAIL).expect("there is one");
    let prepared = caster.prepare(scene).expect("suits");
    let mut image = [Image::default()];
    for (k, (view, alone)) in views.iter().zip(&one_by_one).enumerate() {
        pool.cast(&*prepared, &[*view], &mut image)
            .expect("accepted");
        assert!(image[0].colour() == alone.colour(), "colours of view {k}");
        assert!(image[0].depth == alone.depth, "depths of view {k}");
    }
}

#[test]
fn an_even_colour_stays_even() {
    let mut photo = photo();
    photo.pixels = TiledRaster::from_fn(1400, 1200, |_, _| [200, 100, 7, 255]);
    let scene = Scene::new(mountains().with_photo(photo));
    let view = camera(DVec3::new(60.0, 20.0, 150.0), -0.4, [160, 120]);
    let image = cast(Planes::WITH_DETAIL, &scene, &[view]).remove(0);
    // Pixels in the midst of ground: where it ends, they have their part of the sky.
    let [width, height] = view.size;
    let inside = (1..height - 1).flat_map(|j| (1..width - 1).map(move |i| [i, j]));
    let is_inside = |&[i, j]: &[u32; 2]| {
        (j - 1..=j + 1).all(|j| {
            let row = (j * width + i) as usize;
            image.depth[row - 1..=row + 1]
                .iter()
                .all(|depth| depth.is_finite())
        })
    };
    let inside: Vec<_> = inside.filter(is_inside).collect();
    assert!(inside.len() > 5000);
    for [i, j] in inside {
        let colour = image.colour()[(j * width + i) as usize];
        assert_eq!(colour, [200, 100, 7, 255], "{i}, {j}");
    }
}

#[test]
fn a_flight_is_as_calm_as_the_truth() {
    let scene = Scene::new(mountains().with_photo(photo()));
    let frames: Vec<_> = (0..5)
        .map(|frame| {
            let eye = DVec3::new(60.0, 20.0 + 0.25 * f64::from(frame), 130.0);
            camera(eye, -0.4, [120, 90])
        })
        .collect();
    let truths: Vec<_> = frames.iter().map(|view| truth(&scene, view)).collect();
    // The mean of changes from frame to frame, and the root of the mean square by which they are
    // other than the truth's.
    let changes = |colours: &[Vec<[u8; 4]>]| {
        let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
        for (pair, truth) in colours.windows(2).zip(truths.windows(2)) {
            for at in 0..pair[0].len() {
                for k in 0..3 {
                    let change = |frames: &[Vec<[u8; 4]>]| {
                        f64::from(frames[1][at][k]) - f64::from(frames[0][at][k])
                    };
                    sum += change(pair).abs();
                    square += (change(pair) - change(truth)).powi(2);
                    count += 1.0;
                }
            }
        }
        [sum / count, f64::sqrt(square / count)]
    };
    let [truth_change, _] = changes(&truths);
    let [points, detail] = ["planes", Planes::WITH_DETAIL].map(|caster| {
        let images = cast(caster, &scene, &frames);
        let colours: Vec<_> = images.iter().map(|image| image.colour().to_vec()).collect();
        changes(&colours)
    });
    println!("change {truth_change:.2}, points {points:.2?}, detail {detail:.2?}");
    // Of this photo, which is noise, the filter leaves a little less than the truth has.
    assert!((0.7..1.1).contains(&(detail[0] / truth_change)));
    assert!(detail[1] < 0.4 * points[1]);
}

/// Rays that meet flat ground right at lines of posts: its slope is that of the horizon there, to the last
/// bit, so that nothing tells by itself whether a line has been seen.
#[test]
fn white_ground_has_no_specks() {
    let ground = Ground::from_fn(301, 301, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let white = Photo {
        pixels: TiledRaster::from_fn(301, 301, |_, _| [255; 4]),
        origin: DVec2::ZERO,
        spacing: DVec2::ONE,
    };
    let scene = Scene::new(ground.with_photo(white));
    let views: Vec<_> = [16.0, 32.0, 64.0, 128.0]
        .into_iter()
        .flat_map(|height| [32.0, 64.0, 128.0].map(|steps| [height, steps]))
        .map(|[height, steps]| {
            // A pixel's ray goes down by so many of `steps` for each metre northwards.
            let eye = DVec3::new(150.0, 4.0, height);
            let corner = |x: f64, z: f64| eye + DVec3::new(x / steps, 1.0, z / steps);
            View {
                eye,
                window: Screen {
                    lower_left: corner(-48.0, -128.5),
                    lower_right: corner(48.0, -128.5),
                    upper_left: corner(-48.0, -0.5),
                },
                size: [96, 128],
            }
        })
        .collect();
    let exact = cast("planes", &scene, &views);
    let detailed = cast("planes?lod=on", &scene, &views);
    for (number, (exact, image)) in exact.iter().zip(&detailed).enumerate() {
        let is_ground = |at: usize| exact.depth[at].is_finite();
        let mut inside = 0;
        for at in 97..96 * 127 - 1 {
            let around = [at - 97, at - 95, at + 95, at + 97];
            if (1..95).contains(&(at % 96)) && around.into_iter().all(is_ground) {
                let seen = image.colour()[at];
                let [column, row] = [at % 96, at / 96];
                assert!(
                    seen[0] >= 254,
                    "{seen:?} at {column}, {row} of view {number}"
                );
                inside += 1;
            }
        }
        assert!(inside > 500, "{inside} pixels of view {number}");
    }
}

/// Where two walls meet before the sky a pixel is as much ground as it covers of it, wherever the edge lies in it: it
/// does not hop from pixel to pixel as the eye moves.
#[test]
fn edges_of_walls_move_by_less_than_pixels() {
    let white = |_: u32, _: u32| [255; 4];
    let photo = Photo {
        pixels: TiledRaster::from_fn(301, 301, white),
        origin: DVec2::ZERO,
        spacing: DVec2::ONE,
    };
    let ground = Ground::from_fn(301, 301, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let scene = Scene::new(ground.with_photo(photo));
    for (turn, roll) in [(0.4, 0.0), (1.2, 0.0), (2.3, 1.1), (4.0, 0.5), (5.1, -1.0)] {
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for k in 0..8 {
            // An eighth of a pixel aside each.
            let away = (0.8 * DVec2::from_angle(turn)).extend(0.6);
            let aside = DVec2::from_angle(turn).perp() * 0.6 * f64::from(k);
            let view = Camera {
                eye: DVec3::new(150.0, 150.0, 0.0) + 1500.0 * away + aside.extend(0.0),
                attitude: Attitude {
                    yaw: (-away.x).atan2(-away.y),
                    pitch: -0.6_f64.asin(),
                    roll,
                },
                horizontal_fov: 0.4,
            }
            .view([128, 96]);
            let truth = truth(&scene, &view);
            let images = cast("planes?lod=on", &scene, &[view]);
            let errors = images[0].colour().iter().zip(&truth);
            let error = errors
                .map(|(a, b)| f64::from(a[1].abs_diff(b[1])).powi(2))
                .sum::<f64>();
            worst = worst.max(error);
            sum += error;
        }
        let mean = sum / 8.0;
        println!("{turn}, {roll}: {worst:.0} at worst, {mean:.0} in the mean");
        // As pixels hopped, it was up to 1,200,000 where edges lay half-way between pixels.
        assert!(worst < 450_000.0 && worst < 1.2 * mean);
    }
}

/// A terrain aside and far below is a needle in the image that begins straight below the eye, thinner there than a
/// pixel: all of it is seen, wherever pixels lie in it.
#[test]
fn needles_of_ground_are_not_lost() {
    let ground = Ground::from_fn(301, 301, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let scene = Scene::new(ground);
    let views: Vec<_> = (0..60)
        .map(|k| {
            let turn = 0.105 * f64::from(k);
            let share = 0.618 * f64::from(k) % 1.0;
            let distance = 301.0 * (6.0 + 14.0 * share);
            let away = DVec2::from_angle(turn).extend(0.9);
            // The point straight below lies in the image, the ground on its other side.
            let attitude = Attitude {
                yaw: (-away.x).atan2(-away.y),
                pitch: -1.05,
                roll: 0.3 * f64::from(k),
            };
            Camera {
                eye: DVec3::new(150.0, 150.0, 0.0) + distance * away,
                attitude,
                horizontal_fov: 2.0,
            }
            .view([400, 300])
        })
        .collect();
    let [exact, detail] = ["planes", Planes::WITH_DETAIL].map(|caster| {
        let images = cast(caster, &scene, &views);
        let ground = |image: &Image| image.depth.iter().filter(|depth| depth.is_finite()).count();
        images.iter().map(ground).collect::<Vec<_>>()
    });
    for (k, (exact, detail)) in exact.into_iter().zip(detail).enumerate() {
        assert!(exact > 200, "{exact} in view {k}");
        let ratio = detail as f64 / exact as f64;
        assert!(
            (0.9..1.1).contains(&ratio),
            "{detail} of {exact} in view {k}"
        );
    }
}

/// From ten times as far as numbers tell cells apart, in pixels of the same ground: no farther from the truth
/// than from where they do, by far nearer than points are, and calm when the eye moves.
#[test]
fn from_afar_it_is_as_near_to_the_truth() {
    let scene = Scene::new(mountains().with_photo(photo()));
    let look = |cells: f64, aside: f64| {
        let height = 0.6_f64;
        let pitch = Attitude {
            pitch: -height,
            ..Attitude::default()
        };
        let away = DVec3::new(0.0, -height.cos(), height.sin());
        Camera {
            eye: DVec3::new(350.0 + aside, 300.0, 0.0) + cells * away,
            attitude: pitch,
            // Pixels of nine metres.
            horizontal_fov: 2.0 * (0.5 * 9.0 * 128.0 / cells).atan(),
        }
        .view([128, 96])
    };
    let [near, far] = [1e5, 1e6].map(|cells| compared(&scene, look(cells, 0.0)));
    println!("without and with detail: {near:.2?} dB near, {far:.2?} dB far");
    assert!(far[1] > near[1] - 0.2 && far[1] > far[0] + 6.0);
    let moved = [0.0, 4.5].map(|aside| look(1e6, aside));
    let [change, in_truth] = [
        cast("planes?lod=on", &scene, &moved)
            .iter()
            .map(|image| image.colour().to_vec())
            .collect::<Vec<_>>(),
        moved.iter().map(|view| truth(&scene, view)).collect(),
    ]
    .map(|images| {
        let pixels = images[0].iter().zip(&images[1]);
        pixels
            .map(|(a, b)| f64::from(a[1].abs_diff(b[1])))
            .sum::<f64>()
    });
    println!("half a pixel aside it changes by {change}, the truth by {in_truth}");
    assert!(change < 1.2 * in_truth);
}

/// Level ground of so many posts a side, a metre apart, under a photo of noise.
fn noisy_slab(posts: u32) -> Arc<Scene> {
    let ground = Ground::from_fn(posts, posts, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let level = |x: u32, y: u32| (64 + (hash(x, y) >> 25)) as u8;
    Scene::new(ground.with_photo(Photo {
        pixels: TiledRaster::from_fn(posts, posts, |x, y| {
            let level = level(x, y);
            [level, level, level, 255]
        }),
        origin: DVec2::ZERO,
        spacing: DVec2::ONE,
    }))
}

/// Walls of the ground that run away from the eye: what a pixel sees of one is many posts long.
#[test]
fn walls_are_nearer_to_the_truth() {
    // Beside each side, so that one of two walls lies aslant; and from so far away that a pixel covers a dozen
    // posts of it, and a hundred. Over the small ground pixels have rays of their own.
    for (posts, eye, yaw, horizontal_fov, size, gain) in [
        (401, [-10.0, -40.0], 0.2, 1.0, [160, 120], 7.0),
        (401, [440.0, -9.0], -1.4, 1.0, [160, 120], 7.0),
        (401, [411.0, 440.0], 3.3, 1.0, [160, 120], 7.0),
        (401, [-60.0, 412.0], 1.75, 1.0, [160, 120], 7.0),
        (401, [-500.0, -1500.0], 0.3, 0.15, [160, 120], 7.0),
        (401, [-500.0, -1500.0], 0.3, 0.3, [32, 24], 8.5),
        (61, [-2.0, -8.0], 0.2, 0.4, [160, 120], 0.1),
        (61, [68.0, -1.5], -1.4, 0.4, [160, 120], 0.1),
    ] {
        let scene = noisy_slab(posts);
        for roll in [0.0, 0.7] {
            let attitude = Attitude {
                yaw,
                pitch: -0.1,
                roll,
            };
            let camera = Camera {
                eye: DVec3::from((DVec2::from(eye), 0.05 * f64::from(posts - 1))),
                attitude,
                horizontal_fov,
            };
            let [points, detail] = compared(&scene, camera.view(size));
            println!("from {eye:?}, roll {roll}: {points:.2} dB, with detail {detail:.2}");
            assert!(detail > points + gain, "from {eye:?}, roll {roll}");
        }
    }
}
