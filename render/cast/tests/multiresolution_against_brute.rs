//! Multiresolution casting: how far from brute force, and how steady in flight.

use glam::{DVec2, DVec3};
use sandtable_cast::{Brute, CastPool, Image, PreparedScene, Scene, caster_by_name, standpoints};
use sandtable_terrain::Ground;
use sandtable_view::{Attitude, Camera, Screen, View};
use std::sync::Arc;

fn ridges(size: u32) -> Arc<Scene> {
    let source = format!("builtin:ridges?size={size}&seed=5").parse();
    let terrain = sandtable_terrain::open(&source.expect("a source"), None);
    Scene::new(terrain.expect("built in").ground)
}

fn prepared(name: &str, scene: &Arc<Scene>) -> Arc<dyn PreparedScene> {
    let caster = caster_by_name(name).expect("a caster");
    caster.prepare(Arc::clone(scene)).expect("it suits")
}

fn cast(scene: &dyn PreparedScene, view: View) -> Image {
    let mut images = [Image::default()];
    let pool = CastPool::new(2).expect("threads");
    pool.cast(scene, &[view], &mut images).expect("accepted");
    let [image] = images;
    image
}

fn brute(scene: &Arc<Scene>, view: View) -> Image {
    let pool = CastPool::new(2).expect("threads");
    pool.picture(&Brute, scene, view).expect("any view will do")
}

fn camera(eye: DVec3, yaw: f64, pitch: f64, fov: f64, size: [u32; 2]) -> View {
    let attitude = Attitude {
        yaw: yaw.to_radians(),
        pitch: pitch.to_radians(),
        roll: 0.0,
    };
    Camera {
        eye,
        attitude,
        horizontal_fov: fov.to_radians(),
    }
    .view(size)
}

/// How far along the ground, in cells, each hit lies from brute force's, sorted.
fn cells_off(image: &Image, exact: &Image, cell: f64) -> Vec<f64> {
    let mut off = Vec::new();
    for j in 0..image.height() {
        for i in 0..image.width() {
            off.push(match (image.point(i, j), exact.point(i, j)) {
                (Some(a), Some(b)) => (a - b).truncate().length() / cell,
                (None, None) => 0.0,
                _ => f64::INFINITY,
            });
        }
    }
    off.sort_by(f64::total_cmp);
    off
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

#[test]
fn hits_lie_within_a_step_behind_the_surface() {
    let scene = ridges(257);
    let cell = scene.ground.grid().cell_length();
    let extent = scene.ground.grid().extent();
    let high = f64::from(scene.ground.range()[1]);
    // Near enough that all of the ground is seen at its own resolution, in all directions.
    let caster = prepared("multiresolution?rays=1&scale=0.25&blend=off", &scene);
    for (yaw, pitch) in [
        (0.0, -40.0),
        (40.0, -30.0),
        (135.0, -40.0),
        (250.0, -60.0),
        (300.0, -89.0),
    ] {
        let eye = DVec3::new(0.5 * extent.x, 0.5 * extent.y, high + 4.0 * cell);
        let view = camera(eye, yaw, pitch, 30.0, [240, 180]);
        let off = cells_off(&cast(&*caster, view), &brute(&scene, view), cell);
        let [half, most] = [0.5, 0.99].map(|share| quantile(&off, share));
        println!("yaw {yaw}, pitch {pitch}: median {half:.2} cells off, 99 % within {most:.2}");
        // A ray goes up to √2 cells from line to line.
        assert!(half < 0.9 && most < 1.6, "{half}, {most}");
    }
}

#[test]
fn a_long_run_keeps_to_its_ray() {
    // From the edge of a cliff, over a plane that rises to the side: whoever strays sideways by a
    // post lands a cell too early or too late.
    let ground = Ground::from_fn(320, 301, DVec2::ONE, |col, row| {
        if col <= 10 { 100.0 } else { 0.2 * row as f32 }
    });
    let scene = Scene::new(ground.expect("sound"));
    let eye = DVec3::new(10.5, 150.0, 101.0);
    let window = |corner: [f64; 3]| eye + DVec3::from(corner);
    // The rows below end on the cliff, and this one's rays run some 150 cells from there.
    let row = 1;
    let view = View {
        eye,
        window: Screen {
            lower_left: window([1.0, 0.4, -8.0]),
            lower_right: window([1.0, -0.4, -8.0]),
            upper_left: window([1.0, 0.4, 2.0]),
        },
        size: [201, 6],
    };
    let caster = prepared("multiresolution?rays=1&scale=0.25&blend=off", &scene);
    let (image, exact) = (cast(&*caster, view), brute(&scene, view));
    for i in 0..image.width() {
        let hits = [&image, &exact].map(|image| image.point(i, row).expect("a hit") - eye);
        let [found, wanted] = hits.map(|hit| hit.x);
        assert!(wanted > 110.0, "column {i} ends at {wanted}");
        let late = found - wanted;
        assert!((-0.001..1.001).contains(&late), "column {i}: {late}");
    }
}

#[test]
fn a_table_and_wide_views_stay_near_brute_force() {
    let scene = ridges(257);
    let extent = scene.ground.grid().extent();
    let high = f64::from(scene.ground.range()[1]);
    let caster = prepared("multiresolution", &scene);
    let eye = DVec3::new(0.03 * extent.x, 0.5 * extent.y, high + 0.08 * extent.x);
    let table = standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.75, 0.6), [240, 146]);
    for (name, view, least) in [
        ("pitched", camera(eye, 90.0, -30.0, 60.0, [250, 200]), 28.0),
        ("horizon", camera(eye, 90.0, -5.0, 60.0, [250, 200]), 28.0),
        ("table", table, 26.0),
    ] {
        let (image, exact) = (cast(&*caster, view), brute(&scene, view));
        let cell = scene.ground.grid().cell_length();
        let difference = sandtable_cast::Difference::between(&image, &exact, cell);
        let psnr = difference.psnr_db.expect("not identical");
        println!("{name}: {psnr:.1} dB");
        assert!(psnr > least, "{name}: {psnr} dB");
    }
}

