//! Eyes and pixels at which numbers of 32 bits end.

use super::verdict_of;
use glam::{DVec2, DVec3};
use sandtable_cast::Scene;
use sandtable_terrain::Ground;
use sandtable_tests::Random;
use sandtable_view::{Attitude, Camera, Screen, View};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// Far away a ray's place is rounded by more than a ray that passes right over a flat roof's edge has left
/// to it, where the wall behind that edge, if it went on upwards, would be higher by twenty times as much.
#[test]
fn rays_that_just_pass_over_an_edge_do_not_meet_the_wall_behind() {
    let roofs = |col: u32, row: u32| {
        if (col / 7 + row / 5).is_multiple_of(2) {
            8020.0
        } else {
            8000.0
        }
    };
    let ground = Ground::from_fn(258, 514, DVec2::ONE, roofs).expect("a sound grid");
    let view = View {
        eye: DVec3::new(318.31, 203.77, 8029.03),
        window: Screen {
            lower_left: DVec3::new(-98.44, 124.78, 8010.58),
            lower_right: DVec3::new(74.86, 90.53, 8010.58),
            upper_left: DVec3::new(-98.44, 815.41, 8010.58),
        },
        size: [640, 640],
    };
    let verdict = verdict_of(&Scene::new(ground), view);
    assert_eq!(verdict.wrong(), 0, "{verdict}");
}

/// Slopes, with bends, so steep that from an eye a millionth of a cell over them numbers of 32 bits cannot tell on
/// which side it is.
#[test]
fn eyes_hardly_over_a_slope_see_what_brute_force_sees() {
    for (rise, spacing) in [(0.05, 1.0), (3.0, 1.0), (30.0, 30.0)] {
        let slope = |col: u32, row: u32| {
            let bend = 0.37 * f64::from((col * 7 + row * 3) % 5);
            (rise * (0.7 * f64::from(col) + 0.313 * f64::from(row) + bend)) as f32
        };
        let ground = Ground::from_fn(33, 33, DVec2::splat(spacing), slope).expect("a sound grid");
        let scene = Scene::new(ground);
        for k in 0..32_u32 {
            let share = |by: f64| 4.0 + 24.0 * (by * f64::from(k + 1)).fract();
            let at = spacing * DVec2::new(share(0.618_034), share(0.414_213_6));
            let height = scene.ground.height_at(at.x, at.y).expect("on the ground");
            let over = 10.0_f64.powi(-9 + (k % 4) as i32);
            let view = Camera {
                eye: at.extend(height + over),
                attitude: Attitude {
                    yaw: 0.37 * f64::from(k),
                    pitch: -0.1,
                    roll: 0.0,
                },
                horizontal_fov: 1.2,
            }
            .view([64, 48]);
            let verdict = verdict_of(&scene, view);
            assert_eq!(verdict.wrong(), 0, "{rise}, {k}, {over} over it: {verdict}");
        }
    }
}

/// Eyes so close to a wall that what is left to it is lost beside the eye's own place, looking up along it: right
/// below its upper edge, or farther below.
#[test]
fn eyes_right_before_a_wall_see_where_it_ends() {
    for (height, below) in [(0.1, 0.0), (0.1, 3.0), (0.002, 1e-4)] {
        let teeth = |col: u32, row: u32| ((col * 37 + row * 91) % 113) as f32 * height;
        let ground = Ground::from_fn(40, 50, DVec2::new(1.0, 1.3), teeth).expect("a sound grid");
        let extent = ground.grid().extent();
        let scene = Scene::new(ground);
        for k in 0..48_u32 {
            let share = (0.618_034 * f64::from(k + 1)).fract();
            let out = 10.0_f64.powi(-9 + (k % 6) as i32);
            let along = share * extent;
            let (at, inwards) = match k % 4 {
                0 => (DVec2::new(-out, along.y), FRAC_PI_2),
                1 => (DVec2::new(extent.x + out, along.y), -FRAC_PI_2),
                2 => (DVec2::new(along.x, -out), 0.0),
                _ => (DVec2::new(along.x, extent.y + out), 2.0 * FRAC_PI_2),
            };
            let edge = at.clamp(DVec2::ZERO, extent);
            let edge = scene.ground.height_at(edge.x, edge.y);
            let below = below + 3.0 * out;
            let view = Camera {
                eye: at.extend(edge.expect("on the border") - below),
                attitude: Attitude {
                    yaw: inwards + 0.4 * (share - 0.5),
                    pitch: 1.2,
                    roll: 0.3 * f64::from(k),
                },
                horizontal_fov: 1.6,
            }
            .view([160, 120]);
            let verdict = verdict_of(&scene, view);
            let place = format!("{k}, {out} before a wall of {height}, {below} below");
            assert_eq!(verdict.wrong(), 0, "{place}: {verdict}");
        }
    }
}

