//! The coherent caster against brute force, on made-up and on real terrain.

use glam::DVec3;
use sandtable_cast::{Brute, CastPool, Caster, Coherent, Difference, Image, Scene, standpoints};
use sandtable_terrain::{Ground, TerrainSource};
use sandtable_tests::data_file;
use sandtable_view::{Attitude, Camera, View};
use std::sync::Arc;

const SIZE: [u32; 2] = [640, 360];

/// Views for which columns are not vertical planes (rolled, straight down, at a table), with the
/// share of wrong pixels from which on something has collapsed.
fn other_views(ground: &Ground) -> Vec<(&'static str, f64, View)> {
    let extent = ground.grid().extent();
    let top = f64::from(ground.range()[1]);
    let middle = DVec3::new(0.5 * extent.x, 0.2 * extent.y, top);
    let camera = |pitch: f64, roll: f64| {
        let attitude = Attitude {
            yaw: 0.3,
            pitch: pitch.to_radians(),
            roll: roll.to_radians(),
        };
        Camera {
            eye: middle,
            attitude,
            horizontal_fov: 60f64.to_radians(),
        }
        .view(SIZE)
    };
    let table = |eye| standpoints::at_table(ground, eye, SIZE);
    vec![
        ("roll 10°", 0.005, camera(-15.0, 10.0)),
        ("roll 45°", 0.005, camera(-15.0, 45.0)),
        ("roll 90°", 0.05, camera(-15.0, 90.0)),
        ("upside down", 0.005, camera(-15.0, 180.0)),
        ("straight down", 0.005, camera(-90.0, 0.0)),
        ("table", 0.005, table(DVec3::new(0.1, -0.95, 0.62))),
        (
            "table, leaning over",
            0.25,
            table(DVec3::new(-0.3, -0.2, 0.5)),
        ),
    ]
}

fn cast(caster: &dyn Caster, scene: &Arc<Scene>, views: &[View]) -> Vec<Image> {
    let mut images = vec![Image::default(); views.len()];
    let pool = CastPool::new(0).expect("threads");
    let prepared = caster.prepare(Arc::clone(scene)).expect("no options");
    pool.cast(&*prepared, views, &mut images)
        .expect("any view will do");
    images
}

fn differences(scene: &Arc<Scene>, views: &[View]) -> Vec<Difference> {
    let cell = scene.ground.grid().cell_length();
    let (exact, found) = (cast(&Brute, scene, views), cast(&Coherent, scene, views));
    found
        .iter()
        .zip(&exact)
        .map(|(found, exact)| Difference::between(found, exact, cell))
        .collect()
}

fn compare(source: &str) {
    let source: TerrainSource = source.parse().expect("a terrain's name");
    let terrain = sandtable_terrain::open(&source, None).expect("the terrain opens");
    let scene = Scene::new(terrain.ground);
    let pixels = f64::from(SIZE[0] * SIZE[1]);
    let views: Vec<_> = standpoints::level(&scene.ground, SIZE)
        .into_iter()
        .map(|at| at.view)
        .collect();
    for (k, difference) in differences(&scene, &views).iter().enumerate() {
        let share = difference.over_half_cell as f64 / pixels;
        assert!(
            share < 1e-3,
            "{source}, level view {k}: {:.3} % are wrong",
            100.0 * share
        );
    }
    // Reported as they are; only a collapse fails.
    let others = other_views(&scene.ground);
    let views: Vec<_> = others.iter().map(|(.., view)| *view).collect();
    for ((name, bound, _), difference) in others.iter().zip(differences(&scene, &views)) {
        let share = difference.over_half_cell as f64 / pixels;
        println!("{source}, {name}: {:.3} % over half a cell", 100.0 * share);
        assert!(
            share < *bound,
            "{source}, {name}: {:.1} % are wrong",
            100.0 * share
        );
    }
}

fn compare_file(name: &str) {
    if let Some(path) = data_file(name) {
        compare(&path.display().to_string());
    }
}

#[test]
fn on_ridges() {
    compare("builtin:ridges?size=1025");
}

#[test]
fn on_the_pyrenees() {
    compare_file("pyrenees/N42E001.hgt");
}

#[test]
fn on_the_ruby_range() {
    compare_file("ruby-range/ruby_range_10m_nad83_cog.tif");
}

#[test]
fn on_mount_st_helens() {
    compare_file("st-helens/sthelens_30m_utm10.tif");
}
