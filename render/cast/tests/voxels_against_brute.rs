//! Casters of voxels: how far they are from brute force, and from one another.

use glam::DVec3;
use sandtable_cast::{
    Brute, CastError, CastPool, Difference, Image, Scene, caster_by_name, standpoints,
};
use sandtable_view::{Attitude, Camera, View};
use std::sync::Arc;

fn ridges() -> Arc<Scene> {
    let source = "builtin:ridges?size=257&seed=3".parse().expect("a source");
    Scene::new(
        sandtable_terrain::open(&source, None)
            .expect("built in")
            .ground,
    )
}

fn cast(name: &str, scene: &Arc<Scene>, view: View) -> Image {
    let pool = CastPool::new(2).expect("threads");
    let caster = caster_by_name(name).expect("a caster");
    pool.picture(&*caster, scene, view)
        .expect("any view will do")
}

fn brute(scene: &Arc<Scene>, view: View) -> Image {
    let pool = CastPool::new(2).expect("threads");
    pool.picture(&Brute, scene, view).expect("any view will do")
}

/// The paper's view: 30 degrees down, to the east.
fn pitched(scene: &Scene, roll: f64, size: [u32; 2]) -> View {
    let extent = scene.ground.grid().extent();
    let above = f64::from(scene.ground.range()[1]) + 0.08 * extent.x;
    let attitude = Attitude {
        yaw: 90f64.to_radians(),
        pitch: -30f64.to_radians(),
        roll: roll.to_radians(),
    };
    Camera {
        eye: DVec3::new(0.03 * extent.x, 0.5 * extent.y, above),
        attitude,
        horizontal_fov: 60f64.to_radians(),
    }
    .view(size)
}

/// The share of pixels whose depth differs by more than `cells`.
fn share_over(image: &Image, other: &Image, cell: f64, cells: f64) -> f64 {
    let pairs = image.depth.iter().zip(&other.depth);
    let over = pairs.filter(|(a, b)| a != b && f64::from((*a - *b).abs()) > cells * cell);
    over.count() as f64 / image.depth.len() as f64
}

#[test]
fn volume_ends_within_an_interval_of_the_surface() {
    let scene = ridges();
    let cell = scene.ground.grid().cell_length();
    let view = pitched(&scene, 0.0, [250, 200]);
    let (image, exact) = (cast("volume", &scene, view), brute(&scene, view));
    let difference = Difference::between(&image, &exact, cell);
    let psnr = difference.psnr_db.expect("not identical");
    // An interval is 0.6 cells, and the filter's surface is the ground's to a fraction of a voxel
    // but on its sharpest ridges.
    let over = share_over(&image, &exact, cell, 0.7);
    println!("volume: {psnr:.1} dB, {:.2} % over 0.7 cells", 100.0 * over);
    assert!(over < 0.03 && psnr > 33.0, "{over}, {psnr} dB");
    // A finer interval is nearer.
    let fine = cast("volume?interval=0.1", &scene, view);
    assert!(share_over(&fine, &exact, cell, 0.3) < 0.05);
}

#[test]
fn coherence_finds_what_each_ray_alone_finds() {
    let scene = ridges();
    let cell = scene.ground.grid().cell_length();
    let view = pitched(&scene, 0.0, [250, 200]);
    let alone = cast("conventional", &scene, view);
    let coherent = cast("volume", &scene, view);
    let lost = share_over(&coherent, &alone, cell, 0.01);
    println!("level: {:.3} % of pixels lost to coherence", 100.0 * lost);
    assert!(lost < 0.002, "{lost}");
    // At no roll lines are columns; under roll only lines that follow it keep coherence sound.
    assert!(cast("roll-lines", &scene, view) == coherent);
    for roll in [20.0, 45.0, 70.0, 90.0, 160.0, -45.0] {
        let view = pitched(&scene, roll, [250, 200]);
        let alone = cast("conventional", &scene, view);
        let lines = cast("roll-lines", &scene, view);
        let columns = cast("volume", &scene, view);
        let lost = |image: &Image| share_over(image, &alone, cell, 0.01);
        let [lines, columns] = [lost(&lines), lost(&columns)];
        println!(
            "roll {roll}: {:.3} % lost along lines, {:.3} % along columns",
            100.0 * lines,
            100.0 * columns
        );
        assert!(lines < 0.003, "{roll}: {lines}");
        assert!(lines < columns || columns < 0.001, "{roll}");
    }
}

