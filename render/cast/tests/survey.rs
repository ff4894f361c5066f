//! What the pictures of the default caster show.

mod gorges;
mod town;

use self::gorges::{from_afar, gorges};
use self::town::{OVER_ROOFS, town};
use glam::{DVec2, DVec3};
use sandtable_cast::{CastPool, Scene, Survey, caster_by_name, standpoints};
use sandtable_terrain::{Ground, TerrainSource, open};
use sandtable_view::{Attitude, Camera, View};
use std::error::Error;

#[test]
fn each_look_at_the_ground_belongs_to_a_pixel() -> Result<(), Box<dyn Error>> {
    let ground = open(&TerrainSource::Ridges { size: 257, seed: 0 }, None)?.ground;
    let scene = Scene::new(ground);
    let pool = CastPool::new(2)?;
    let caster = caster_by_name("planes")?;
    for at in standpoints::mixed(&scene.ground) {
        let mut view = at.view;
        view.size = [317, 181];
        let survey = Survey::of(&scene, &view).expect("an eye in the air");
        let image = pool.picture(&*caster, &scene, view)?;
        assert!(survey.image == image, "{}: another image", at.name);
        let prepared = pool.run(|| caster.prepare(scene.clone()))?;
        let work = prepared.work(&view)?;
        let looks: u64 = survey.looks.iter().map(|&looks| u64::from(looks)).sum();
        assert_eq!(looks, work.cells, "{}", at.name);
        assert_eq!(work.rays, 317 * 181, "{}", at.name);
        for (looks, depth) in survey.looks.iter().zip(&image.depth) {
            assert!(
                *looks > 0 || depth.is_infinite(),
                "{}: a hit unseen",
                at.name
            );
        }
    }
    Ok(())
}

#[test]
fn most_rays_begin_from_a_ray_before() -> Result<(), Box<dyn Error>> {
    let ground = open(&TerrainSource::Ridges { size: 257, seed: 0 }, None)?.ground;
    let scene = Scene::new(ground);
    let view = standpoints::at_table(&scene.ground, DVec3::new(0.0, -0.75, 0.6), [320, 196]);
    let survey = Survey::of(&scene, &view).expect("an eye in the air");
    assert!(survey.begins.iter().all(|&steps| steps <= 7));
    let alone = survey.begins.iter().filter(|&&steps| steps == 0).count();
    let pixels = survey.begins.len();
    assert!(alone > 0 && alone < pixels / 4, "{alone} of {pixels}");
    Ok(())
}

/// Where pixels are much smaller than cells, rays meet the ground in their predecessors' cells; who
/// had to look for their own would look at theirs and then at the next.
#[test]
fn rays_close_by_look_at_little_more_than_their_own_cell() -> Result<(), Box<dyn Error>> {
    let ground = open(&TerrainSource::Ridges { size: 65, seed: 0 }, None)?.ground;
    let scene = Scene::new(ground);
    let at = standpoints::mixed(&scene.ground)
        .into_iter()
        .find(|at| at.name == "pitched")
        .ok_or("a view of that name")?;
    let mut view = at.view;
    view.size = [1280, 720];
    let pool = CastPool::new(2)?;
    let caster = caster_by_name("planes")?;
    let prepared = pool.run(|| caster.prepare(scene.clone()))?;
    let image = pool.picture(&*caster, &scene, view)?;
    let hits = image.depth.iter().filter(|depth| depth.is_finite()).count();
    let cells = prepared.work(&view)?.cells as f64 / hits as f64;
    // 1.150; 1.186 where no ray takes a patch over.
    assert!(cells < 1.17, "{cells} cells a hit");
    Ok(())
}

/// Straight down, where pixels are about as wide as cells, rays are known to be clear for most of their way.
#[test]
fn straight_down_rays_begin_close_to_where_they_end() -> Result<(), Box<dyn Error>> {
    let ground = open(&TerrainSource::Ridges { size: 513, seed: 0 }, None)?.ground;
    let [east, north] = ground.grid().extent().to_array();
    let camera = Camera {
        eye: DVec3::new(
            0.5 * east,
            0.5 * north,
            f64::from(ground.range()[1]) + 0.3 * east,
        ),
        attitude: Attitude {
            pitch: -std::f64::consts::FRAC_PI_2,
            roll: 0.3,
            ..Attitude::default()
        },
        horizontal_fov: 1.2,
    };
    let looks = looks(ground, camera.view([640, 400]))?;
    // 1.59; 1.70 where they begin where those before them ended.
    assert!(looks < 1.65, "{looks} looks a ray");
    Ok(())
}

/// How many cells and blocks a ray looks at on average.
fn looks(ground: Ground, view: View) -> Result<f64, Box<dyn Error>> {
    let scene = Scene::new(ground);
    let pool = CastPool::new(2)?;
    let caster = caster_by_name("planes")?;
    let prepared = pool.run(|| caster.prepare(scene))?;
    let pixels = view.size[0] * view.size[1];
    Ok(prepared.work(&view)?.cells as f64 / f64::from(pixels))
}

/// Walls might come between a ray and any one before it; but not between it and both of those around it unseen.
#[test]
fn among_houses_rays_begin_from_those_around_them() -> Result<(), Box<dyn Error>> {
    for roll in [0.0, 0.4, 0.785] {
        let attitude = Attitude {
            yaw: 0.3,
            pitch: -0.15,
            roll,
        };
        let camera = Camera {
            eye: OVER_ROOFS,
            attitude,
            horizontal_fov: 1.0,
        };
        let looks = looks(town(), camera.view([640, 400]))?;
        // 2.8, 3.7 and 2.7; by steepness alone 5.4 at the first one.
        assert!(looks < 4.5, "{looks} looks a ray, rolled by {roll}");
    }
    Ok(())
}

/// A spike that stands beside a ray is not inside its strip.
#[test]
fn among_spikes_rays_begin_from_those_around_them() -> Result<(), Box<dyn Error>> {
    let spike = |col: u32, row: u32| {
        let is_one = (col * 7919 + row * 104_729).is_multiple_of(101);
        if is_one { 30.0 } else { 0.0 }
    };
    let ground = Ground::from_fn(257, 257, DVec2::ONE, spike)?;
    let camera = Camera {
        eye: DVec3::new(120.0, 20.0, 33.0),
        attitude: Attitude {
            pitch: -0.14,
            ..Attitude::default()
        },
        horizontal_fov: 1.0,
    };
    let looks = looks(ground, camera.view([960, 540]))?;
    // 9.4; 19.2 where rays look at the line beside them up to the end of their cell.
    assert!(looks < 13.0, "{looks} looks a ray");
    Ok(())
}

#[test]
fn far_away_rays_begin_from_those_around_them() -> Result<(), Box<dyn Error>> {
    let looks = looks(gorges(), from_afar())?;
    // 14.6; 52.8 where strips end as soon as they are wider than a cell.
    assert!(looks < 25.0, "{looks} looks a ray");
    Ok(())
}
