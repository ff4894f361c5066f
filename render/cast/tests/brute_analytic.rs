//! Brute force against answers known on paper.

use glam::{DVec2, DVec3};
use sandtable_cast::{Brute, CastPool, Image, Scene};
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, Screen, View};
use std::sync::Arc;

/// Casts `view` over `scene` by brute force.
fn cast(scene: &Arc<Scene>, view: View) -> Image {
    let pool = CastPool::new(2).expect("two threads");
    pool.picture(&Brute, scene, view).expect("any view will do")
}

/// The depth along one ray, +∞ for sky.
fn depth(scene: &Arc<Scene>, eye: DVec3, direction: DVec3) -> f64 {
    f64::from(cast(scene, single_ray(eye, direction)).depth[0])
}

/// A view of one pixel, whose ray goes along `direction`.
fn single_ray(eye: DVec3, direction: DVec3) -> View {
    let side = direction.any_orthonormal_vector();
    let up = side.cross(direction.normalize());
    let lower_left = eye + direction.normalize() - 0.5 * (side + up);
    let window = Screen {
        lower_left,
        lower_right: lower_left + side,
        upper_left: lower_left + up,
    };
    View {
        eye,
        window,
        size: [1, 1],
    }
}

fn ground(
    cols: u32,
    rows: u32,
    spacing: DVec2,
    height: impl Fn(f64, f64) -> f64 + Sync,
) -> Arc<Scene> {
    let post =
        |col: u32, row: u32| height(f64::from(col) * spacing.x, f64::from(row) * spacing.y) as f32;
    Scene::new(Ground::from_fn(cols, rows, spacing, post).expect("a sound grid"))
}

fn near(found: f64, expected: f64) {
    // Depths are stored as f32.
    let tolerance = 2e-7 * expected.abs() + 1e-6;
    assert!(
        (found - expected).abs() <= tolerance,
        "{found} is not {expected}"
    );
}

#[test]
fn a_plane_is_hit_where_its_height_is_reached() {
    let scene = ground(301, 401, DVec2::new(10.0, 20.0), |_, _| 100.0);
    let camera = Camera {
        eye: DVec3::new(1500.0, 1000.0, 700.0),
        attitude: Attitude {
            yaw: 0.4,
            pitch: -0.5,
            roll: 0.3,
        },
        horizontal_fov: 1.0,
    };
    let image = cast(&scene, camera.view([160, 120]));
    let mut hits = 0;
    for j in 0..120 {
        for i in 0..160 {
            let ray = image.view.ray(i, j);
            let t = (100.0 - ray.origin.z) / ray.direction.z;
            let p = ray.origin + t * ray.direction;
            let inside = (0.0..=3000.0).contains(&p.x) && (0.0..=8000.0).contains(&p.y);
            let found = f64::from(image.depth[(j * 160 + i) as usize]);
            if t > 0.0 && inside {
                near(found, t * ray.direction.length());
                hits += 1;
            } else {
                assert_eq!(found, f64::INFINITY, "pixel {i}, {j}");
            }
        }
    }
    assert!(hits > 10_000, "only {hits} pixels see the plane");
}

#[test]
fn a_ramp_is_hit_where_ray_and_slope_meet() {
    // Rises 1 in 4 to the north.
    let scene = ground(101, 101, DVec2::splat(10.0), |_, y| 0.25 * y);
    let eye = DVec3::new(505.0, 1.0, 200.0);
    for slope in [0.1, 0.0, -0.1, -0.5] {
        let direction = DVec3::new(0.05, 1.0, slope);
        // 200 + slope·s = ¼ (1 + s)
        let s = (200.0 - 0.25) / (0.25 - slope);
        let expected = if s <= 999.0 {
            s * direction.length()
        } else {
            f64::INFINITY
        };
        near_or_sky(depth(&scene, eye, direction), expected);
    }
}

fn near_or_sky(found: f64, expected: f64) {
    if expected.is_finite() {
        near(found, expected)
    } else {
        assert_eq!(found, expected)
    }
}

#[test]
fn a_bilinear_saddle_is_met_at_the_quadratics_root() {
    // One cell, corners 0, 1 / 1, 0 (times 10): z = 10 (u + v − 2uv).
    let corner = |col: u32, row: u32| if (col + row) % 2 == 1 { 10.0 } else { 0.0 };
    let scene = Scene::new(Ground::from_fn(2, 2, DVec2::ONE, corner).unwrap());
    // Along the diagonal u = v = s, at height 4: 20 s − 20 s² = 4, the smaller root.
    let eye = DVec3::new(-1.0, -1.0, 4.0);
    let s = 0.5 * (1.0 - (1.0f64 - 0.8).sqrt());
    near(
        depth(&scene, eye, DVec3::new(1.0, 1.0, 0.0)),
        (1.0 + s) * 2.0f64.sqrt(),
    );
    // Along the other diagonal u = s, v = 1 − s: z = 10 (1 − 2 s (1 − s)) dips to 5 in the middle;
    // a ray that falls from 11 at s = 0 to 5.5 at s = ½ meets it on the way.
    let eye = DVec3::new(-1.0, 2.0, 22.0);
    let fall = 11.0;
    // 11 − 11 s = 10 − 20 s + 20 s²  ⇒  20 s² − 9 s − 1 = 0
    let s = (9.0 + (81.0f64 + 80.0).sqrt()) / 40.0;
    near(
        depth(&scene, eye, DVec3::new(1.0, -1.0, -fall)),
        (1.0 + s) * (2.0 + fall * fall).sqrt(),
    );
}

