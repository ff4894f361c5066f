//! From picture to picture no more changes than in truth.

use crate::ground::{hash, mountains, photo};
use crate::truth::truth;
use crate::views::{camera, cast};
use glam::{DVec2, DVec3};
use sandtable_cast::{Planes, Scene, standpoints};
use sandtable_terrain::{Ground, Photo, TiledRaster};
use sandtable_view::View;

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
