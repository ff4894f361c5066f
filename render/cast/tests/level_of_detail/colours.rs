//! Ground of one colour has that colour.

use crate::ground::{level_under, mountains, photo};
use crate::views::{camera, cast};
use glam::DVec3;
use sandtable_cast::{Planes, Scene};
use sandtable_terrain::TiledRaster;
use sandtable_view::{Screen, View};

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

/// Rays that meet flat ground right at lines of posts: its slope is that of the horizon there, to the last
/// bit, so that nothing tells by itself whether a line has been seen.
#[test]
fn white_ground_has_no_specks() {
    let scene = level_under(301, |_, _| [255; 4]);
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
    let detailed = cast(Planes::WITH_DETAIL, &scene, &views);
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