/// Eyes hardly over a terrace, at the edge from which a wall goes down: at a post or between two, and right on their
/// line, which is the terrace's own, or hardly before it.
#[test]
fn eyes_at_a_walls_upper_edge_see_what_brute_force_sees() {
    for (base, wall) in [(0.0, 0.3), (8848.0, 0.3), (-1e6, 0.2), (100.0, 20.0)] {
        let terrace = |col: u32, row: u32| {
            let is_high = col >= 20 && row >= 10;
            base + if is_high { wall } else { 0.0 }
        };
        let ground = Ground::from_fn(50, 40, DVec2::new(1.0, 1.3), terrace);
        let scene = Scene::new(ground.expect("a sound grid"));
        for k in 0..96_u32 {
            let share = |by: f64| (by * f64::from(k + 1)).fract();
            let aside = [0.0, 1e-9, 1e-7, 1e-5][k as usize % 4];
            let along = [15.0, 15.0 + 8.0 * share(0.618_034)][k as usize / 4 % 2];
            let place = if k / 8 % 2 == 0 {
                DVec2::new(20.0 + aside, along)
            } else {
                DVec2::new(along + 10.0, 10.0 + aside)
            };
            let at = place * DVec2::new(1.0, 1.3);
            let height = scene.ground.height_at(at.x, at.y).expect("on the ground");
            let over = 10.0_f64.powi(-10 + (k / 16) as i32);
            let view = Camera {
                eye: at.extend(height + over),
                attitude: Attitude {
                    yaw: TAU * share(0.414_213_6),
                    pitch: -0.3 * share(0.271_828),
                    roll: share(0.173),
                },
                horizontal_fov: 1.8,
            }
            .view([64, 48]);
            let verdict = verdict_of(&scene, view);
            let place = format!("{k}, {place} by {base}, {over} over a wall of {wall}");
            assert_eq!(verdict.wrong(), 0, "{place}: {verdict}");
        }
    }
}

/// Eyes hardly over a slope, a little farther from the edge of a gorge of tens of cells' lengths.
#[test]
fn eyes_before_a_gorge_see_what_brute_force_sees() {
    let cell = 128.0;
    let gorge = |col: u32, row: u32| {
        let deep = if col < 20 { 4300.0 } else { 0.0 };
        (-250_000.0 - 1.9 * f64::from(col) - 1.5 * f64::from(row) - deep) as f32
    };
    let ground = Ground::from_fn(50, 40, DVec2::splat(cell), gorge);
    let scene = Scene::new(ground.expect("a sound grid"));
    for k in 0..96_u32 {
        let share = |by: f64| (by * f64::from(k + 1)).fract();
        let aside = 3.5e-3 + 0.02 * share(0.618_034);
        let at = cell * DVec2::new(20.0 + aside, 10.0 + 20.0 * share(0.414_213_6));
        let height = scene.ground.height_at(at.x, at.y).expect("on the ground");
        let over = cell * 10.0_f64.powf(-6.0 + 2.0 * share(0.271_828));
        let view = Camera {
            eye: at.extend(height + over),
            attitude: Attitude {
                yaw: TAU * share(0.732_051),
                pitch: 0.2 * share(0.236_068) - 0.1,
                roll: share(0.173),
            },
            horizontal_fov: 2.4,
        }
        .view([160, 120]);
        let verdict = verdict_of(&scene, view);
        let place = format!("{k}, {aside} before a gorge, {over} over");
        assert_eq!(verdict.wrong(), 0, "{place}: {verdict}");
    }
}

