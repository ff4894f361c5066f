//! What is seen is the ground that there is, all of it.

use crate::ground::{hash, level, mountains, photo};
use crate::views::{camera, cast};
use glam::{DVec2, DVec3};
use sandtable_cast::{Image, Planes, Scene};
use sandtable_terrain::{Ground, Photo, TiledRaster};
use sandtable_view::{Attitude, Camera, Screen, View};

#[test]
fn a_plane_is_a_plane_at_all_levels_and_ends_where_it_ends() {
    // 701 by 514 posts: a coarse level's last cells reach out over the border.
    let height = |col: u32, row: u32| 0.125 * col as f32 - 0.25 * row as f32;
    let ground = Ground::from_fn(701, 514, DVec2::new(2.0, 3.0), height).expect("a sound grid");
    let normal = DVec3::new(-0.125 / 2.0, 0.25 / 3.0, 1.0).normalize();
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
            // A pixel that is some five times as long as wide is taken for two pieces of ground, of which the
            // nearer counts.
            let along = view.ray(i, j).direction.normalize().dot(normal).abs();
            let least = if along < 0.25 {
                0.5 * pixel / along
            } else {
                2e-3 * f64::from(a)
            };
            let same = a == b || f64::from((a - b).abs()) < least;
            let point = exact.point(i, j);
            assert!(
                same || on_border,
                "{a} m and {b} m at {i}, {j}: {point:?} of {extent}"
            );
        }
    }
}

/// The cells of all levels but the first reach out over the border, and rays come to the coarsest one before it.
#[test]
fn rays_end_at_the_border_at_the_coarsest_level_too() {
    // 49 by 41 cells: the third level's, of four, reach out by three.
    let ground = Ground::from_fn(50, 42, DVec2::splat(2.0), |_, _| 7.0).expect("a sound grid");
    // Too few pixels for closer posts, but close enough for rays.
    let few = Photo {
        pixels: TiledRaster::from_fn(8, 8, |_, _| [9, 9, 9, 255]),
        origin: DVec2::new(9.3, 9.3),
        spacing: DVec2::splat(0.7),
    };
    let scene = Scene::new(ground.with_photo(few));
    let extent = scene.ground.grid().extent();
    let views: Vec<_> = (0..32)
        .map(|k| {
            let turn = 0.2 * f64::from(k);
            let away = DVec3::new(turn.cos(), turn.sin(), 0.3);
            Camera {
                eye: (0.5 * extent).extend(7.0) + (60.0 + 2.0 * f64::from(k)) * away,
                attitude: Attitude {
                    yaw: (-away.x).atan2(-away.y),
                    pitch: -0.3,
                    roll: 0.1,
                },
                horizontal_fov: 0.9,
            }
            .view([120, 90])
        })
        .collect();
    let mut beyond = Vec::new();
    let images = cast("planes?lod=on&cell=8", &scene, &views);
    for (k, image) in images.iter().enumerate() {
        for (i, j) in (0..90).flat_map(|j| (0..120).map(move |i| (i, j))) {
            if let Some(point) = image.point(i, j) {
                let inside = point.truncate().min(extent - point.truncate());
                if inside.min_element() < -0.1 {
                    beyond.push((k, [i, j], point));
                }
            }
        }
    }
    let some = &beyond[..beyond.len().min(9)];
    assert!(beyond.is_empty(), "{} pixels: {some:.1?}", beyond.len());
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

/// A terrain aside and far below is a needle in the image that begins straight below the eye, thinner there than a
/// pixel: all of it is seen, wherever pixels lie in it.
#[test]
fn needles_of_ground_are_not_lost() {
    let scene = Scene::new(level(301));
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
