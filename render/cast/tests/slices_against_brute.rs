//! The casters over terrain slices against brute force, each on the terrain and the windows that
//! its paper means it for.

use glam::{DVec2, DVec3};
use sandtable_cast::{
    Brute, CastPool, Caster, Difference, Image, Scene, Work, caster_by_name, standpoints,
};
use sandtable_terrain::{Ground, Photo, TiledRaster};
use sandtable_view::{Attitude, Camera, Stereo, View};
use std::sync::Arc;

const SIZE: [u32; 2] = [320, 200];

fn ridges() -> Arc<Scene> {
    let source = "builtin:ridges?size=257&seed=1".parse().expect("a terrain");
    Scene::new(
        sandtable_terrain::open(&source, None)
            .expect("it opens")
            .ground,
    )
}

/// Smooth hills, about 20 cells from top to top, on cells that are not square.
fn hills() -> Arc<Scene> {
    let spacing = DVec2::new(10.0, 8.0);
    let height = |col: u32, row: u32| {
        let (x, y) = (f64::from(col) * spacing.x, f64::from(row) * spacing.y);
        (30.0 * (x / 61.0).sin() * (y / 53.0).cos() + 10.0 * (x / 31.0 + y / 37.0).sin()) as f32
    };
    Scene::new(Ground::from_fn(260, 300, spacing, height).expect("a sound grid"))
}

