//! Stereo against pencil and paper: points at known places fall on the pixels that geometry gives,
//! in both eyes, at the table and upright.

use glam::{DQuat, DVec2, DVec3};
use sandtable_cast::{Brute, CastPool, Caster, Image, Scene};
use sandtable_pose::Rigid;
use sandtable_terrain::{Ground, Photo, TiledRaster};
use sandtable_tests::{Marker, centroid, marked_plane};
use sandtable_view::{Attitude, Camera, EyesInHead, Placement, Screen, Stereo, StereoPair, View};
use std::sync::Arc;

const GLASS: [f64; 2] = [1.8, 1.1];
const EYES: [DVec3; 3] = [
    DVec3::new(0.1, -0.95, 0.62),
    DVec3::new(0.0675, -0.95, 0.62),
    DVec3::new(0.1325, -0.95, 0.62),
];

fn cast(scene: &Arc<Scene>, views: &[View]) -> Vec<Image> {
    let mut images = vec![Image::default(); views.len()];
    let prepared = Brute.prepare(Arc::clone(scene)).expect("no options");
    CastPool::new(2)
        .expect("two threads")
        .cast(&*prepared, views, &mut images)
        .expect("any view will do");
    images
}

/// Normalised device coordinates (−1 to 1, y up) as pixels.
fn pixel_of_ndc(x: f64, y: f64, size: [u32; 2]) -> DVec2 {
    DVec2::new(
        (x + 1.0) / 2.0 * f64::from(size[0]),
        (1.0 - y) / 2.0 * f64::from(size[1]),
    )
}

/// A small deterministic generator (SplitMix64), from 0 to 1.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A head over or before the table, looking anywhere.
    fn head(&mut self) -> Rigid {
        let axis = DVec3::new(
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
            self.between(-1.0, 1.0),
        );
        Rigid::new(
            DQuat::from_axis_angle(
                axis.try_normalize().unwrap_or(DVec3::Z),
                self.between(0.0, 3.0),
            ),
            DVec3::new(
                self.between(-1.0, 1.0),
                self.between(-1.2, 0.4),
                self.between(0.35, 1.2),
            ),
        )
    }
}

/// The worked numbers of a table of 1.80 by 1.10 m (Kooima's frustum from corners).
#[test]
fn points_over_and_under_the_table_fall_where_the_worked_numbers_say() {
    let worked = [
        [(-0.052910, 0.822511), (0.027100, -0.421286)],
        [(-0.035714, 0.822511), (0.018293, -0.421286)],
        [(-0.070106, 0.822511), (0.035908, -0.421286)],
    ];
    let size = [1920, 1080];
    for (eye, points) in EYES.into_iter().zip(worked) {
        let view = View {
            eye,
            window: Screen::horizontal(GLASS[0], GLASS[1]),
            size,
        };
        for (z, (x, y)) in [0.2, -0.2].into_iter().zip(points) {
            let found = view.pixel_of(DVec3::new(0.0, 0.0, z)).unwrap();
            let wanted = pixel_of_ndc(x, y, size);
            assert!(
                (found - wanted).length() < 2e-3,
                "eye {eye}, z {z}: {found} is not {wanted}"
            );
        }
        let middle = view.pixel_of(DVec3::ZERO).unwrap();
        assert!((middle - DVec2::new(960.0, 540.0)).length() < 1e-9);
    }
}

/// The near plane's corners (l, b) to (r, t) of the worked frusta are the window's corners.
#[test]
fn the_worked_frusta_end_at_the_windows_corners() {
    let table = Screen::horizontal(GLASS[0], GLASS[1]);
    let leaning = Screen {
        lower_left: DVec3::new(-0.9, 0.55, 0.0),
        lower_right: DVec3::new(0.9, 0.55, 0.0),
        upper_left: DVec3::new(-0.9, 1.1, 0.952_628),
    };
    let cases = [
        (
            table,
            EYES[0],
            0.62,
            [-0.161290, 0.129032, 0.064516, 0.241935],
        ),
        (
            table,
            EYES[1],
            0.62,
            [-0.156048, 0.134274, 0.064516, 0.241935],
        ),
        (
            table,
            EYES[2],
            0.62,
            [-0.166532, 0.123790, 0.064516, 0.241935],
        ),
        (
            leaning,
            EYES[0],
            1.609_038,
            [-0.062149, 0.049719, 0.013242, 0.081606],
        ),
    ];
    let size = [1800, 1100];
    for (screen, eye, distance, [left, right, bottom, top]) in cases {
        let normal = screen.normal().unwrap();
        assert!(((eye - screen.lower_left).dot(normal) - distance).abs() < 1e-6);
        let view = View {
            eye,
            window: screen,
            size,
        };
        let (across, upwards) = (screen.across().normalize(), screen.upwards().normalize());
        let near = |x: f64, y: f64| eye - 0.1 * normal + x * across + y * upwards;
        let corners = [
            (near(left, bottom), DVec2::new(0.0, 1100.0)),
            (near(right, bottom), DVec2::new(1800.0, 1100.0)),
            (near(left, top), DVec2::new(0.0, 0.0)),
            (near(right, top), DVec2::new(1800.0, 0.0)),
        ];
        for (point, corner) in corners {
            let found = view.pixel_of(point).unwrap();
            assert!((found - corner).length() < 0.05, "{found} is not {corner}");
        }
    }
}