#[test]
fn a_dip_inside_a_cell_is_not_missed() {
    // Both ends of the ray's way through the cell lie above ground, its middle below.
    let corner = |col: u32, row: u32| if col == row { 10.0 } else { 0.0 };
    let scene = Scene::new(Ground::from_fn(2, 2, DVec2::ONE, corner).unwrap());
    let eye = DVec3::new(-1.0, 2.0, 4.0);
    // u = s, v = 1 − s: z = 10 (1 − u − v + 2uv) = 20 s (1 − s) = 4 first at:
    let s = 0.5 * (1.0 - (1.0f64 - 0.8).sqrt());
    near(
        depth(&scene, eye, DVec3::new(1.0, -1.0, 0.0)),
        (1.0 + s) * 2.0f64.sqrt(),
    );
}

#[test]
fn a_step_shows_its_face() {
    // Posts at x < 500 are 0, from 500 on 80: the face is one cell wide.
    let scene = ground(101, 101, DVec2::splat(10.0), |x, _| {
        if x < 500.0 { 0.0 } else { 80.0 }
    });
    // Level, at height 20, eastwards: the face (490 to 500) stands at 20 at x = 492.5.
    near(
        depth(&scene, DVec3::new(100.0, 333.0, 20.0), DVec3::X),
        392.5,
    );
    // Over the top: sky.
    assert_eq!(
        depth(&scene, DVec3::new(100.0, 333.0, 81.0), DVec3::X),
        f64::INFINITY
    );
}

#[test]
fn straight_down_and_straight_up() {
    let scene = ground(11, 11, DVec2::splat(10.0), |x, _| x);
    let eye = DVec3::new(33.0, 50.0, 500.0);
    near(depth(&scene, eye, -DVec3::Z), 467.0);
    assert_eq!(depth(&scene, eye, DVec3::Z), f64::INFINITY);
    // On the very border, and on the corner post.
    near(
        depth(&scene, DVec3::new(100.0, 0.0, 500.0), -DVec3::Z),
        400.0,
    );
    near(depth(&scene, DVec3::new(0.0, 0.0, 500.0), -DVec3::Z), 500.0);
    // Beside the terrain: nothing there. (Numbers that f64 holds exactly: the ray must be plumb.)
    assert_eq!(
        depth(&scene, DVec3::new(-0.5, 50.0, 500.0), -DVec3::Z),
        f64::INFINITY
    );
}

#[test]
fn an_eye_inside_the_terrain_hits_at_depth_zero() {
    let scene = ground(11, 11, DVec2::splat(10.0), |_, _| 30.0);
    for direction in [DVec3::X, DVec3::Z, -DVec3::Z, DVec3::new(1.0, 2.0, 3.0)] {
        assert_eq!(depth(&scene, DVec3::new(50.0, 50.0, 29.0), direction), 0.0);
        // Deep below is inside too: the terrain reaches down without end.
        assert_eq!(
            depth(&scene, DVec3::new(50.0, 50.0, -4000.0), direction),
            0.0
        );
    }
}

#[test]
fn a_ray_that_enters_under_the_border_hits_the_wall() {
    let scene = ground(11, 11, DVec2::splat(10.0), |_, y| 30.0 + y);
    // From the south, level, at 10 m: the wall stands at y = 0.
    near(depth(&scene, DVec3::new(55.0, -70.0, 10.0), DVec3::Y), 70.0);
    // From below the terrain's lowest height, upwards, through the west side.
    let direction = DVec3::new(1.0, 0.0, 1.0);
    near(
        depth(&scene, DVec3::new(-40.0, 50.0, -100.0), direction),
        40.0 * 2.0f64.sqrt(),
    );
    // The wall has the border's colour there.
    let image = cast(
        &scene,
        single_ray(DVec3::new(-40.0, 50.0, -100.0), direction),
    );
    let [r, g, b, _] = image.colour()[0];
    assert_eq!([r, g, b], scene.ground.colour_at(0.0, 50.0));
}

#[test]
fn an_eye_outside_sees_the_terrain_over_its_border() {
    let scene = ground(11, 11, DVec2::splat(10.0), |_, _| 30.0);
    // Comes in over the border at 35 m and lands at 30 m.
    let direction = DVec3::new(1.0, 0.0, -0.1);
    near(
        depth(&scene, DVec3::new(-100.0, 50.0, 45.0), direction),
        150.0 * direction.length(),
    );
    // Looking away: sky.
    assert_eq!(
        depth(&scene, DVec3::new(-100.0, 50.0, 45.0), -DVec3::X),
        f64::INFINITY
    );
}