/// Pixels so narrow that numbers of 32 bits tell their rays from one straight down, but hardly from one another:
/// they meet a wall right beside the eye.
#[test]
fn pixels_of_a_microscope_see_what_brute_force_sees() {
    let hills = |col: u32, row: u32| ((col * 37 + row * 91) % 113) as f32 * 0.05;
    let ground = Ground::from_fn(60, 60, DVec2::ONE, hills).expect("a sound grid");
    let scene = Scene::new(ground);
    for k in 0..12_u32 {
        let pixel = 10.0_f64.powi(-10 + (k % 4) as i32);
        let size = [64, 48];
        let view = Camera {
            eye: DVec3::new(-9.0 * pixel, 30.6, 1.0 + f64::from(k)),
            attitude: Attitude {
                yaw: FRAC_PI_4 * f64::from(k),
                pitch: -FRAC_PI_2,
                roll: 0.0,
            },
            horizontal_fov: f64::from(size[0]) * pixel,
        }
        .view(size);
        let verdict = verdict_of(&scene, view);
        assert_eq!(verdict.wrong(), 0, "{k}, {pixel}: {verdict}");
    }
}

/// Eyes right beside the ground and lower than it, looking almost along its wall: all pixels of the line upwards in the
/// middle, which runs along columns, rows or diagonals, meet it at the same distance.
#[test]
fn rays_almost_along_a_wall_meet_it_where_they_come_to_it() {
    let noise = |col: u32, row: u32| 8848.0 + ((col * 37 + row * 91) % 113) as f32 * 0.005;
    let ground = Ground::from_fn(84, 99, DVec2::ONE, noise).expect("a sound grid");
    let extent = ground.grid().extent();
    let scene = Scene::new(ground);
    for k in 0..128_u32 {
        let share = |by: f64| (by * f64::from(k + 1)).fract();
        let slant = 10.0_f64.powf(-3.5 + 2.0 * share(0.618_034));
        let out = slant * (2.0 + 20.0 * share(0.414_213_6));
        let inwards = if k % 2 == 0 { slant } else { -slant };
        let (at, yaw) = match k % 4 {
            0 => (DVec2::new(-out, 0.5 * extent.y), 0.0),
            1 => (DVec2::new(extent.x + out, 0.5 * extent.y), 0.0),
            2 => (DVec2::new(0.5 * extent.x, extent.y + out), FRAC_PI_2),
            _ => (DVec2::new(0.5 * extent.x, -out), FRAC_PI_2),
        };
        let view = Camera {
            eye: at.extend(8848.0 - 15.0 * share(0.271_828)),
            attitude: Attitude {
                yaw: yaw + inwards,
                pitch: share(0.236_068) - 0.8,
                roll: FRAC_PI_4 * f64::from(k / 4 % 8),
            },
            horizontal_fov: 0.5 + 1.7 * share(0.173),
        }
        .view([161, 121]);
        let verdict = verdict_of(&scene, view);
        assert_eq!(verdict.wrong(), 0, "{k}, {out} beside it: {verdict}");
    }
}

/// Eyes right over the ground's border, of whose pixels one diagonal looks along it, on either side by no more than
/// rounding: an eye that is taken to be a little beside it sees the wall there, somewhere.
#[test]
fn eyes_over_the_border_see_along_it_what_brute_force_sees() {
    let mut random = Random::new(9);
    for k in 0..64 {
        let spacing = DVec2::splat(random.octaves(0.05, 0.2));
        let rough = |col: u32, row: u32| 0.02 * ((col * 37 + row * 91) % 23) as f32;
        let ground = Ground::from_fn(106, 75, spacing, rough).expect("a sound grid");
        let extent = ground.grid().extent();
        let along = random.between(0.2, 0.8) * extent;
        let at = [
            DVec2::new(extent.x, along.y),
            DVec2::new(along.x, extent.y),
            DVec2::new(0.0, along.y),
            DVec2::new(along.x, 0.0),
        ][k % 4];
        let view = Camera {
            eye: at.extend(0.46 + random.octaves(0.5, 20.0) * spacing.x),
            attitude: Attitude {
                yaw: FRAC_PI_4 + FRAC_PI_2 * (k / 4) as f64,
                pitch: -FRAC_PI_2,
                roll: 0.0,
            },
            horizontal_fov: random.between(0.5, 2.0),
        }
        .view([96, 96]);
        let verdict = verdict_of(&Scene::new(ground), view);
        assert_eq!(verdict.wrong(), 0, "{k}, {at} over {spacing}: {verdict}");
    }
}
