//! The floor under every caster: an image's colours and depths again, from its hits.

mod hills;

use self::hills::{camera, ground, hills};
use glam::{DVec2, DVec3};
use sandtable_cast::{CastPool, Image, Scene, ShadeFloor, caster_by_name, standpoints};
use sandtable_terrain::{Photo, TiledRaster};
use sandtable_view::View;
use std::sync::Arc;

fn cast(scene: &Arc<Scene>, view: View) -> Image {
    let caster = caster_by_name("planes").expect("it is there");
    let pool = CastPool::new(2).expect("threads");
    pool.picture(&*caster, scene, view).expect("any view")
}

fn assert_alike(scene: &Arc<Scene>, view: View) {
    let image = cast(scene, view);
    let is_ground = |depth: &&f32| depth.is_finite();
    let ground = image.depth.iter().filter(is_ground).count();
    assert!(ground > 1000, "next to nothing is seen: {ground}");
    let mut floor = ShadeFloor::new(scene, &image).expect("an eye in the air");
    floor.shade();
    for (at, (&depth, &again)) in image.depth.iter().zip(&floor.image().depth).enumerate() {
        let alike = depth == again || (depth - again).abs() <= 1e-6 * depth;
        assert!(alike, "depth of pixel {at}: {again}, not {depth}");
    }
    let colours = image.colour().iter().zip(floor.image().colour());
    for (at, (colour, again)) in colours.enumerate() {
        let alike = (0..4).all(|k| colour[k].abs_diff(again[k]) <= 2);
        assert!(alike, "colour of pixel {at}: {again:?}, not {colour:?}");
    }
}

#[test]
fn the_floor_has_the_colours_and_depths_of_the_image() {
    let photo = Photo {
        pixels: TiledRaster::from_fn(310, 400, |x, y| {
            [(x % 97 + 80) as u8, (y % 89 + 90) as u8, 90, 255]
        }),
        origin: DVec2::new(400.0, 150.0),
        spacing: DVec2::new(6.5, 5.0),
    };
    for ground in [
        ground(300, 290, hills),
        ground(300, 290, hills).with_photo(photo),
    ] {
        let scene = Scene::new(ground);
        let extent = scene.ground.grid().extent();
        let eye = DVec3::new(0.4 * extent.x, 0.1 * extent.y, 120.0);
        for view in [
            camera(eye, 0.3, -0.2, 0.0).view([160, 121]),
            camera(eye, -0.8, -0.4, 0.6).view([177, 150]),
            camera(eye.with_z(600.0), 0.2, -1.55, 0.0).view([177, 150]),
            standpoints::at_table(&scene.ground, DVec3::new(0.1, -0.7, 0.6), [277, 150]),
        ] {
            assert_alike(&scene, view);
        }
    }
}

#[test]
fn there_is_no_floor_from_within_the_ground() {
    let scene = Scene::new(ground(300, 290, hills));
    let view = camera(DVec3::new(900.0, 900.0, -500.0), 0.3, 0.0, 0.0).view([20, 16]);
    assert!(ShadeFloor::new(&scene, &cast(&scene, view)).is_none());
}

#[test]
fn there_is_no_floor_without_pixels() {
    let scene = Scene::new(ground(300, 290, hills));
    let view = camera(DVec3::new(900.0, 900.0, 500.0), 0.3, 0.0, 0.0).view([0, 4]);
    assert!(ShadeFloor::new(&scene, &cast(&scene, view)).is_none());
}
