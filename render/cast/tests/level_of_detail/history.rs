//! An image is the same whatever was cast before.

use crate::ground::hash;
use crate::views::cast;
use glam::{DVec2, DVec3};
use sandtable_cast::{CastPool, Image, Planes, Scene, caster_by_name};
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera};

/// What a thread has cast before leaves no trace, so that an image is the same on any thread.
#[test]
fn what_was_cast_before_changes_nothing() {
    // Spikes make many rays begin where others than those right before them have ended.
    let spikes = |col: u32, row: u32| {
        let hills = 20.0 * ((f64::from(col) * 0.03).sin() + (f64::from(row) * 0.041).cos());
        let spike = if hash(col, row).is_multiple_of(97) {
            15.0
        } else {
            0.0
        };
        (hills + spike) as f32
    };
    let scene = Scene::new(Ground::from_fn(500, 500, DVec2::ONE, spikes).expect("a sound grid"));
    let share = |k: u32, of: u32| f64::from(hash(k, of) >> 8) / 16_777_216.0;
    let views: Vec<_> = (0..60)
        .map(|k| {
            let eye = [500.0, 500.0, 400.0].map(|most| most * share(k, most as u32 + 1));
            let turned = |of: u32| std::f64::consts::TAU * share(k, of);
            Camera {
                eye: DVec3::from_array(eye) + 40.0 * DVec3::Z,
                attitude: Attitude {
                    yaw: turned(1),
                    pitch: -1.5 * share(k, 2),
                    roll: turned(3),
                },
                horizontal_fov: 0.5 + share(k, 4),
            }
            .view([320, 240])
        })
        .collect();
    let one_by_one: Vec<_> = views
        .iter()
        .map(|view| cast(Planes::WITH_DETAIL, &scene, &[*view]).remove(0))
        .collect();
    let pool = CastPool::new(1).expect("a thread");
    let caster = caster_by_name(Planes::WITH_DETAIL).expect("there is one");
    let prepared = caster.prepare(scene).expect("suits");
    let mut image = [Image::default()];
    for (k, (view, alone)) in views.iter().zip(&one_by_one).enumerate() {
        pool.cast(&*prepared, &[*view], &mut image)
            .expect("accepted");
        assert!(image[0].colour() == alone.colour(), "colours of view {k}");
        assert!(image[0].depth == alone.depth, "depths of view {k}");
    }
}

/// Where the ground's corners are seen from beside it, in narrow images, too: pixels ask planes beside their own.
#[test]
fn corners_look_the_same_after_another_view() {
    let rough = |col: u32, row: u32| ((col * 37 + row * 91) % 113) as f32 * 0.1;
    let scene = Scene::new(Ground::from_fn(65, 65, DVec2::ONE, rough).expect("a sound grid"));
    let before = Camera {
        eye: DVec3::new(32.0, -50.0, 60.0),
        attitude: Attitude {
            yaw: 0.0,
            pitch: -0.5,
            roll: 0.3,
        },
        horizontal_fov: 1.2,
    }
    .view([300, 200]);
    let caster = caster_by_name(Planes::WITH_DETAIL).expect("there is one");
    let prepared = caster.prepare(scene).expect("suits");
    let pool = CastPool::new(1).expect("a thread");
    let (mut image, mut alone) = ([Image::default()], [Image::default()]);
    for k in 0..120_u32 {
        let share = |by: f64| (by * f64::from(k + 1)).fract();
        let far = 80.0 + 3000.0 * share(0.271).powi(2);
        let (s, c) = (std::f64::consts::TAU * share(0.618_034)).sin_cos();
        let eye = DVec3::new(
            32.0 + far * c,
            32.0 + far * s,
            20.0 + 0.8 * far * share(0.37),
        );
        let way = DVec3::new(32.0, 32.0, 0.0) - eye;
        let view = Camera {
            eye,
            attitude: Attitude {
                yaw: way.x.atan2(way.y),
                pitch: way.z.atan2(way.truncate().length()),
                roll: std::f64::consts::TAU * share(0.414),
            },
            horizontal_fov: (97.5 / far).min(1.8),
        }
        .view([[160, 120], [1, 150], [200, 3], [17, 90]][k as usize % 4]);
        let other_thread = CastPool::new(1).expect("a thread");
        let accepted = "accepted";
        other_thread
            .cast(&*prepared, &[view], &mut alone)
            .expect(accepted);
        pool.cast(&*prepared, &[before], &mut image)
            .expect(accepted);
        pool.cast(&*prepared, &[view], &mut image).expect(accepted);
        assert!(
            image[0].colour() == alone[0].colour(),
            "colours of view {k}"
        );
        assert!(image[0].depth == alone[0].depth, "depths of view {k}");
    }
}
