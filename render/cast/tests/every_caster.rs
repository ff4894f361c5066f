//! What every caster promises, whatever its algorithm.

mod hills;

use self::hills::{camera, ground, hills};
use glam::{DVec2, DVec3};
use sandtable_cast::{
    CASTERS, CastPool, Image, Planes, PreparedScene, Scene, Scheme, caster_by_name, standpoints,
};
use sandtable_terrain::{Photo, TiledRaster};
use sandtable_view::View;
use std::sync::Arc;

fn scene(cols: u32, rows: u32, height: impl Fn(f64, f64) -> f64 + Sync) -> Arc<Scene> {
    Scene::new(ground(cols, rows, height))
}

/// Views of every kind: each caster is made for one of them at least.
fn views(scene: &Scene) -> Vec<View> {
    let extent = scene.ground.grid().extent();
    let eye = DVec3::new(0.4 * extent.x, 0.1 * extent.y, 120.0);
    let size = [77, 50];
    vec![
        camera(eye, 0.3, 0.0, 0.0).view(size),
        camera(eye, 1.3, -0.5, 0.0).view([60, 81]),
        camera(eye, -0.8, -0.4, 0.6).view(size),
        camera(eye.with_z(300.0), 0.2, -1.55, 0.0).view(size),
        standpoints::at_table(&scene.ground, DVec3::new(0.1, -0.7, 0.6), size),
    ]
}

/// All casters with their defaults, and the default one with level of detail.
fn casters() -> impl Iterator<Item = &'static str> {
    let names = CASTERS.iter().map(|kind| kind.name);
    names.chain([Planes::WITH_DETAIL])
}

fn prepared(name: &str, scene: &Arc<Scene>) -> Arc<dyn PreparedScene> {
    let caster = caster_by_name(name).expect("there is one");
    caster.prepare(Arc::clone(scene)).expect("defaults suit")
}

/// Those of `views` that the caster is made for.
fn accepted(name: &str, prepared: &dyn PreparedScene, views: &[View]) -> Vec<View> {
    let is_accepted = |view: &&View| prepared.work(view).is_ok();
    let views: Vec<_> = views.iter().filter(is_accepted).copied().collect();
    assert!(!views.is_empty(), "{name} casts nothing at all");
    views
}

fn cast(
    prepared: &dyn PreparedScene,
    views: &[View],
    threads: usize,
    scheme: Scheme,
) -> Vec<Image> {
    let mut images = vec![Image::default(); views.len()];
    let pool = CastPool::new(threads).expect("threads").with_scheme(scheme);
    pool.cast(prepared, views, &mut images).expect("accepted");
    images
}

#[test]
fn threads_and_schemes_do_not_change_a_byte() {
    let scene = scene(140, 120, hills);
    for caster in casters() {
        let prepared = prepared(caster, &scene);
        let views = accepted(caster, &*prepared, &views(&scene));
        let one = cast(&*prepared, &views, 1, Scheme::default());
        let hits = |image: &Image| image.depth.iter().any(|depth| depth.is_finite());
        assert!(one.iter().any(hits), "{} sees nothing", caster);
        for threads in [1, 2, 7] {
            for scheme in Scheme::ALL {
                let other = cast(&*prepared, &views, threads, scheme);
                assert!(one == other, "{}: {scheme} on {threads}", caster);
            }
        }
    }
}

#[test]
fn eyes_of_a_pair_are_cast_as_each_alone() {
    let scene = scene(140, 120, hills);
    let eye = |x| standpoints::at_table(&scene.ground, DVec3::new(x, -0.7, 0.6), [177, 110]);
    let camera_eye = |x| camera(DVec3::new(500.0 + x, 90.0, 120.0), 0.3, 0.0, 0.0).view([90, 61]);
    for caster in casters() {
        let prepared = prepared(caster, &scene);
        let mut pairs = 0;
        for pair in [
            [eye(-0.032), eye(0.032)],
            [camera_eye(-30.0), camera_eye(30.0)],
        ] {
            if pair.iter().any(|view| prepared.work(view).is_err()) {
                continue;
            }
            pairs += 1;
            let alone = pair.map(|view| cast(&*prepared, &[view], 1, Scheme::default()).remove(0));
            assert!(alone[0] != alone[1], "{}: both eyes are one", caster);
            for threads in [1, 2, 3] {
                for scheme in Scheme::ALL {
                    let together = cast(&*prepared, &pair, threads, scheme);
                    assert!(together == alone, "{}: {scheme} on {threads}", caster);
                }
            }
        }
        assert!(pairs > 0, "{} casts no pair", caster);
    }
}

#[test]
fn pixels_are_cast_whatever_the_images_held_before() {
    let scene = scene(60, 60, hills);
    for caster in casters() {
        let prepared = prepared(caster, &scene);
        for view in accepted(caster, &*prepared, &views(&scene)) {
            let clean = cast(&*prepared, &[view], 2, Scheme::default());
            let mut dirty = clean.clone();
            dirty[0].colour_mut().fill([1, 2, 3, 4]);
            dirty[0].depth.fill(-5.0);
            let pool = CastPool::new(2).expect("threads");
            pool.cast(&*prepared, &[view], &mut dirty)
                .expect("accepted");
            assert!(clean == dirty, "{} leaves pixels out", caster);
        }
    }
}

