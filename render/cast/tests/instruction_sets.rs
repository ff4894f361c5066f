//! The default caster on each instruction set that the processor has.

mod gorges;
mod hills;
mod town;

use self::gorges::{from_afar, gorges};
use self::hills::{camera, ground, hills};
use self::town::{OVER_ROOFS, town};
use glam::{DVec2, DVec3};
use sandtable_cast::{
    CastPool, Caster, Image, PreparedScene, Scene, Scheme, caster_by_name, standpoints,
};
use sandtable_terrain::{Ground, Photo, TiledRaster};
use sandtable_view::View;
use std::sync::Arc;

/// The caster with `options` on each instruction set of this processor, the reference first.
fn casters(options: &str) -> Vec<(&'static str, Arc<dyn Caster>)> {
    ["portable", "avx512", "avx2", "neon"]
        .into_iter()
        .filter_map(|name| {
            let caster = caster_by_name(&format!("planes?isa={name}{options}"));
            caster.ok().map(|caster| (name, caster))
        })
        .collect()
}

/// A photo of a part of the ground, with holes.
fn photo() -> Photo {
    let pixel = |x: u32, y: u32| {
        let hash = (x * 7919 + y * 104_729).wrapping_mul(2_654_435_761);
        let [r, g, b, a] = hash.to_be_bytes();
        [r, g, b, if a < 9 { 0 } else { 255 }]
    };
    Photo {
        pixels: TiledRaster::from_fn(310, 400, pixel),
        origin: DVec2::new(400.0, 150.0),
        spacing: DVec2::new(6.5, 5.0),
    }
}

/// Level, slanted, rolled and steep views, from over the ground, from beside it and from high up,
/// one at the table and one from close by. Sizes are no multiples of sixteen.
fn views(scene: &Scene) -> Vec<View> {
    let extent = scene.ground.grid().extent();
    let eye = DVec3::new(0.4 * extent.x, 0.1 * extent.y, 120.0);
    let beside = DVec3::new(-500.0, -300.0, 200.0);
    let mut views = vec![
        camera(eye, 1.3, -0.5, 0.0).view([160, 181]),
        camera(eye, -0.8, -0.4, 0.6).view([177, 150]),
        camera(eye.with_z(600.0), 0.2, -1.55, 0.0).view([177, 150]),
        camera(beside, 0.9, -0.1, 0.0).view([333, 150]),
        standpoints::at_table(&scene.ground, DVec3::new(0.1, -0.7, 0.6), [277, 150]),
        // Pixels much smaller than cells.
        camera(eye.with_z(90.0), 0.7, -1.2, 0.3).view([333, 250]),
    ];
    for quarter in 0..4 {
        let yaw = 0.3 + std::f64::consts::FRAC_PI_2 * f64::from(quarter);
        let eye = DVec3::new(0.5 * extent.x, 0.5 * extent.y, 70.0);
        views.push(camera(eye, yaw, 0.0, 0.0).view([177, 150]));
    }
    views
}

fn cast(prepared: &dyn PreparedScene, views: &[View]) -> Vec<Image> {
    let mut images = vec![Image::default(); views.len()];
    let pool = CastPool::new(2)
        .expect("threads")
        .with_scheme(Scheme::default());
    pool.cast(prepared, views, &mut images).expect("accepted");
    images
}

fn assert_same_images(ground: Ground, options: &str) {
    let scene = Scene::new(ground);
    assert_same_views(&scene, &views(&scene), options);
}

fn assert_same_views(scene: &Arc<Scene>, views: &[View], options: &str) {
    let mut reference: Option<Vec<Image>> = None;
    for (name, caster) in casters(options) {
        let prepared = caster.prepare(Arc::clone(scene)).expect("suits");
        let images = cast(&*prepared, views);
        let reference = reference.get_or_insert_with(|| images.clone());
        for (k, (image, expected)) in images.iter().zip(&*reference).enumerate() {
            let is_ground = |depth: &&f32| depth.is_finite();
            let ground = image.depth.iter().filter(is_ground).count();
            assert!(ground > 1000, "view {k} sees next to nothing: {ground}");
            let differing = image
                .depth
                .iter()
                .zip(&expected.depth)
                .filter(|(a, b)| a.to_bits() != b.to_bits())
                .count();
            assert_eq!(differing, 0, "depths of view {k} on {name}");
            assert!(image.colour() == expected.colour(), "view {k} on {name}");
        }
    }
}

#[test]
fn the_reference_is_everywhere_and_some_set_is_the_best() {
    let names: Vec<_> = casters("").into_iter().map(|(name, _)| name).collect();
    assert_eq!(names[0], "portable");
    assert!(caster_by_name("planes?isa=best").is_ok());
    assert!(caster_by_name("planes?isa=mmx").is_err());
    #[cfg(target_arch = "x86_64")]
    {
        assert_eq!(is_x86_feature_detected!("avx2"), names.contains(&"avx2"));
        assert!(!names.contains(&"neon"));
    }
    #[cfg(target_arch = "aarch64")]
    assert_eq!(names, ["portable", "neon"]);
}

