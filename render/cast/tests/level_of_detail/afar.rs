//! From farther away than numbers tell cells apart.

use crate::ground::{level, level_under, mountains, photo};
use crate::truth::{compared, truth};
use crate::views::cast;
use glam::{DVec2, DVec3};
use sandtable_cast::{Planes, Scene};
use sandtable_terrain::{Photo, TiledRaster};
use sandtable_view::{Attitude, Camera, View};

/// From ten times as far as numbers tell cells apart, in pixels of the same ground: no farther from the truth
/// than from where they do, by far nearer than points are, and calm when the eye moves.
#[test]
fn from_afar_it_is_as_near_to_the_truth() {
    let scene = Scene::new(mountains().with_photo(photo()));
    let look = |cells: f64, aside: f64| {
        let height = 0.6_f64;
        let attitude = Attitude {
            pitch: -height,
            ..Attitude::default()
        };
        let away = DVec3::new(0.0, -height.cos(), height.sin());
        Camera {
            eye: DVec3::new(350.0 + aside, 300.0, 0.0) + cells * away,
            attitude,
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
        cast(Planes::WITH_DETAIL, &scene, &moved)
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

/// From `eye` towards `to`.
fn towards(eye: DVec3, to: DVec3, horizontal_fov: f64) -> View {
    let away = to - eye;
    Camera {
        eye,
        attitude: Attitude {
            yaw: away.x.atan2(away.y),
            pitch: away.z.atan2(away.truncate().length()),
            roll: 0.2,
        },
        horizontal_fov,
    }
    .view([160, 120])
}

/// A photo of so small pixels that the eye, or ground, is hundreds of thousands of them away: it is seen where it
/// lies, and all other ground is as it is without it.
#[test]
fn a_photo_is_seen_where_it_lies_however_many_pixels_away() {
    const COLOUR: [u8; 4] = [200, 10, 7, 255];
    let photo = Photo {
        pixels: TiledRaster::from_fn(1500, 1200, |_, _| COLOUR),
        origin: DVec2::new(120.0, 110.0),
        spacing: DVec2::splat(0.006),
    };
    let end = photo.origin + DVec2::new(1499.0, 1199.0) * photo.spacing;
    let [plain, scene] = [level(700), level(700).with_photo(photo)].map(Scene::new);
    let on_photo = DVec3::new(124.5, 113.6, 0.0);
    let views = [
        // Along both axes both ways.
        towards(DVec3::new(600.0, 560.0, 400.0), on_photo, 0.1),
        towards(DVec3::new(-600.0, 560.0, 400.0), on_photo, 0.1),
        towards(DVec3::new(-9e3, -9e3, 9e3), on_photo, 0.008),
        // Away from the photo, along each way.
        towards(
            DVec3::new(124.0, 113.0, 200.0),
            DVec3::new(640.0, 600.0, 0.0),
            0.15,
        ),
        towards(
            DVec3::new(124.0, 640.0, 200.0),
            DVec3::new(640.0, 620.0, 0.0),
            0.15,
        ),
    ];
    let without = cast(Planes::WITH_DETAIL, &plain, &views);
    let with = cast(Planes::WITH_DETAIL, &scene, &views);
    let extent = scene.ground.grid().extent();
    let mut seen = [0; 2];
    for (k, (without, with)) in without.iter().zip(&with).enumerate() {
        for at in 0..160 * 120 {
            let Some(point) = with.point(at % 160, at / 160) else {
                continue;
            };
            let inside = (point.truncate() - DVec2::new(120.0, 110.0))
                .min(end - point.truncate())
                .min_element();
            // Where it ends, pixels have their part of the sky.
            let on_ground = (point.truncate().min(extent - point.truncate())).min_element();
            let colour = with.colour()[at as usize];
            // Pixels are up to 2 m long.
            if inside > 2.0 {
                assert_eq!(colour, COLOUR, "view {k}, {point}");
                seen[0] += 1;
            } else if inside < -3.0 && on_ground > 20.0 {
                assert_eq!(colour, without.colour()[at as usize], "view {k}, {point}");
                seen[1] += 1;
            }
        }
    }
    println!("{seen:?} pixels");
    assert!(seen[0] > 50 && seen[1] > 60_000, "{seen:?}");
}

/// The same of a photo over all ground, as many of its posts away.
#[test]
fn halves_of_a_photo_are_told_apart_from_as_many_posts_away() {
    let [west, east] = [[200, 10, 7, 255], [7, 10, 200, 255]];
    let scene = level_under(301, |x, _| if x < 150 { west } else { east });
    let middle = DVec3::new(150.0, 150.0, 0.0);
    let views: Vec<_> = [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]
        .into_iter()
        .map(|[x, y]| {
            let away = DVec3::new(75_000.0 * x, 70_000.0 * y, 60_000.0);
            towards(middle + away, middle, 0.000_7)
        })
        .collect();
    let mut seen = [0; 2];
    for (k, image) in cast(Planes::WITH_DETAIL, &scene, &views).iter().enumerate() {
        for at in 0..160 * 120 {
            let Some(point) = image.point(at % 160, at / 160) else {
                continue;
            };
            let aside = point.x - 150.0;
            if aside.abs() > 4.0 {
                let colour = if aside < 0.0 { west } else { east };
                assert_eq!(image.colour()[at as usize], colour, "view {k}, {point}");
                seen[usize::from(aside < 0.0)] += 1;
            }
        }
    }
    println!("{seen:?} pixels");
    assert!(seen[0] > 5_000 && seen[1] > 5_000, "{seen:?}");
}