/// The same points, as rendered.
#[test]
fn rendered_markers_fall_where_geometry_says_in_both_eyes() {
    let size = [600, 366];
    // The world is the table, moved so that its corner is the origin.
    let placement = Placement {
        anchor: DVec3::new(1.5, 1.2, 0.0),
        yaw: 0.0,
        scale: 1.0,
        exaggeration: 1.0,
    };
    let screen = Screen::horizontal(GLASS[0], GLASS[1]);
    let eyes = StereoPair {
        left: EYES[1],
        right: EYES[2],
    };
    let views = StereoPair::<View>::on_table(eyes, &screen, &placement, size).into_array();
    for z in [0.2, 0.0, -0.2] {
        for (x, y) in [(0.0, 0.0), (-0.4, -0.1), (0.35, -0.3)] {
            let point = placement.world_from_table(DVec3::new(x, y, z));
            let marker = Marker {
                at: point.truncate(),
                radius: 0.03,
            };
            let scene = marked_plane(DVec2::new(3.0, 2.4), z, marker);
            let images = cast(&scene, &views);
            let mut rows = Vec::new();
            let mut columns = Vec::new();
            for (image, eye) in images.iter().zip([eyes.left, eyes.right]) {
                let found = centroid(image).expect("the marker is in view");
                // By similar triangles: from the eye through the point to the glass.
                let on_glass = eye + (DVec3::new(x, y, z) - eye) * (eye.z / (eye.z - z));
                let wanted = DVec2::new(
                    (on_glass.x / GLASS[0] + 0.5) * 600.0,
                    (0.5 - on_glass.y / GLASS[1]) * 366.0,
                );
                // A dot of three centimetres is not a point: perspective moves its middle a little.
                assert!((found - wanted).length() < 0.25, "{found} is not {wanted}");
                rows.push(found.y);
                columns.push(found.x);
            }
            assert!(
                (rows[0] - rows[1]).abs() < 0.02,
                "vertical disparity: {rows:?}"
            );
            // Above the glass the left eye's image is further right; below, further left.
            let disparity = columns[0] - columns[1];
            match z {
                0.2 => assert!(disparity > 5.0, "{disparity}"),
                0.0 => assert!(disparity.abs() < 0.05, "{disparity}"),
                _ => assert!(disparity < -3.0, "{disparity}"),
            }
        }
    }
}

#[test]
fn points_on_the_glass_keep_their_pixel_for_a_thousand_heads() {
    let size = [90, 55];
    let placement = Placement {
        anchor: DVec3::new(15_000.0, 12_000.0, 40.0),
        yaw: 0.6,
        scale: 9000.0,
        exaggeration: 2.5,
    };
    let screen = Screen::horizontal(GLASS[0], GLASS[1]);
    let eyes = EyesInHead {
        middle: DVec3::new(0.02, 0.05, -0.03),
        rightwards: DVec3::X,
        interpupillary: 0.065,
    };
    let table = DVec3::new(0.25, -0.1, 0.0);
    let world = placement.world_from_table(table);
    let marker = Marker {
        at: world.truncate(),
        radius: 600.0,
    };
    let scene = marked_plane(DVec2::new(30_000.0, 24_000.0), world.z, marker);
    let pixel = DVec2::new((0.25 / 1.8 + 0.5) * 90.0, (0.5 + 0.1 / 1.1) * 55.0);
    let mut random = Random(1);
    let mut views = Vec::new();
    while views.len() < 2000 {
        let head = random.head();
        let pair = StereoPair::<View>::on_table(eyes.on_table(&head), &screen, &placement, size);
        views.extend(pair.into_array());
    }
    for view in &views {
        assert!((view.pixel_of(world).unwrap() - pixel).length() < 1e-6);
    }
    for (k, image) in cast(&scene, &views).iter().enumerate() {
        let found = centroid(image).expect("the marker is in view");
        assert!(
            (found - pixel).length() < 0.1,
            "head {}: {found} is not {pixel}",
            k / 2
        );
    }
}