#[test]
fn work_is_counted() {
    let scene = scene(60, 60, hills);
    for caster in casters() {
        let prepared = prepared(caster, &scene);
        for view in accepted(caster, &*prepared, &views(&scene)) {
            let work = prepared.work(&view).expect("accepted");
            let pixels = u64::from(view.size[0]) * u64::from(view.size[1]);
            assert!(work.rays >= pixels, "{}: {work:?}", caster);
            assert!(work.samples + work.cells > 0, "{}: {work:?}", caster);
        }
    }
}

#[test]
fn an_empty_image_is_cast_without_ado() {
    let scene = scene(5, 4, |_, _| 0.0);
    for caster in casters() {
        let prepared = prepared(caster, &scene);
        for size in [[0, 0], [0, 4], [4, 0]] {
            let mut view = views(&scene)[0];
            view.size = size;
            let images = cast(&*prepared, &[view], 2, Scheme::default());
            assert!(images[0].colour().is_empty() && images[0].depth.is_empty());
        }
    }
}

#[test]
fn a_scene_updated_after_an_edit_equals_one_prepared_anew() {
    let tinted = scene(300, 290, hills);
    // A photo that is finer than posts.
    let photo = Photo {
        pixels: TiledRaster::from_fn(700, 600, |col, row| [col as u8, row as u8, 90, 255]),
        origin: DVec2::ZERO,
        spacing: 0.5 * tinted.ground.grid().spacing,
    };
    let under_photo = Scene::new((*tinted.ground).clone().with_photo(photo));
    for before in [tinted, under_photo] {
        // Within the range of heights, so that all other ground keeps its tints.
        let [_, high] = before.ground.range();
        let raised = |_, _, height| height + 0.7 * (high - height);
        let edit = before.ground.edited(230..262, 100..140, raised);
        let (ground, changed) = edit.expect("finite");
        let after = Scene::new(ground);
        for caster in casters() {
            let old = prepared(caster, &before);
            let updated = old.updated(Arc::clone(&after), &changed).expect("suits");
            let fresh = prepared(caster, &after);
            let eye = DVec3::new(2300.0, 300.0, 130.0);
            let look = [
                camera(eye, 0.0, 0.0, 0.0).view([90, 60]),
                camera(eye, 0.0, -0.3, 0.0).view([90, 60]),
            ];
            let views = accepted(caster, &*old, &look);
            let [old, updated, fresh] =
                [old, updated, fresh].map(|scene| cast(&*scene, &views, 2, Scheme::default()));
            assert!(old != updated, "{} does not see the edit", caster);
            assert!(updated == fresh, "{} sees half of the edit", caster);
        }
    }
}

#[test]
fn degenerate_ground_is_cast() {
    let slope = |x, y| 0.3 * x - 0.2 * y;
    let tiny = ground(2, 2, slope);
    let extent = tiny.grid().extent();
    let finer = |pixels: u32| Photo {
        pixels: TiledRaster::from_fn(pixels, pixels, |col, row| [col as u8, row as u8, 7, 255]),
        origin: 0.5 * extent / f64::from(pixels),
        spacing: extent / f64::from(pixels),
    };
    let grounds = [
        ("two by two posts", scene(2, 2, slope)),
        (
            "two by two posts under as many pixels",
            Scene::new(tiny.clone().with_photo(finer(2))),
        ),
        (
            "two by two posts under many pixels",
            Scene::new(tiny.clone().with_photo(finer(7))),
        ),
        ("a plane", scene(40, 30, |_, _| 25.0)),
        (
            "a spike",
            scene(
                40,
                30,
                |x, y| if x == 200.0 && y == 120.0 { 1e6 } else { 0.0 },
            ),
        ),
    ];
    for (name, scene) in &grounds {
        for caster in casters() {
            let prepared = prepared(caster, scene);
            let mut views = views(scene);
            // An eye on the surface, and one inside the terrain.
            let height = scene.ground.height_at(9.0, 7.0).expect("on the terrain");
            for depth in [0.0, 5.0] {
                let eye = DVec3::new(9.0, 7.0, height - depth);
                views.push(camera(eye, 0.3, 0.0, 0.0).view([20, 16]));
                views.push(camera(eye, 0.3, -0.5, 0.0).view([20, 16]));
            }
            for view in accepted(caster, &*prepared, &views) {
                let images = cast(&*prepared, &[view], 2, Scheme::default());
                let sound = |depth: &f32| *depth >= 0.0;
                assert!(
                    images[0].depth.iter().all(sound),
                    "{}: {name} from {}",
                    caster,
                    view.eye
                );
            }
        }
    }
}