#[test]
fn ground_has_the_same_bytes_on_all() {
    assert_same_images(ground(300, 290, hills), "");
}

#[test]
fn ground_with_a_photo_has_the_same_bytes_on_all() {
    assert_same_images(ground(300, 290, hills).with_photo(photo()), "");
}

/// Where rays begin from those around them.
#[test]
fn a_town_has_the_same_bytes_on_all() {
    let scene = Scene::new(town());
    let beside = DVec3::new(-40.0, -60.0, 60.0);
    let views = [
        camera(OVER_ROOFS, 0.3, -0.15, 0.0).view([640, 400]),
        camera(OVER_ROOFS, 0.3, -0.3, 0.4).view([640, 400]),
        camera(OVER_ROOFS, -2.5, -0.2, 2.2).view([640, 400]),
        camera(beside, 0.7, -0.2, 0.1).view([640, 400]),
        standpoints::at_table(&scene.ground, DVec3::new(0.1, -0.7, 0.6), [640, 400]),
    ];
    assert_same_views(&scene, &views, "");
}

/// The same, and so far apart that several lines of posts lie between.
#[test]
fn gorges_far_away_have_the_same_bytes_on_all() {
    assert_same_views(&Scene::new(gorges()), &[from_afar()], "");
}

#[test]
fn detail_has_the_same_bytes_on_all() {
    // Coarse enough for several levels in a small image.
    assert_same_images(ground(300, 290, hills), "&lod=on&cell=8&blur=3");
    assert_same_images(
        ground(300, 290, hills).with_photo(photo()),
        "&lod=on&cell=8&blur=3",
    );
}

/// Places that are so many pixels away that numbers have no room for them.
#[test]
fn ground_far_from_its_photo_has_the_same_bytes_on_all() {
    let small = Photo {
        pixels: TiledRaster::from_fn(310, 400, |x, y| [x as u8, y as u8, 90, 255]),
        origin: DVec2::new(400.0, 150.0),
        spacing: DVec2::new(0.006, 0.005),
    };
    assert_same_images(ground(300, 290, hills).with_photo(small), "&lod=on");
    let scene = Scene::new(ground(300, 290, hills));
    let away = 700_000.0 * DVec3::new(-0.6, -0.6, 0.5);
    let mut camera = camera(DVec3::new(1500.0, 1200.0, 0.0) + away, 0.0, 0.0, 0.0);
    camera.attitude.yaw = (-away.x).atan2(-away.y);
    camera.attitude.pitch = -(away.z / away.truncate().length()).atan();
    camera.horizontal_fov = 0.003;
    assert_same_views(&scene, &[camera.view([177, 150])], "&lod=on");
}

/// What a thread keeps from one sector to the next is not of the next one's ground, nor are the
/// patches of it that rays hand on.
#[test]
fn what_was_cast_before_changes_nothing() {
    let rough = |col: u32, row: u32| {
        let hills = 20.0 * ((f64::from(col) * 0.03).sin() + (f64::from(row) * 0.041).cos());
        let hash = (col * 7919 + row * 104_729).wrapping_mul(2_654_435_761) >> 24;
        (hills + f64::from(hash) / 200.0) as f32
    };
    let scene = Scene::new(Ground::from_fn(300, 300, DVec2::ONE, rough).expect("a sound grid"));
    let views: Vec<_> = (0..60)
        .map(|k: u32| {
            let share = |by: f64| (f64::from(k) * by).fract();
            let eye = DVec3::new(300.0 * share(0.618), 300.0 * share(0.414), 45.0);
            let above = 4.0 + 60.0 * share(0.732);
            let [yaw, pitch, roll] = [6.3 * share(0.236), -1.5 * share(0.551), 6.3 * share(0.853)];
            // Once a bit higher: there all the same cells are seen, but from another eye.
            [1.5, 0.0].map(|more| {
                let eye = eye + (above + more) * DVec3::Z;
                camera(eye, yaw, pitch, roll).view([320, 240])
            })
        })
        .collect();
    let caster = caster_by_name("planes").expect("there is one");
    let prepared = caster.prepare(scene).expect("suits");
    let pool = CastPool::new(1).expect("a thread");
    let mut image = [Image::default()];
    for (k, [higher, view]) in views.iter().enumerate() {
        for view in [higher, view] {
            pool.cast(&*prepared, &[*view], &mut image)
                .expect("accepted");
        }
        let mut alone = [Image::default()];
        let fresh = CastPool::new(1).expect("a thread");
        fresh
            .cast(&*prepared, &[*view], &mut alone)
            .expect("accepted");
        let bits = |image: &Image| -> Vec<u32> {
            image.depth.iter().map(|depth| depth.to_bits()).collect()
        };
        assert!(bits(&image[0]) == bits(&alone[0]), "depths of view {k}");
        assert!(
            image[0].colour() == alone[0].colour(),
            "colours of view {k}"
        );
    }
}
