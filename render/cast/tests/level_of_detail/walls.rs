//! The ground's walls.

use crate::ground::{hash, level_under};
use crate::truth::{compared, truth};
use crate::views::cast;
use glam::{DVec2, DVec3};
use sandtable_cast::Planes;
use sandtable_view::{Attitude, Camera};

/// Walls of the ground that run away from the eye: what a pixel sees of one is many posts long.
#[test]
fn walls_are_nearer_to_the_truth() {
    let noise = |x: u32, y: u32| {
        let level = (64 + (hash(x, y) >> 25)) as u8;
        [level, level, level, 255]
    };
    // Beside each side, so that one of two walls lies aslant; and from so far away that a pixel covers a dozen
    // posts of it, and a hundred. Over the small ground pixels have rays of their own.
    for (posts, eye, yaw, horizontal_fov, size, gain) in [
        (401, [-10.0, -40.0], 0.2, 1.0, [160, 120], 7.0),
        (401, [440.0, -9.0], -1.4, 1.0, [160, 120], 7.0),
        (401, [411.0, 440.0], 3.3, 1.0, [160, 120], 7.0),
        (401, [-60.0, 412.0], 1.75, 1.0, [160, 120], 7.0),
        (401, [-500.0, -1500.0], 0.3, 0.15, [160, 120], 7.0),
        (401, [-500.0, -1500.0], 0.3, 0.3, [32, 24], 8.5),
        (61, [-2.0, -8.0], 0.2, 0.4, [160, 120], 0.1),
        (61, [68.0, -1.5], -1.4, 0.4, [160, 120], 0.1),
    ] {
        let scene = level_under(posts, noise);
        for roll in [0.0, 0.7] {
            let attitude = Attitude {
                yaw,
                pitch: -0.1,
                roll,
            };
            let camera = Camera {
                eye: DVec3::from((DVec2::from(eye), 0.05 * f64::from(posts - 1))),
                attitude,
                horizontal_fov,
            };
            let [points, detail] = compared(&scene, camera.view(size));
            println!("from {eye:?}, roll {roll}: {points:.2} dB, with detail {detail:.2}");
            assert!(detail > points + gain, "from {eye:?}, roll {roll}");
        }
    }
}

/// Where two walls meet before the sky a pixel is as much ground as it covers of it, wherever the edge lies in it: it
/// does not hop from pixel to pixel as the eye moves.
#[test]
fn edges_of_walls_move_by_less_than_pixels() {
    let scene = level_under(301, |_, _| [255; 4]);
    for (turn, roll) in [(0.4, 0.0), (1.2, 0.0), (2.3, 1.1), (4.0, 0.5), (5.1, -1.0)] {
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for k in 0..8 {
            // An eighth of a pixel aside each.
            let away = (0.8 * DVec2::from_angle(turn)).extend(0.6);
            let aside = DVec2::from_angle(turn).perp() * 0.6 * f64::from(k);
            let view = Camera {
                eye: DVec3::new(150.0, 150.0, 0.0) + 1500.0 * away + aside.extend(0.0),
                attitude: Attitude {
                    yaw: (-away.x).atan2(-away.y),
                    pitch: -0.6_f64.asin(),
                    roll,
                },
                horizontal_fov: 0.4,
            }
            .view([128, 96]);
            let truth = truth(&scene, &view);
            let images = cast(Planes::WITH_DETAIL, &scene, &[view]);
            let errors = images[0].colour().iter().zip(&truth);
            let error = errors
                .map(|(a, b)| f64::from(a[1].abs_diff(b[1])).powi(2))
                .sum::<f64>();
            worst = worst.max(error);
            sum += error;
        }
        let mean = sum / 8.0;
        println!("{turn}, {roll}: {worst:.0} at worst, {mean:.0} in the mean");
        // As pixels hopped, it was up to 1,200,000 where edges lay half-way between pixels.
        assert!(worst < 450_000.0 && worst < 1.2 * mean);
    }
}
