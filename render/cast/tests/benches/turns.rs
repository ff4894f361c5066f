//! Contenders that take turns, and what is told of them.

use crate::contest::Contest;
use crate::contest::report::{Line, Run};
use crate::embree::{self, Compiled};
use crate::scenes::BenchScene;
use glam::{DVec2, DVec3};
use sandtable_cast::standpoints::{self, Standpoint};
use sandtable_cast::{CastPool, Scene};
use sandtable_terrain::{Ground, Photo, TiledRaster};
use std::path::Path;

/// Hills over cells that are not square, and are fewer from south to north.
fn hills() -> BenchScene {
    let spacing = DVec2::new(30.0, 20.0);
    let height = |col: u32, row: u32| {
        let (x, y) = (f64::from(col), f64::from(row));
        (400.0 + 150.0 * (x / 11.0).sin() * (y / 7.0).cos() + 2.0 * x) as f32
    };
    let ground = Ground::from_fn(120, 90, spacing, height).expect("a sound grid");
    let photo = Photo {
        // Another post's colour is not near.
        pixels: TiledRaster::from_fn(120, 90, |col, row| {
            [200 * (col % 2) as u8, 200 * (row % 2) as u8, 100, 255]
        }),
        origin: DVec2::ZERO,
        spacing,
    };
    // Sizes that neither Embree's packets nor the checked pixels divide.
    let eye = DVec3::new(0.1, -0.75, 0.6);
    let views = [
        ("ahead", standpoints::ahead(&ground, [203, 149])),
        ("wan", standpoints::wan(&ground, 0.4)),
        ("table", standpoints::at_table(&ground, eye, [161, 98])),
    ];
    let views = views.map(|(name, view)| Standpoint {
        name: name.to_owned(),
        view,
    });
    BenchScene {
        name: "hills".to_owned(),
        scene: Scene::new(ground.with_photo(photo)),
        views: views.into(),
    }
}

#[test]
fn everyone_is_timed_and_sees_what_brute_force_sees() {
    let program = match embree::compiled(Path::new(env!("CARGO_TARGET_TMPDIR"))).unwrap() {
        Compiled::Ready(program) => Some(program),
        Compiled::Missing(what) => {
            println!("without Embree: {what}");
            None
        }
    };
    let scene = hills();
    let pools = [1, 2].map(|threads| CastPool::new(threads).unwrap());
    let casters = ["brute".to_owned(), "coherent".to_owned()];
    let mut contest = Contest::prepare(&scene, &casters, &pools, program.as_deref()).unwrap();
    for at in &scene.views {
        let lines = contest.race(at, 1).unwrap();
        assert_eq!(
            lines.iter().map(|it| it.threads).collect::<Vec<_>>(),
            [1, 2]
        );
        for line in lines {
            let [brute, coherent] = line.ours[..] else {
                panic!("two casters take part");
            };
            assert_eq!(brute.unwrap().right, 1.0, "{}", at.name);
            assert!(coherent.unwrap().right > 0.9, "{}", at.name);
            for run in line.embree {
                assert_eq!(run.is_some(), program.is_some());
                // A cell's two triangles are not quite its bilinear surface.
                let right = run.map_or(1.0, |run| run.right);
                assert!(right > 0.8, "{}: {right} of the pixels are right", at.name);
            }
        }
    }
}

#[test]
fn a_caster_that_refuses_a_view_takes_no_part_in_it() {
    let scene = hills();
    let pools = [CastPool::new(1).unwrap()];
    let casters = ["floating-horizon".to_owned(), "coherent".to_owned()];
    let mut contest = Contest::prepare(&scene, &casters, &pools, None).unwrap();
    let lines = contest.race(&scene.views[2], 2).unwrap();
    assert!(lines[0].ours[0].is_none() && lines[0].ours[1].is_some());
}

#[test]
fn ratios_are_of_the_better_geometry() {
    let run = |median_ms| {
        Some(Run {
            median_ms,
            right: 1.0,
        })
    };
    let mut line = Line {
        scene: String::new(),
        view: String::new(),
        threads: 1,
        embree: [run(30.0), run(20.0)],
        ours: vec![run(5.0), None],
    };
    assert_eq!([line.ratio(0), line.ratio(1)], [Some(4.0), None]);
    line.embree[1] = None;
    assert_eq!(line.ratio(0), Some(6.0));
    line.embree[0] = None;
    assert_eq!(line.ratio(0), None);
}
