//! The judge, before images that are known to be right or wrong.

use super::is_sky;
use glam::{DVec2, DVec3};
use sandtable_cast::{Brute, CastPool, Image, Scene, Sight, sight};
use sandtable_terrain::Ground;
use sandtable_tests::Random;
use sandtable_tests::exactness::{Fault, judge};
use sandtable_tests::random_views::case;
use sandtable_view::{Attitude, Camera, Ray, View};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use std::sync::Arc;

/// What brute force sees through a place in the image, in pixels.
fn sight_through(scene: &Scene, view: &View, at: DVec2) -> Sight {
    let ray = Ray {
        origin: view.eye,
        direction: view.direction(at.x, at.y),
    };
    sight(&scene.ground, &ray)
}

/// Whether a pixel's answer is beyond doubt: within a hundredth of a pixel, brute force sees one
/// colour at depths that differ by a small part of the tolerance.
fn is_steady(scene: &Scene, view: &View, [i, j]: [u32; 2]) -> bool {
    let centre = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
    let sights: Vec<_> = (0..16)
        .map(|k| centre + 0.01 * DVec2::from_angle(TAU * f64::from(k) / 16.0))
        .chain([centre])
        .map(|at| sight_through(scene, view, at))
        .collect();
    let [nearest, farthest] = sights
        .iter()
        .fold([f64::INFINITY, 0.0_f64], |[low, high], sight| {
            [low.min(sight.depth), high.max(sight.depth)]
        });
    let cell = scene.ground.grid().cell_length();
    let one_depth = nearest == farthest || farthest - nearest < 0.02 * cell;
    one_depth && sights.iter().all(|sight| sight.colour == sights[0].colour)
}

/// Some steady pixels of an image, all over it.
fn steady_pixels(scene: &Scene, image: &Image) -> Vec<[u32; 2]> {
    let [width, height] = image.view.size;
    let pixels: Vec<_> = (0..width * height)
        .step_by(37)
        .map(|index| [index % width, index / width])
        .filter(|&pixel| is_steady(scene, &image.view, pixel))
        .collect();
    assert!(pixels.len() > 500, "only {} are steady", pixels.len());
    pixels
}

fn index(image: &Image, [i, j]: [u32; 2]) -> usize {
    (j * image.width() + i) as usize
}

/// Made-up hills with a view into them that has ground and sky.
fn hills(extra: impl Fn(u32, u32) -> f64 + Sync) -> (Arc<Scene>, View) {
    let height = |col: u32, row: u32| {
        let (x, y) = (f64::from(col), f64::from(row));
        (40.0 * (x / 13.0).sin() * (y / 17.0).cos() + extra(col, row)) as f32
    };
    let ground = Ground::from_fn(200, 180, DVec2::new(10.0, 12.0), height).expect("a sound grid");
    let camera = Camera {
        eye: DVec3::new(950.0, 20.0, 130.0),
        attitude: Attitude {
            yaw: 0.2,
            pitch: -0.15,
            roll: 0.1,
        },
        horizontal_fov: 1.0,
    };
    (Scene::new(ground), camera.view([320, 240]))
}

fn exact_image(scene: &Arc<Scene>, view: View) -> Image {
    let pool = CastPool::new(0).expect("threads");
    pool.picture(&Brute, scene, view).expect("any view will do")
}

#[test]
fn hits_that_were_moved_by_a_fifth_of_a_cell_are_found() {
    let (scene, view) = hills(|_, _| 0.0);
    let exact = exact_image(&scene, view);
    let cell = scene.ground.grid().cell_length() as f32;
    let mut steady = steady_pixels(&scene, &exact);
    steady.retain(|&pixel| !is_sky(exact.depth[index(&exact, pixel)]));
    for (cells, wrong) in [(0.2, true), (-0.2, true), (0.09, false), (-0.09, false)] {
        let mut moved = exact.clone();
        for &pixel in &steady {
            moved.depth[index(&exact, pixel)] += cells * cell;
        }
        let verdict = judge(&scene, &view, &moved);
        let expected = if wrong { steady.len() } else { 0 };
        assert_eq!(verdict.wrong_in_depth, expected, "{cells}: {verdict}");
        assert_eq!(verdict.wrong_in_colour, 0, "{cells}: {verdict}");
        assert_eq!(verdict.searched, expected);
        if wrong {
            assert_eq!(verdict.first[0].pixel, steady[0]);
            assert_eq!(verdict.first[0].fault, Fault::Depth);
            let [found, exact] = verdict.first[0].cells;
            assert!((found - exact - f64::from(cells)).abs() < 1e-4, "{verdict}");
        }
    }
}