fn scenes() -> [(&'static str, Arc<Scene>); 2] {
    [("ridges", ridges()), ("hills", hills())]
}

/// A camera that looks down by `down` degrees, `above` cells over the highest post.
fn camera(scene: &Scene, place: [f64; 2], above: f64, down: f64) -> Camera {
    let grid = scene.ground.grid();
    let at = DVec2::from(place) * grid.extent();
    let height = f64::from(scene.ground.range()[1]) + above * grid.cell_length();
    Camera {
        eye: at.extend(height),
        attitude: Attitude {
            yaw: 0.4,
            pitch: -down.to_radians(),
            roll: 0.0,
        },
        horizontal_fov: 60f64.to_radians(),
    }
}

/// The view through the window of `camera` from an eye beside it.
fn off_axis(scene: &Scene, camera: Camera) -> View {
    let stereo = Stereo {
        separation: 6.0 * scene.ground.grid().cell_length(),
        screen_distance: 10.0 * scene.ground.grid().cell_length(),
    };
    camera.stereo_views(stereo, SIZE).left
}

fn cast(caster: &dyn Caster, scene: &Arc<Scene>, view: View) -> Image {
    let pool = CastPool::new(2).expect("two threads");
    pool.picture(caster, scene, view)
        .expect("made for the view")
}

fn cast_by(name: &str, scene: &Arc<Scene>, view: View) -> Image {
    cast(&*caster_by_name(name).expect("a caster"), scene, view)
}

/// How far a caster's image is from the exact one.
#[derive(Debug)]
struct Error {
    /// Share of pixels whose hits lie farther apart along the ray than `STEPS` cells of ground, or
    /// of which one only is sky.
    wrong: f64,
    /// Mean distance along the ray in metres over metres of exact depth, where both hit.
    depth: f64,
    psnr: f64,
}

/// A slice's distance, for rays askew to the slices, and half a cell's diagonal for the post.
const STEPS: f64 = 1.75;

fn error(scene: &Scene, found: &Image, exact: &Image) -> Error {
    let cell = scene.ground.grid().cell_length();
    let (mut wrong, mut hits, mut depth) = (0, 0, 0.0);
    for j in 0..found.height() {
        for i in 0..found.width() {
            let direction = found.view.ray(i, j).direction;
            let level = direction.truncate().length() / direction.length();
            let at = (j * found.width() + i) as usize;
            let [found, exact] = [found, exact].map(|image| f64::from(image.depth[at]));
            if found == exact {
                continue;
            }
            let apart = (found - exact).abs();
            wrong += u32::from(apart * level > STEPS * cell);
            if apart.is_finite() {
                hits += 1;
                depth += apart / exact;
            }
        }
    }
    Error {
        wrong: f64::from(wrong) / f64::from(found.width() * found.height()),
        depth: depth / f64::from(hits),
        psnr: Difference::between(found, exact, cell)
            .psnr_db
            .unwrap_or(f64::INFINITY),
    }
}

fn compare(name: &str, scene: &Arc<Scene>, view: View) -> Error {
    error(
        scene,
        &cast_by(name, scene, view),
        &cast(&Brute, scene, view),
    )
}

/// An error's bounds: at most so many per cent of pixels wrong, at most so much off in depth in
/// per mille, at least so many dB.
type Bound = (f64, f64, f64);

/// Casts by `name`, with nearest and with bilinear posts.
fn assert_within(name: &str, what: &str, scene: &Arc<Scene>, view: View, bounds: [Bound; 2]) {
    for (posts, (wrong, depth, psnr)) in ["nearest", "bilinear"].into_iter().zip(bounds) {
        let error = compare(&format!("{name}?posts={posts}"), scene, view);
        assert!(
            100.0 * error.wrong <= wrong && 1000.0 * error.depth <= depth && error.psnr >= psnr,
            "{name}, {what}, {posts}: {error:?}"
        );
    }
}

#[test]
fn floating_horizon_is_planar_on_and_off_axis() {
    let bounds = [
        [
            [(0.6, 7.0, 34.0), (0.12, 5.3, 37.5)],
            [(0.9, 7.5, 30.7), (0.26, 6.2, 34.3)],
        ],
        [
            [(1.5, 18.0, 31.1), (0.12, 12.7, 35.1)],
            [(1.45, 18.0, 30.8), (0.14, 12.9, 34.0)],
        ],
    ];
    for ((terrain, scene), [on, off]) in scenes().iter().zip(bounds) {
        let camera = camera(scene, [0.3, 0.05], 5.0, 0.0);
        let check = |what, view, bounds| {
            let what = format!("{terrain}, {what}");
            assert_within("floating-horizon", &what, scene, view, bounds);
        };
        check("on axis", camera.view(SIZE), on);
        check("off axis", off_axis(scene, camera), off);
    }
}

#[test]
fn inclined_corrected_is_near_brute_at_any_inclination() {
    // In the latter two the point straight below the eye lies in the window, and rows march forward
    // and backward.
    let downs = [30.0, 60.0, 75.0, 90.0];
    let bounds = [
        [
            [(0.45, 2.65, 30.3), (0.18, 1.56, 32.4)],
            [(0.71, 2.5, 30.3), (0.23, 1.73, 32.6)],
        ],
        [
            [(0.19, 2.5, 30.4), (0.03, 1.75, 33.7)],
            [(0.06, 2.75, 32.1), (0.0, 2.2, 34.3)],
        ],
        [
            [(0.055, 2.8, 30.2), (0.009, 2.2, 33.1)],
            [(0.0, 2.95, 32.6), (0.0, 2.4, 34.7)],
        ],
        [
            [(0.3, 3.15, 26.7), (0.12, 2.35, 29.7)],
            [(0.0, 3.0, 33.1), (0.0, 2.4, 35.2)],
        ],
    ];
    for (down, by_terrain) in downs.into_iter().zip(bounds) {
        for ((terrain, scene), bounds) in scenes().iter().zip(by_terrain) {
            let camera = camera(scene, [0.5, 0.4], 60.0, down);
            for (axis, view) in [
                ("on axis", camera.view(SIZE)),
                ("off axis", off_axis(scene, camera)),
            ] {
                let what = format!("{terrain}, {down}° down, {axis}");
                assert_within("inclined-corrected", &what, scene, view, bounds);
            }
        }
    }
}

#[test]
fn inclined_corrected_casts_from_outside_at_a_table_and_upwards() {
    for ((terrain, scene), bounds) in scenes().iter().zip([
        [
            [(0.85, 2.45, 29.1), (0.24, 1.75, 32.3)],
            [(0.76, 3.65, 24.9), (0.46, 3.2, 27.0)],
            [(1.52, 2.6, 28.0), (1.25, 2.3, 29.0)],
            [(1.52, 66.5, 31.6), (0.24, 67.0, 35.2)],
        ],
        [
            [(0.7, 4.5, 30.4), (0.081, 3.77, 32.7)],
            [(0.57, 4.25, 30.9), (0.053, 3.7, 35.6)],
            [(0.245, 0.87, 32.4), (0.145, 0.65, 33.8)],
            [(0.72, 40.6, 33.2), (0.05, 38.5, 38.1)],
        ],
    ]) {
        let ground = &scene.ground;
        let turned = |place, yaw| {
            let mut camera = camera(scene, place, 40.0, 30.0);
            camera.attitude.yaw = yaw;
            camera.view(SIZE)
        };
        // From just above the ground up to beyond the zenith, where rows run backwards.
        let place = DVec2::splat(0.4) * ground.grid().extent();
        let floor = ground.height_at(place.x, place.y).expect("on the terrain");
        let mut upwards = camera(scene, [0.4, 0.4], 0.0, -30.0);
        upwards.eye.z = floor + 2.0 * ground.grid().cell_length();
        upwards.horizontal_fov = 1.9;
        let views = [
            ("from beyond a corner", turned([-0.1, -0.08], 0.9)),
            ("from beside a border", turned([0.7, -0.3], -0.6)),
            (
                "at a table",
                standpoints::at_table(ground, DVec3::new(0.1, -0.75, 0.6), SIZE),
            ),
            ("upwards", upwards.view(SIZE)),
        ];
        for ((what, view), bounds) in views.into_iter().zip(bounds) {
            let what = format!("{terrain}, {what}");
            assert_within("inclined-corrected", &what, scene, view, bounds);
        }
    }
}

#[test]
fn each_degree_of_care_brings_the_image_nearer_to_the_exact_one() {
    for (terrain, scene) in &scenes() {
        for down in [30.0, 60.0] {
            let view = camera(scene, [0.5, 0.4], 60.0, down).view(SIZE);
            let [naive, inclined, corrected] = INCLINED.map(|name| compare(name, scene, view));
            let text = format!("{terrain}, {down}°: {naive:?}, {inclined:?}, {corrected:?}");
            // The ridges are as high as the eye is above them: there the place on the base plane
            // is so far off that only colours tell `inclined` from naive.
            assert!(naive.psnr + 0.4 < inclined.psnr, "{text}");
            assert!(inclined.psnr + 3.0 < corrected.psnr, "{text}");
            assert!(inclined.wrong > 2.0 * corrected.wrong, "{text}");
            if *terrain == "hills" {
                assert!(naive.wrong > 5.0 * inclined.wrong, "{text}");
                assert!(naive.depth > 2.0 * inclined.depth, "{text}");
            }
        }
    }
}

const INCLINED: [&str; 3] = ["inclined-naive", "inclined", "inclined-corrected"];

#[test]
fn all_are_floating_horizon_where_the_window_is_upright() {
    for (terrain, scene) in &scenes() {
        let camera = camera(scene, [0.3, 0.05], 5.0, 0.0);
        for view in [camera.view(SIZE), off_axis(scene, camera)] {
            let upright = cast_by("floating-horizon", scene, view);
            for name in INCLINED {
                let found = cast_by(&format!("{name}?depth=slice"), scene, view);
                assert!(found == upright, "{terrain}, {name}");
            }
        }
    }
}

/// Flat ground in two colours, `paint` of post column and row, with a tower where `tower` says.
fn painted(tower: [u32; 2], paint: impl Fn(u32, u32) -> bool + Sync) -> Arc<Scene> {
    let spacing = DVec2::new(10.0, 8.0);
    let height = |col, row| if [col, row] == tower { 350.0 } else { 0.0 };
    let ground = Ground::from_fn(200, 250, spacing, height).expect("a sound grid");
    let pixel = |col, row| {
        if paint(col, row) {
            PAINT
        } else {
            [40, 40, 40, 255]
        }
    };
    Scene::new(ground.with_photo(Photo {
        pixels: TiledRaster::from_fn(200, 250, pixel),
        origin: DVec2::ZERO,
        spacing,
    }))
}

const PAINT: [u8; 4] = [255, 0, 0, 255];
const NOWHERE: [u32; 2] = [u32::MAX; 2];

/// The painted pixels of each row, as columns.
fn painted_columns(image: &Image) -> Vec<Vec<u32>> {
    let width = image.width() as usize;
    let columns = |row: &[[u8; 4]]| {
        (0..)
            .zip(row)
            .filter(|(_, p)| **p == PAINT)
            .map(|(i, _)| i)
            .collect()
    };
    image.colour().chunks(width).map(columns).collect()
}

#[test]
fn flat_ground_is_seen_as_it_is() {
    let scene = painted(NOWHERE, |col, row| (col / 8 + row / 10) % 2 == 0);
    for down in [30.0, 60.0, 75.0, 90.0] {
        let camera = camera(&scene, [0.5, 0.4], 40.0, down);
        for view in [camera.view(SIZE), off_axis(&scene, camera)] {
            let exact = cast(&Brute, &scene, view);
            for name in ["inclined", "inclined-corrected"] {
                let found = cast_by(name, &scene, view);
                let Error { wrong, depth, psnr } = error(&scene, &found, &exact);
                let text = format!("{name}, {down}°: {wrong}, {depth}, {psnr}");
                // What is wrong lies beyond the last slice before the border.
                assert!(wrong < 2e-3 && depth < 1e-6 && psnr > 19.0, "{text}");
            }
        }
    }
}

#[test]
fn naive_is_right_in_the_row_of_the_normals_foot_only() {
    let scene = painted(NOWHERE, |col, row| (col / 8 + row / 10) % 2 == 0);
    for down in [30.0, 60.0] {
        let view = camera(&scene, [0.5, 0.4], 40.0, down).view(SIZE);
        let naive = cast_by("inclined-naive?posts=bilinear&step=0.1", &scene, view);
        let exact = cast(&Brute, &scene, view);
        // The normal's foot is the window's middle, between rows 99 and 100.
        let share = |row: usize| {
            let row = row * SIZE[0] as usize..(row + 1) * SIZE[0] as usize;
            let pixels = naive.colour()[row.clone()].iter().zip(&exact.colour()[row]);
            let alike = pixels.filter(|(a, b)| a[0].abs_diff(b[0]) < 32);
            alike.count() as f64 / f64::from(SIZE[0])
        };
        let shares = [share(99), share(100), share(160), share(40)];
        assert!(shares[0].min(shares[1]) > 0.95, "{down}°: {shares:?}");
        assert!(shares[2].max(shares[3]) < 0.85, "{down}°: {shares:?}");
    }
}

#[test]
fn a_straight_road_stays_straight() {
    // A road from south to north, three posts wide, whose middle is post column 120.
    let scene = painted(NOWHERE, |col, _| col.abs_diff(120) <= 1);
    let camera = camera(&scene, [0.5, 0.02], 6.0, 0.0);
    for view in [camera.view(SIZE), off_axis(&scene, camera)] {
        let pixel = |y: f64| view.pixel_of(DVec3::new(1200.0, y, 0.0)).expect("ahead");
        let (near, far) = (pixel(200.0), pixel(1900.0));
        let image = cast_by("floating-horizon?posts=bilinear&step=0.1", &scene, view);
        let mut rows = 0;
        for (row, columns) in painted_columns(&image).iter().enumerate() {
            let y = row as f64 + 0.5;
            if columns.is_empty() || columns.contains(&0) || columns.contains(&(SIZE[0] - 1)) {
                continue;
            }
            let middle = f64::from(columns[0] + columns[columns.len() - 1] + 1) / 2.0;
            let line = near.x + (far.x - near.x) * (y - near.y) / (far.y - near.y);
            assert!(
                (middle - line).abs() < 1.5,
                "row {row}: {middle}, not {line}"
            );
            rows += 1;
        }
        assert!(rows > 20, "the road is seen in {rows} rows");
    }
}

#[test]
fn vertical_lines_stay_in_their_pixel_columns_without_correction() {
    let tower = [122, 120];
    let scene = painted(tower, |col, row| [col, row] == tower);
    let mut camera = camera(&scene, [0.5, 0.4], 0.0, 60.0);
    camera.eye.z = 500.0;
    camera.attitude.yaw = 0.0;
    let view = camera.view(SIZE);
    let foot = view.pixel_of(DVec3::new(1220.0, 960.0, 0.0));
    let foot = foot.expect("before the eye").x as u32;
    let image = cast_by("inclined", &scene, view);
    let rows: Vec<_> = painted_columns(&image)
        .into_iter()
        .filter(|columns| !columns.is_empty())
        .collect();
    assert!(rows.len() > 120, "it is seen in {} rows", rows.len());
    for columns in &rows {
        assert!(
            columns == &rows[0] && columns.contains(&foot),
            "{columns:?}"
        );
    }
}

#[test]
fn an_eye_inside_the_terrain_hits_at_once() {
    let scene = hills();
    for (name, down) in [
        ("floating-horizon", 0.0),
        ("inclined-naive", 30.0),
        ("inclined", 90.0),
        ("inclined-corrected", 90.0),
    ] {
        let mut camera = camera(&scene, [0.5, 0.5], 0.0, down);
        camera.eye.z = f64::from(scene.ground.range()[0]) - 20.0;
        let image = cast_by(name, &scene, camera.view(SIZE));
        assert!(image.depth.iter().all(|&depth| depth == 0.0), "{name}");
    }
}

#[test]
fn options_change_what_they_say() {
    let scene = hills();
    for (name, down) in [
        ("floating-horizon", 0.0),
        ("inclined", 60.0),
        ("inclined-corrected", 60.0),
    ] {
        let view = camera(&scene, [0.3, 0.05], 5.0, down).view(SIZE);
        let by_default = cast_by(name, &scene, view);
        let flat = cast_by(&format!("{name}?depth=off"), &scene, view);
        assert!(flat.colour() == by_default.colour(), "{name}");
        assert!(flat.depth.iter().all(|&depth| depth == f32::INFINITY));
        let work = |options: &str| {
            let caster = caster_by_name(&format!("{name}?{options}")).expect("an option");
            let prepared = caster.prepare(Arc::clone(&scene)).expect("any scene");
            prepared.work(&view).expect("made for the view")
        };
        let (nearest, bilinear, fine) = (work(""), work("posts=bilinear"), work("step=0.25"));
        assert_eq!(nearest.rays, u64::from(SIZE[0] * SIZE[1]));
        assert_eq!((nearest.cells, bilinear.cells), (0, bilinear.samples));
        // The corrected place is looked up anew for each pixel, whatever the step.
        let steps = |work: Work| match name {
            "inclined-corrected" => work.samples - work.rays,
            _ => work.samples,
        };
        assert!(
            steps(fine) > 3 * steps(nearest),
            "{name}: {fine:?}, {nearest:?}"
        );
    }
    for options in ["step=0", "step=nan", "posts=far", "depth=metres"] {
        for name in ["floating-horizon", INCLINED[0], INCLINED[1], INCLINED[2]] {
            assert!(
                caster_by_name(&format!("{name}?{options}")).is_err(),
                "{name}?{options}"
            );
        }
    }
}

#[test]
fn views_that_a_caster_is_not_made_for_are_refused_with_a_remedy() {
    let scene = hills();
    let refusal = |name: &str, pitch: f64, roll: f64| {
        let mut camera = camera(&scene, [0.5, 0.5], 5.0, -pitch);
        camera.attitude.roll = roll;
        let pool = CastPool::new(1).expect("a thread");
        let caster = caster_by_name(name).expect("a caster");
        pool.picture(&*caster, &scene, camera.view(SIZE))
            .expect_err("not made for it")
            .to_string()
    };
    assert_eq!(
        refusal("floating-horizon", -30.0, 0.0),
        "floating-horizon cannot cast this view: the window leans by 30.0° from the vertical: use \
         inclined-corrected"
    );
    let rolled = refusal("inclined", -30.0, 0.5);
    assert!(
        rolled.starts_with("inclined cannot cast this view: its pixel rows rise by -24.5°"),
        "{rolled}"
    );
    assert!(rolled.ends_with("use roll-lines or coherent"), "{rolled}");
    let flat = refusal("inclined-naive", -90.0, 0.0);
    assert!(
        flat.contains("leans by 90.0°") && flat.ends_with("use inclined-corrected"),
        "{flat}"
    );
    let back = refusal("inclined-naive", -75.0, 0.0);
    assert!(
        back.contains("26 of its 200 pixel rows look behind the eye"),
        "{back}"
    );
}