#[test]
fn an_upright_pair_meets_on_its_screen_and_has_no_vertical_disparity() {
    let camera = Camera {
        eye: DVec3::new(3200.0, -150.0, 2400.0),
        attitude: Attitude {
            yaw: 0.4,
            pitch: -0.5,
            roll: 0.0,
        },
        horizontal_fov: 60f64.to_radians(),
    };
    let stereo = Stereo {
        separation: 65.0,
        screen_distance: 2000.0,
    };
    let pair = camera.stereo_views(stereo, [1920, 1080]);
    let [right, up, forward] = camera.attitude.axes();
    let mut random = Random(7);
    for _ in 0..1000 {
        let depth = random.between(500.0, 9000.0);
        let (x, y) = (
            random.between(-0.4, 0.4) * depth,
            random.between(-0.25, 0.25) * depth,
        );
        let point = camera.eye + depth * forward + x * right + y * up;
        let (l, r) = (
            pair.left.pixel_of(point).unwrap(),
            pair.right.pixel_of(point).unwrap(),
        );
        assert!((l.y - r.y).abs() < 1e-6);
        // Disparity on the screen is separation · (1 − screen / depth), uncrossed positive; a
        // screen 2 · 2000 · tan 30° wide has 1920 columns.
        let per_metre = 1920.0 / (2.0 * 2000.0 * 30f64.to_radians().tan());
        let wanted = 65.0 * (1.0 - 2000.0 / depth) * per_metre;
        assert!((r.x - l.x - wanted).abs() < 1e-6);
    }
}

#[test]
fn a_tilted_head_lifts_one_eye() {
    let eyes = EyesInHead {
        middle: DVec3::ZERO,
        rightwards: DVec3::X,
        interpupillary: 0.06,
    };
    // Right ear down by 30°, about the direction of sight.
    let head = Rigid::new(
        DQuat::from_rotation_y(30f64.to_radians()),
        DVec3::new(0.0, -0.9, 0.6),
    );
    let pair = eyes.on_table(&head);
    assert!((pair.left.z - pair.right.z - 0.06 * 0.5).abs() < 1e-12);
    assert!((pair.left.distance(pair.right) - 0.06).abs() < 1e-12);
}

#[test]
fn mirrored_input_gives_mirrored_images_with_the_eyes_exchanged() {
    let (cols, rows) = (129, 97);
    let height = |col: u32, row: u32| {
        let (x, y) = (f64::from(col), f64::from(row));
        (9.0 * (0.11 * x).sin() * (0.07 * y + 0.3).cos() + 4.0 * (0.31 * x + 0.2 * y).sin()) as f32
    };
    let texel = |col: u32, row: u32| [(col * 2 % 256) as u8, (row * 3 % 256) as u8, 90, 255];
    let scene = |mirrored: bool| {
        let source = move |col: u32| if mirrored { cols - 1 - col } else { col };
        let ground =
            Ground::from_fn(cols, rows, DVec2::ONE, |col, row| height(source(col), row)).unwrap();
        let pixels = TiledRaster::from_fn(cols, rows, |col, row| texel(source(col), row));
        let photo = Photo {
            pixels,
            origin: DVec2::ZERO,
            spacing: DVec2::ONE,
        };
        Scene::new(ground.with_photo(photo))
    };
    let middle = f64::from(cols - 1) / 2.0;
    let placement = Placement {
        anchor: DVec3::new(middle, 48.0, 0.0),
        yaw: 0.0,
        scale: 64.0,
        exaggeration: 1.0,
    };
    let screen = Screen::horizontal(GLASS[0], GLASS[1]);
    let eyes = StereoPair {
        left: DVec3::new(0.17, -0.8, 0.6),
        right: DVec3::new(0.23, -0.8, 0.63),
    };
    let size = [220, 134];
    let views = |eyes| StereoPair::<View>::on_table(eyes, &screen, &placement, size).into_array();
    let flip = |eye: DVec3| eye.with_x(-eye.x);
    let straight = cast(&scene(false), &views(eyes));
    let mirrored = cast(&scene(true), &views(eyes.map(flip).swapped()));
    for (image, mirror) in [(&straight[0], &mirrored[1]), (&straight[1], &mirrored[0])] {
        let mut differing = 0;
        let mut ground = 0;
        for j in 0..size[1] {
            for i in 0..size[0] {
                let at = (j * size[0] + i) as usize;
                let opposite = (j * size[0] + size[0] - 1 - i) as usize;
                let (a, b) = (image.depth[at], mirror.depth[opposite]);
                let same_depth = a == b || (a - b).abs() < 1e-4 * a;
                let same_colour = (0..3)
                    .all(|k| image.colour()[at][k].abs_diff(mirror.colour()[opposite][k]) <= 1);
                differing += u32::from(!(same_depth && same_colour));
                ground += u32::from(a.is_finite());
            }
        }
        // A ray that grazes an edge may fall on either side of it.
        assert!(
            ground > 10_000 && differing <= 3,
            "{differing} of {ground} pixels differ"
        );
    }
}