#[test]
fn a_fence_that_was_missed_is_found() {
    let (without, view) = hills(|_, _| 0.0);
    // One post wide, and from the eye a fraction of a pixel.
    let (with, _) = hills(|col, _| if col == 120 { 15.0 } else { 0.0 });
    let (missed, exact) = (exact_image(&without, view), exact_image(&with, view));
    let cell = with.ground.grid().cell_length() as f32;
    let differing = missed
        .depth
        .iter()
        .zip(&exact.depth)
        .filter(|(missed, exact)| missed != exact && (*missed - *exact).abs() > 0.1 * cell)
        .count();
    let verdict = judge(&with, &view, &missed);
    assert!(differing > 1000, "{differing}");
    // At the fence's edges, some rays pass it.
    assert!(verdict.wrong_in_depth <= differing, "{verdict}");
    assert!(
        verdict.wrong_in_depth as f64 > 0.97 * differing as f64,
        "{verdict} of {differing}"
    );
}

#[test]
fn sky_instead_of_ground_and_ground_instead_of_sky_are_found() {
    let (scene, view) = hills(|_, _| 0.0);
    let mut image = exact_image(&scene, view);
    let steady = steady_pixels(&scene, &image);
    let was_sky = |image: &Image| {
        let sky = |pixel: &&[u32; 2]| is_sky(image.depth[index(image, **pixel)]);
        steady.iter().filter(sky).count()
    };
    let skies = was_sky(&image);
    assert!(skies > 100 && steady.len() - skies > 100);
    for &pixel in &steady {
        let depth = &mut image.depth[(pixel[1] * 320 + pixel[0]) as usize];
        *depth = if is_sky(*depth) { 500.0 } else { f32::INFINITY };
    }
    assert_eq!(was_sky(&image), steady.len() - skies);
    let verdict = judge(&scene, &view, &image);
    assert_eq!(verdict.wrong_in_depth, steady.len(), "{verdict}");
    assert_eq!(verdict.wrong_in_colour, 0, "{verdict}");
}

#[test]
fn colours_that_are_off_by_five_are_found() {
    let (scene, view) = hills(|_, _| 0.0);
    let exact = exact_image(&scene, view);
    let steady = steady_pixels(&scene, &exact);
    for (off, wrong) in [(5, true), (3, true), (2, false)] {
        for channel in 0..3 {
            let mut image = exact.clone();
            for &pixel in &steady {
                let at = index(&exact, pixel);
                let level = &mut image.colour_mut()[at][channel];
                *level = if *level < 128 {
                    *level + off
                } else {
                    *level - off
                };
            }
            let verdict = judge(&scene, &view, &image);
            let expected = if wrong { steady.len() } else { 0 };
            assert_eq!(verdict.wrong_in_colour, expected, "{off}: {verdict}");
            assert_eq!(verdict.wrong_in_depth, 0, "{off}: {verdict}");
            assert!(
                verdict
                    .first
                    .iter()
                    .all(|pixel| pixel.fault == Fault::Colour)
            );
        }
    }
}

/// The colour of what is behind, at the depth of what is in front: each alone agrees with some ray
/// at an edge, but no ray has both.
#[test]
fn one_ray_answers_for_depth_and_colour() {
    let (scene, view) = hills(|_, _| 0.0);
    let exact = exact_image(&scene, view);
    let mut image = exact.clone();
    let mut mixed = 0;
    for at in 320..exact.depth.len() {
        let above = at - 320;
        if is_sky(exact.depth[above]) && !is_sky(exact.depth[at]) {
            image.colour_mut()[at] = exact.colour()[above];
            mixed += 1;
        }
    }
    let verdict = judge(&scene, &view, &image);
    assert!(mixed > 200, "{mixed}");
    assert_eq!(verdict.wrong_in_colour, mixed, "{verdict}");
}

/// What brute force sees through every pixel at most so many pixels off its centre, and where that
/// is told as the centre's ray, less than a tenth of a cell off its hit.
fn jittered(scene: &Scene, view: &View, off: f64, random: &mut Random) -> Image {
    let mut image = Image::default();
    image.reset(*view);
    let [width, height] = view.size;
    for index in 0..width * height {
        let angle = random.between(0.0, TAU);
        let mut off = off * random.unit().sqrt() * DVec2::from_angle(angle);
        let centre = DVec2::new(f64::from(index % width), f64::from(index / width)) + 0.5;
        let sight = loop {
            let sight = sight_through(scene, view, centre + off);
            let forward = |at: DVec2| view.direction(at.x, at.y).normalize();
            let turn = (forward(centre + off) - forward(centre)).length();
            let sideways = turn * sight.depth / scene.ground.grid().cell_length();
            if sight.depth.is_infinite() || sideways < 0.09 {
                break sight;
            }
            off *= 0.5;
        };
        image.depth[index as usize] = sight.depth as f32;
        image.colour_mut()[index as usize][..3].copy_from_slice(&sight.colour);
    }
    image
}

