//! What one ray may take from another: rays in a line or a plane, and at an image's edge.

use super::verdict_of;
use glam::{DVec2, DVec3};
use sandtable_cast::Scene;
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A pixel's ray that goes straight down beside the ground meets none, and all around it see what there is.
#[test]
fn straight_down_beside_the_ground_there_is_none() {
    let hills = |col: u32, row: u32| 20.0 * (0.3 * f64::from(col + 2 * row)).sin() as f32;
    let ground = Ground::from_fn(65, 65, DVec2::new(30.0, 22.5), hills).expect("a sound grid");
    let scene = Scene::new(ground);
    for (x, y) in [(690.0, 1620.0), (-60.0, 450.0), (1950.0, -45.0)] {
        for yaw in [0.0, FRAC_PI_4, 0.3] {
            let attitude = Attitude {
                yaw,
                pitch: -FRAC_PI_2,
                roll: 0.0,
            };
            let camera = Camera {
                eye: DVec3::new(x, y, 870.0),
                attitude,
                horizontal_fov: 1.5,
            };
            let verdict = verdict_of(&scene, camera.view([97, 61]));
            assert_eq!(verdict.wrong(), 0, "{verdict} from {x}, {y}, by {yaw}");
        }
    }
}

/// Rolled by exactly 45 degrees, rays of a step's edge lie right over lanes that an earlier step has not.
#[test]
fn what_stands_at_the_images_edge_is_no_sky() {
    for k in 0..120_u32 {
        let teeth = |col: u32, row: u32| {
            let tooth = ((col * 37 + row * 91 + k * 13) % 113) as f32 / 113.0 * 5.0;
            if col.is_multiple_of(2) { tooth } else { -tooth }
        };
        let ground = Ground::from_fn(6 + k % 13, 17, DVec2::ONE, teeth).expect("a sound grid");
        let share = |by: f64| (by * f64::from(k)).fract();
        let eye = ground.grid().extent() * DVec2::new(share(0.618_034), share(0.414_213_6));
        let view = Camera {
            eye: eye.extend(f64::from(ground.range()[1])),
            attitude: Attitude {
                yaw: FRAC_PI_2 * f64::from(k % 4),
                pitch: 0.0,
                roll: FRAC_PI_4 * f64::from(1 + 2 * (k / 4 % 4)),
            },
            horizontal_fov: [0.5, 0.9, 1.3, 1.8][k as usize % 3],
        }
        .view([120, 90]);
        let scene = Scene::new(ground);
        let verdict = verdict_of(&scene, view);
        assert_eq!(verdict.wrong(), 0, "{k}: {verdict}");
    }
}

/// Straight down and rolled by 45 degrees, in a plane of the ground's axes: rays there have nothing along their
/// major axis, but for what rounding leaves.
#[test]
fn rays_along_one_axis_alone_meet_the_ground_where_it_is() {
    for k in 0..60_u32 {
        let steps = |col: u32, row: u32| {
            let town = if (row / 7 + k).is_multiple_of(5) {
                9.0
            } else {
                0.0
            };
            town + 0.2 * (col * 129) as f32 + 0.17 * row as f32
        };
        let ground = Ground::from_fn(2, 256, DVec2::new(129.0, 1.0), steps).expect("a sound grid");
        let share = |by: f64| (by * f64::from(k + 1)).fract();
        let eye = ground.grid().extent() * DVec2::new(share(0.618_034), share(0.414_213_6));
        let view = Camera {
            eye: eye.extend(f64::from(ground.range()[1]) + 40.0 * share(0.37)),
            attitude: Attitude {
                yaw: FRAC_PI_4 * f64::from(k % 8),
                pitch: -FRAC_PI_2,
                roll: FRAC_PI_4 * f64::from(k / 8),
            },
            horizontal_fov: 0.4 + share(0.271),
        }
        .view([320, 240]);
        let verdict = verdict_of(&Scene::new(ground), view);
        assert_eq!(verdict.wrong(), 0, "{k}: {verdict}");
    }
}