#[test]
fn where_sampling_starts_in_the_air_does_not_matter() {
    let scene = ridges();
    for view in [
        pitched(&scene, 30.0, [125, 100]),
        // With the eye beside the terrain.
        standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.9, 0.6), [100, 61]),
    ] {
        let [eye, volume] = ["eye", "volume"]
            .map(|start| cast(&format!("conventional?start={start}"), &scene, view));
        assert!(eye == volume);
    }
}

#[test]
fn a_boundary_cell_is_never_behind_the_surface_in_it() {
    let scene = ridges();
    let cell = scene.ground.grid().cell_length();
    for filter in ["box", "gaussian", "none"] {
        for view in [
            pitched(&scene, 0.0, [250, 200]),
            standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.75, 0.6), [200, 122]),
        ] {
            // Each ray alone sees the same samples.
            let volume = cast(&format!("conventional?filter={filter}"), &scene, view);
            let boundary = cast(&format!("boundary?filter={filter}"), &scene, view);
            let mut early = 0.0;
            let mut hits = 0;
            for (near, far) in boundary.depth.iter().zip(&volume.depth) {
                if far.is_finite() && near.is_finite() {
                    early += f64::from(far - near) / cell;
                    hits += 1;
                }
            }
            let behind = boundary.depth.iter().zip(&volume.depth);
            let behind = behind
                .filter(|(near, far)| **near > **far * 1.000_001)
                .count();
            let difference = Difference::between(&boundary, &volume, cell);
            println!(
                "{filter}: boundary ends {:.2} cells early on average, {:.1} dB from volume; \
                 {behind} pixels behind it",
                early / f64::from(hits),
                difference.psnr_db.expect("not identical")
            );
            // What coherence loses is the only way to be behind.
            assert!(
                behind as f64 <= 0.001 * boundary.depth.len() as f64,
                "{behind}"
            );
            assert!(early / f64::from(hits) > 0.2);
        }
    }
}

#[test]
fn an_antialiased_volume_is_nearest_to_the_supersampled_truth() {
    const TRUTH: u32 = 8;
    let scene = ridges();
    let size = [160, 128];
    let fine = brute(&scene, pitched(&scene, 0.0, size.map(|n| n * TRUTH)));
    let view = pitched(&scene, 0.0, size);
    let mut truth = Vec::new();
    for j in 0..size[1] {
        for i in 0..size[0] {
            let mut sum = [0.0; 3];
            for y in 0..TRUTH {
                for x in 0..TRUTH {
                    let at = (j * TRUTH + y) * size[0] * TRUTH + i * TRUTH + x;
                    let pixel = fine.colour()[at as usize];
                    sum = std::array::from_fn(|k| sum[k] + f64::from(pixel[k]));
                }
            }
            truth.push(sum.map(|sum| sum / f64::from(TRUTH * TRUTH)));
        }
    }
    let psnr = |name: &str| {
        let image = cast(name, &scene, view);
        let pairs = image.colour().iter().zip(&truth);
        let squares: f64 = pairs
            .map(|(pixel, truth)| -> f64 {
                let square = |k: usize| (f64::from(pixel[k]) - truth[k]).powi(2);
                (0..3).map(square).sum()
            })
            .sum();
        let mean = squares / (3 * truth.len()) as f64;
        10.0 * (255.0f64 * 255.0 / mean).log10()
    };
    let casters = [
        "volume",
        "volume?filter=none",
        "boundary",
        "inclined-corrected?posts=nearest",
    ];
    let [volume, binary, boundary, nearest] = casters.map(psnr);
    println!(
        "against the truth: volume {volume:.1} dB, binary {binary:.1}, boundary {boundary:.1}, \
         nearest posts {nearest:.1}"
    );
    assert!(volume > binary + 0.5 && volume > boundary + 2.0 && volume > nearest + 2.0);
}

#[test]
fn thresholds_move_the_surface_and_255_is_refused() {
    let scene = ridges();
    let view = pitched(&scene, 0.0, [120, 96]);
    let mean = |threshold: u32| {
        let image = cast(&format!("volume?threshold={threshold}"), &scene, view);
        let hits: Vec<_> = image.depth.iter().filter(|d| d.is_finite()).collect();
        hits.iter().map(|&&d| f64::from(d)).sum::<f64>() / hits.len() as f64
    };
    // The lower the threshold, the thicker the terrain.
    assert!(mean(0) < mean(127) && mean(127) < mean(254));
    for caster in ["volume", "boundary", "conventional", "roll-lines"] {
        let error = caster_by_name(&format!("{caster}?threshold=255")).map(|_| ());
        assert!(matches!(error, Err(CastError::BadValue { .. })), "{caster}");
    }
    let error = caster_by_name("volume?levels=7").map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("from 8 to 1024"), "{error}");
}