#[test]
fn any_ray_within_a_hundredth_of_a_pixel_will_do() {
    let mut random = Random::new(1);
    let mut searched = 0;
    for case in (0..15).map(case) {
        for off in [0.0099, 1e-3] {
            let image = jittered(&case.scene, &case.view, off, &mut random);
            let verdict = judge(&case.scene, &case.view, &image);
            assert_eq!(verdict.wrong(), 0, "{off} pixels off, {case}: {verdict}");
            searched += verdict.searched;
        }
    }
    // Many do differ from the centre's ray.
    assert!(searched > 300, "{searched}");
}

/// From a cell above a plane, depths of hundreds of cells lie within a disc near the horizon, many
/// more than rays in the rings.
#[test]
fn depths_that_range_over_the_pixels_are_searched_between_rays() {
    let ground = Ground::from_fn(2001, 400, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let camera = Camera {
        eye: DVec3::new(1.0, 200.0, 1.0),
        attitude: Attitude {
            yaw: FRAC_PI_2,
            ..Attitude::default()
        },
        horizontal_fov: 0.2,
    };
    let (scene, view) = (Scene::new(ground), camera.view([320, 240]));
    let image = jittered(&scene, &view, 0.0099, &mut Random::new(2));
    let verdict = judge(&scene, &view, &image);
    assert!(verdict.searched > 200, "{verdict}");
    assert_eq!(verdict.wrong(), 0, "{verdict}");
}

/// A wall of which a disc covers ten cells, and a slit in it, a cell and a half wide at most, that
/// lies beside the rays that are tried first.
#[test]
fn what_is_seen_through_a_slit_in_the_disc_passes() {
    let notch = |col: u32, _| if col == 20 { -16.0 } else { 0.0 };
    let ground = Ground::from_fn(41, 3, DVec2::ONE, notch).expect("a sound grid");
    let scene = Scene::new(ground);
    let camera = |eye| Camera {
        eye,
        attitude: Attitude::default(),
        horizontal_fov: 0.9,
    };
    let size = [320, 240];
    let (pixel, centre) = ([160, 120], DVec2::new(160.5, 120.5));
    let way = camera(DVec3::ZERO).view(size).direction(centre.x, centre.y);
    let across = camera(DVec3::ZERO).view(size).window.across().length() / 320.0;
    // The ray through the centre meets the wall 1.9 cells beside the slit.
    let eye = DVec3::new(18.1, 0.0, -8.0) - 500.0 / across * way;
    let view = camera(eye).view(size);
    let mut image = exact_image(&scene, view);
    assert!(!is_sky(image.depth[index(&image, pixel)]));
    let sky = sight_through(&scene, &view, centre + DVec2::new(1.9 / 500.0, 0.0));
    let at = index(&image, pixel);
    image.depth[at] = sky.depth as f32;
    image.colour_mut()[at][..3].copy_from_slice(&sky.colour);
    assert!(is_sky(image.depth[at]), "there is a slit");
    let verdict = judge(&scene, &view, &image);
    assert_eq!((verdict.searched, verdict.wrong()), (1, 0), "{verdict}");
}

#[test]
fn rays_a_tenth_of_a_pixel_off_are_found() {
    let (scene, view) = hills(|_, _| 0.0);
    let mut moved = view;
    let tenth = 0.1 / 240.0 * view.window.upwards();
    moved.window = view.window.map(|corner| corner + tenth);
    let mut image = exact_image(&scene, moved);
    image.view = view;
    let verdict = judge(&scene, &view, &image);
    // Where a ray meets the ground steeply and the ground is near, a tenth of a pixel is nothing.
    assert!(verdict.wrong() > 5_000, "{verdict}");
}

/// From so far that a hundredth of a pixel is a fifth of a cell, each way.
#[test]
fn a_far_hit_must_be_as_near_to_an_exact_one_as_a_near_hit() {
    let ground = Ground::from_fn(257, 257, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let camera = Camera {
        eye: DVec3::new(128.0, -4872.0, 5000.0),
        attitude: Attitude {
            pitch: -FRAC_PI_4,
            ..Attitude::default()
        },
        horizontal_fov: 0.9,
    };
    let (scene, view) = (Scene::new(ground), camera.view([320, 240]));
    let mut moved = view;
    let off = 0.0099 / 240.0 * view.window.upwards();
    moved.window = view.window.map(|corner| corner + off);
    let mut image = exact_image(&scene, moved);
    image.view = view;
    let seen = image.depth.iter().filter(|depth| !is_sky(**depth)).count();
    let verdict = judge(&scene, &view, &image);
    assert!(
        seen > 80 && verdict.wrong_in_depth > seen * 3 / 4,
        "{verdict}"
    );
}