#[test]
fn blended_levels_change_less_from_frame_to_frame() {
    let scene = ridges(513);
    let extent = scene.ground.grid().extent();
    let high = f64::from(scene.ground.range()[1]);
    let change = |name: &str| {
        let caster = prepared(name, &scene);
        let mut last: Option<Image> = None;
        let mut sum = 0.0;
        for frame in 0..24 {
            let forward = 0.25 * f64::from(frame) * scene.ground.grid().cell_length();
            let eye = DVec3::new(0.05 * extent.x + forward, 0.5 * extent.y, high);
            let image = cast(&*caster, camera(eye, 90.0, -15.0, 60.0, [160, 120]));
            if let Some(last) = &last {
                for (a, b) in image.colour().iter().zip(last.colour()) {
                    sum += (0..3).map(|k| f64::from(a[k].abs_diff(b[k]))).sum::<f64>();
                }
            }
            last = Some(image);
        }
        sum / (23.0 * 3.0 * 160.0 * 120.0)
    };
    let blended = change("multiresolution?rays=1");
    let unblended = change("multiresolution?rays=1&blend=off");
    let parallel = change("multiresolution?rays=4");
    println!(
        "mean change: blended {blended:.3}, unblended {unblended:.3}, four rays {parallel:.3}"
    );
    assert!(blended < unblended);
    assert!(parallel < blended);
}

#[test]
fn a_flat_ground_is_hit_at_its_height_at_every_level() {
    let ground = Ground::from_fn(400, 300, DVec2::new(2.0, 3.0), |_, _| 7.0).expect("sound");
    let scene = Scene::new(ground);
    for name in ["multiresolution", "multiresolution?scale=4&rays=3"] {
        let caster = prepared(name, &scene);
        let view = camera(DVec3::new(30.0, 400.0, 60.0), 80.0, -20.0, 50.0, [90, 70]);
        let (image, exact) = (cast(&*caster, view), brute(&scene, view));
        for (j, (row, wanted)) in image
            .depth
            .chunks(90)
            .zip(exact.depth.chunks(90))
            .enumerate()
        {
            for (found, wanted) in row.iter().zip(wanted) {
                // Behind it by one step at most, and a step spans about one pixel's footprint.
                let late = f64::from(found - wanted);
                let step = 2.0f64.max(f64::from(*wanted) * 0.02) * 4.5;
                let both_sky = found == wanted;
                assert!(
                    both_sky || (-0.2 * step..step).contains(&late),
                    "{name} {j}: {late}"
                );
            }
        }
    }
}

#[test]
fn rolled_views_are_refused() {
    let scene = ridges(129);
    let caster = prepared("multiresolution", &scene);
    let mut camera = Camera {
        eye: DVec3::new(100.0, 100.0, 5000.0),
        attitude: Attitude::default(),
        horizontal_fov: 1.0,
    };
    camera.attitude.roll = 0.3;
    let error = caster.work(&camera.view([40, 30])).unwrap_err();
    assert!(error.to_string().contains("rise by"), "{error}");
}
