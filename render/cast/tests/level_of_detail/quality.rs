//! Images are nearer to the truth than points where pixels cover much, and nowhere farther.

use crate::ground::{mountains, oblong, photo, photo_of, town};
use crate::truth::compared;
use crate::views::{camera, cast};
use glam::{DVec2, DVec3};
use sandtable_cast::{Planes, Scene, standpoints};
use sandtable_terrain::Photo;
use sandtable_view::View;
use std::sync::Arc;

/// A place so many metres over the ground.
fn over(scene: &Scene, x: f64, y: f64, height: f64) -> DVec3 {
    let ground = scene.ground.height_at(x, y).expect("on the ground");
    DVec3::new(x, y, ground + height)
}

/// Looks at views of a scene, each of which must be nearer to the truth than points by more than so many decibels.
fn judge(name: &str, scene: &Arc<Scene>, views: impl IntoIterator<Item = (View, f64)>) {
    for (k, (view, gain)) in views.into_iter().enumerate() {
        let [points, detail] = compared(scene, view);
        println!("{name}, view {k}: {points:.2} dB, with detail {detail:.2}");
        assert!(detail > points + gain, "{name}, view {k}");
    }
}

/// A photo whose pixels lie so many metres apart, none of them on a post: where they are larger than the
/// image's, rays look at them one by one.
fn between_posts(spacing: f64) -> Photo {
    Photo {
        spacing: DVec2::splat(spacing),
        origin: DVec2::splat(0.3 * spacing),
        ..photo()
    }
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
        judge(name, &scene, views.map(|view| (view, 1.0)));
    }
}

/// A photo that has more pixels than the ground has posts, on posts as many times as close and between them,
/// seen as near to the truth as one of a pixel a post, and never farther than by points.
#[test]
fn finer_photos_are_seen_with_all_that_is_in_them() {
    for (name, spacing, origin) in [
        ("2 a post", 0.5, 0.0),
        ("2 a post, between them", 0.5, 0.22),
        ("3.2 a post", 0.3125, 0.1),
        ("1 a post, between them", 1.0, -0.5),
    ] {
        let photo = Photo {
            spacing: DVec2::splat(spacing),
            origin: DVec2::splat(origin),
            ..photo_of([(720.0 / spacing) as u32, (620.0 / spacing) as u32])
        };
        let scene = Scene::new(mountains().with_photo(photo));
        let eye = DVec3::new(60.0, 20.0, 150.0);
        let table = standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.7, 0.6), [800, 480]);
        let views = [
            (camera(eye, -0.4, [400, 300]), 2.0),
            (camera(eye, -0.9, [200, 150]), 2.0),
            (
                camera(DVec3::new(300.0, 250.0, 110.0), -1.5, [400, 300]),
                0.0,
            ),
            (table, 1.0),
        ];
        judge(name, &scene, views);
    }
}

/// Walls between two posts are seen pixels high; a level that suits the width of pixels has slopes in their place.
#[test]
fn towns_are_nearer_to_the_truth() {
    for times in [1, 2] {
        let scene = Scene::new(town(times));
        let views = [
            camera(DVec3::new(330.0, -180.0, 200.0), -0.5, [320, 240]),
            camera(DVec3::new(200.0, 200.0, 400.0), -1.5, [320, 240]),
            camera(DVec3::new(150.0, 40.0, 60.0), -0.3, [320, 240]),
            standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.7, 0.6), [400, 240]),
        ];
        let name = format!("{times} pixels a post");
        judge(&name, &scene, views.map(|view| (view, 1.0)));
    }
}

/// Levels have half as many posts along both axes: what they are too coarse for is along the longer one.
#[test]
fn oblong_cells_are_no_farther_from_the_truth() {
    for spacing in [[1.0, 6.0], [6.0, 1.0], [1.0, 20.0], [20.0, 1.0]] {
        let scene = Scene::new(oblong(DVec2::from_array(spacing)));
        let views = [
            camera(DVec3::new(350.0, 350.0, 500.0), -1.57, [320, 240]),
            camera(DVec3::new(100.0, 60.0, 130.0), -0.5, [320, 240]),
            standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.7, 0.6), [320, 200]),
        ];
        judge(
            &format!("{spacing:?}"),
            &scene,
            views.map(|view| (view, 0.0)),
        );
    }
}

#[test]
fn pixels_that_cover_little_are_no_worse() {
    let scene = Scene::new(mountains().with_photo(between_posts(0.5)));
    let views = [
        camera(over(&scene, 200.0, 200.0, 12.0), -1.4, [200, 150]),
        camera(over(&scene, 320.0, 210.0, 3.0), -0.6, [400, 300]),
    ];
    // Weights of colours are rounded otherwise: that is all that may differ.
    judge("magnified", &scene, views.map(|view| (view, -0.02)));
}

/// Where all pixels are narrower than posts, rays go as they do without detail.
#[test]
fn narrow_pixels_see_the_ground_exactly() {
    let scene = Scene::new(mountains().with_photo(between_posts(1.0)));
    let close = standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.7, 0.6), [3200, 2000]);
    for (view, all_magnified) in [
        (
            camera(over(&scene, 320.0, 210.0, 30.0), -1.4, [320, 240]),
            true,
        ),
        (
            camera(over(&scene, 200.0, 300.0, 9.0), -0.9, [400, 300]),
            true,
        ),
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
