//! Casters that claim to be exact, before the judge; and the judge, before images that are known to
//! be right or wrong.

#[allow(dead_code, reason = "the benches use more of it")]
#[path = "../../render/cast/benches/scenes/mod.rs"]
mod scenes;

use glam::{DVec2, DVec3};
use sandtable_cast::{
    Brute, CastPool, Caster, Image, PreparedScene, Scene, Sight, caster_by_name, sight,
};
use sandtable_terrain::Ground;
use sandtable_tests::Random;
use sandtable_tests::exactness::{Fault, Verdict, judge};
use sandtable_tests::hard_views::hard_case;
use sandtable_tests::random_views::{Case, Kind, case};
use sandtable_view::{Attitude, Camera, Ray, Screen, View};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use std::path::PathBuf;
use std::sync::Arc;

/// The caster that must be exact.
const CASTER: &str = "planes";

/// How many random views are judged, in place of [`USUAL_VIEWS`].
const VIEWS_VARIABLE: &str = "SANDTABLE_VIEWS";
const USUAL_VIEWS: u64 = 40;

/// Counts over all views of a kind.
#[derive(Default)]
struct Count {
    views: u64,
    pixels: usize,
    ground: usize,
    searched: usize,
    wrong_in_depth: usize,
    wrong_in_colour: usize,
}

impl Count {
    fn add(&mut self, image: &Image, verdict: &Verdict) {
        self.views += 1;
        self.pixels += verdict.pixels;
        self.ground += image.depth.iter().filter(|depth| depth.is_finite()).count();
        self.searched += verdict.searched;
        self.wrong_in_depth += verdict.wrong_in_depth;
        self.wrong_in_colour += verdict.wrong_in_colour;
    }
}

/// Casts and judges the views of the seeds from 0, tells the counts of each kind, and answers the
/// cases that have wrong pixels, with the verdicts.
fn judge_random_views(caster: &str, views: u64) -> Vec<(Case, Verdict)> {
    let caster = caster_by_name(caster).expect("a caster's name");
    let pool = CastPool::new(0).expect("threads");
    let mut prepared: BTreeMap<&str, Arc<dyn PreparedScene>> = BTreeMap::new();
    let mut counts: BTreeMap<Kind, Count> = BTreeMap::new();
    let mut wrong = Vec::new();
    for case in (0..views).map(case) {
        let scene = prepared.entry(case.terrain).or_insert_with(|| {
            let scene = Arc::clone(&case.scene);
            pool.run(|| caster.prepare(scene))
                .expect("any scene will do")
        });
        let mut images = [Image::default()];
        pool.cast(&**scene, &[case.view], &mut images)
            .expect("any view will do");
        let [image] = images;
        let verdict = judge(&case.scene, &case.view, &image);
        counts.entry(case.kind).or_default().add(&image, &verdict);
        if verdict.wrong() > 0 {
            wrong.push((case, verdict));
        }
    }
    println!("kind             views   pixels ground searched  depth colour");
    for (kind, count) in &counts {
        println!(
            "{kind:16} {:5} {:8} {:4} % {:8} {:6} {:6}",
            count.views,
            count.pixels,
            100 * count.ground / count.pixels,
            count.searched,
            count.wrong_in_depth,
            count.wrong_in_colour
        );
    }
    wrong
}

fn views_asked_for() -> u64 {
    std::env::var(VIEWS_VARIABLE).map_or(USUAL_VIEWS, |text| {
        text.parse()
            .unwrap_or_else(|error| panic!("{VIEWS_VARIABLE}={text}: {error}"))
    })
}

#[test]
fn the_exact_caster_sees_what_brute_force_sees() {
    let views = views_asked_for();
    let wrong = judge_random_views(CASTER, views);
    for (case, verdict) in &wrong {
        println!("{case}: {verdict}");
    }
    assert!(
        wrong.is_empty(),
        "{CASTER} is wrong in {} of {views} views, first {}: {}",
        wrong.len(),
        wrong[0].0,
        wrong[0].1
    );
}

/// Hard views of hard ground, drawn anew: the verdict, and the same bytes on other threads and by plain Rust.
#[test]
fn the_exact_caster_stands_hard_views() {
    let pools = [2, 1, 3].map(|threads| CastPool::new(threads).expect("threads"));
    let named = |name: &str| caster_by_name(name).expect("a caster's name");
    let (caster, portable) = (named(CASTER), named("planes?isa=portable"));
    let mut wrong = Vec::new();
    let (mut pixels, mut ground) = (0, 0);
    let cases = views_asked_for();
    for case in (0..cases).map(hard_case) {
        let prepare = |caster: &dyn Caster| {
            let prepared = pools[0].run(|| caster.prepare(Arc::clone(&case.scene)));
            prepared.expect("any scene will do")
        };
        let prepared = prepare(&*caster);
        let plain = case.seed.is_multiple_of(4).then(|| prepare(&*portable));
        for view in &case.views {
            let cast = |pool: &CastPool, prepared: &dyn PreparedScene| {
                let mut images = [Image::default()];
                pool.cast(prepared, &[view.view], &mut images)
                    .expect("any view will do");
                let [image] = images;
                image
            };
            let image = cast(&pools[0], &*prepared);
            let verdict = judge(&case.scene, &view.view, &image);
            pixels += verdict.pixels;
            ground += image.depth.iter().filter(|depth| !is_sky(**depth)).count();
            if verdict.wrong() > 0 {
                wrong.push(format!(
                    "{case}, {}, {}: {verdict}",
                    view.name, view.view.eye
                ));
            }
            let other = &pools[1 + case.seed as usize % 2];
            assert!(image == cast(other, &*prepared), "{case}, {}", view.name);
            if let Some(plain) = &plain {
                assert!(image == cast(other, &**plain), "{case}, {}", view.name);
            }
        }
    }
    println!("{pixels} pixels, {ground} of ground");
    for wrong in &wrong {
        println!("{wrong}");
    }
    assert!(
        wrong.is_empty(),
        "{} views, first {}",
        wrong.len(),
        wrong[0]
    );
    assert!(4 * ground > pixels, "{ground} of {pixels} are ground");
}

/// The views that the benches measure, of the scenes that `SANDTABLE_BENCH_SCENES` names.
#[test]
fn the_exact_caster_sees_what_is_measured() {
    let names = std::env::var("SANDTABLE_BENCH_SCENES");
    let names = names
        .as_deref()
        .unwrap_or("t512,city512,pyrenees,ruby-range");
    let peers = std::env::var_os("SANDTABLE_PEERS").map(PathBuf::from);
    let caster = caster_by_name(CASTER).expect("a caster's name");
    let pool = CastPool::new(0).expect("threads");
    for name in names.split(',') {
        let bench = scenes::scene(name, peers.as_deref()).expect("a scene's name");
        let Some(bench) = bench else {
            continue;
        };
        for standpoint in &bench.views {
            let image = pool
                .picture(&*caster, &bench.scene, standpoint.view)
                .expect("any view will do");
            let verdict = judge(&bench.scene, &standpoint.view, &image);
            println!("{name} {}: {verdict}", standpoint.name);
            assert_eq!(verdict.wrong(), 0, "{name} {}: {verdict}", standpoint.name);
        }
    }
}

/// What the judge says of the exact caster's image.
fn verdict_of(scene: &Arc<Scene>, view: View) -> Verdict {
    let caster = caster_by_name(CASTER).expect("a caster's name");
    let pool = CastPool::new(0).expect("threads");
    let image = pool.picture(&*caster, scene, view);
    judge(scene, &view, &image.expect("any view will do"))
}

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

/// A view of some place of the ground from so many `cells` away (their shorter sides), `height` over the
/// horizon, in pixels of so many radians.
fn from_afar(ground: &Ground, random: &mut Random, [cells, height, pixel]: [f64; 3]) -> View {
    let grid = ground.grid();
    let at = DVec2::new(random.unit(), random.unit()) * grid.extent();
    let target = at.extend(ground.height_at(at.x, at.y).expect("a place on it"));
    let heading = DVec2::from_angle(random.between(0.0, TAU));
    let away = (height.cos() * heading).extend(height.sin());
    let size = [320, 240];
    let camera = Camera {
        eye: target + cells * grid.cell_length() * away,
        attitude: Attitude {
            yaw: (-away.x).atan2(-away.y),
            pitch: -height,
            roll: random.between(0.0, TAU),
        },
        horizontal_fov: 2.0 * (0.5 * f64::from(size[0]) * pixel).atan(),
    };
    camera.view(size)
}

/// From farther away than the kernels' numbers tell hundredths of a cell they do where a pixel is many cells wide;
/// and from farther still, or in narrower pixels, each pixel is cast alone.
#[test]
fn from_afar_it_sees_what_brute_force_sees() {
    let caster = caster_by_name(CASTER).expect("a caster's name");
    let pool = CastPool::new(0).expect("threads");
    let mut random = Random::new(3);
    let mut ground_seen = 0;
    for seed in 0..views_asked_for() {
        let scene = case(seed).scene;
        let (cells, pixel) = if seed % 8 == 0 {
            (random.octaves(2.4e5, 1e7), random.octaves(1e-7, 1e-5))
        } else {
            (random.octaves(1.3e5, 2.6e5), random.octaves(1.23e-4, 5e-4))
        };
        let height = random.between(-0.1, FRAC_PI_2);
        let view = from_afar(&scene.ground, &mut random, [cells, height, pixel]);
        let prepared = pool.run(|| caster.prepare(Arc::clone(&scene)));
        let prepared = prepared.expect("any scene will do");
        let mut images = [Image::default()];
        pool.cast(&*prepared, &[view], &mut images)
            .expect("any view will do");
        let [image] = images;
        let verdict = judge(&scene, &view, &image);
        ground_seen += image.depth.iter().filter(|depth| !is_sky(**depth)).count();
        assert_eq!(
            verdict.wrong(),
            0,
            "seed {seed}, {cells:.0} cells away, {height:.2} up, pixels of {pixel:.1e}: {verdict}"
        );
    }
    println!("{ground_seen} pixels of ground");
    assert!(ground_seen > 10_000);
}

#[test]
fn brute_force_agrees_with_itself() {
    let wrong = judge_random_views("brute", Kind::ALL.len() as u64);
    assert!(wrong.is_empty());
}

/// What brute force sees through a place in the image, in pixels.
fn sight_through(scene: &Scene, view: &View, at: DVec2) -> Sight {
    let ray = Ray {
        origin: view.eye,
        direction: view.direction(at.x, at.y),
    };
    sight(&scene.ground, &ray)
}

/// Whether a pixel's answer is beyond doubt: within a hundredth of a pixel, brute force sees one
/// colour at depths that differ by a small part of the tolerance.
fn is_steady(scene: &Scene, view: &View, [i, j]: [u32; 2]) -> bool {
    let centre = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
    let sights: Vec<_> = (0..16)
        .map(|k| centre + 0.01 * DVec2::from_angle(TAU * f64::from(k) / 16.0))
        .chain([centre])
        .map(|at| sight_through(scene, view, at))
        .collect();
    let [nearest, farthest] = sights
        .iter()
        .fold([f64::INFINITY, 0.0_f64], |[low, high], sight| {
            [low.min(sight.depth), high.max(sight.depth)]
        });
    let cell = scene.ground.grid().cell_length();
    let one_depth = nearest == farthest || farthest - nearest < 0.02 * cell;
    one_depth && sights.iter().all(|sight| sight.colour == sights[0].colour)
}

/// Some steady pixels of an image, all over it.
fn steady_pixels(scene: &Scene, image: &Image) -> Vec<[u32; 2]> {
    let [width, height] = image.view.size;
    let pixels: Vec<_> = (0..width * height)
        .step_by(37)
        .map(|index| [index % width, index / width])
        .filter(|&pixel| is_steady(scene, &image.view, pixel))
        .collect();
    assert!(pixels.len() > 500, "only {} are steady", pixels.len());
    pixels
}

fn index(image: &Image, [i, j]: [u32; 2]) -> usize {
    (j * image.width() + i) as usize
}

/// Made-up hills with a view into them that has ground and sky.
fn hills(extra: impl Fn(u32, u32) -> f64 + Sync) -> (Arc<Scene>, View) {
    let height = |col: u32, row: u32| {
        let (x, y) = (f64::from(col), f64::from(row));
        (40.0 * (x / 13.0).sin() * (y / 17.0).cos() + extra(col, row)) as f32
    };
    let ground = Ground::from_fn(200, 180, DVec2::new(10.0, 12.0), height).expect("a sound grid");
    let camera = Camera {
        eye: DVec3::new(950.0, 20.0, 130.0),
        attitude: Attitude {
            yaw: 0.2,
            pitch: -0.15,
            roll: 0.1,
        },
        horizontal_fov: 1.0,
    };
    (Scene::new(ground), camera.view([320, 240]))
}

fn exact_image(scene: &Arc<Scene>, view: View) -> Image {
    let pool = CastPool::new(0).expect("threads");
    pool.picture(&Brute, scene, view).expect("any view will do")
}

fn is_sky(depth: f32) -> bool {
    depth == f32::INFINITY
}

#[test]
fn hits_that_were_moved_by_a_fifth_of_a_cell_are_found() {
    let (scene, view) = hills(|_, _| 0.0);
    let exact = exact_image(&scene, view);
    let cell = scene.ground.grid().cell_length() as f32;
    let mut steady = steady_pixels(&scene, &exact);
    steady.retain(|&pixel| !is_sky(exact.depth[index(&exact, pixel)]));
    for (cells, wrong) in [(0.2, true), (-0.2, true), (0.09, false), (-0.09, false)] {
        let mut moved = exact.clone();
        for &pixel in &steady {
            moved.depth[index(&exact, pixel)] += cells * cell;
        }
        let verdict = judge(&scene, &view, &moved);
        let expected = if wrong { steady.len() } else { 0 };
        assert_eq!(verdict.wrong_in_depth, expected, "{cells}: {verdict}");
        assert_eq!(verdict.wrong_in_colour, 0, "{cells}: {verdict}");
        assert_eq!(verdict.searched, expected);
        if wrong {
            assert_eq!(verdict.first[0].pixel, steady[0]);
            assert_eq!(verdict.first[0].fault, Fault::Depth);
            let [found, exact] = verdict.first[0].cells;
            assert!((found - exact - f64::from(cells)).abs() < 1e-4, "{verdict}");
        }
    }
}

#[test]
fn a_fence_that_was_missed_is_found() {
    let (without, view) = hills(|_, _| 0.0);
    // One post wide, and from the eye a fraction of a pixel.
    let (with, _) = hills(|col, _| if col == 120 { 15.0 } else { 0.0 });
    let (missed, exact) = (exact_image(&without, view), exact_image(&with, view));
    let cell = with.ground.grid().cell_length() as f32;
    let differing = missed
        .depth
        .iter()
        .zip(&exact.depth)
        .filter(|(missed, exact)| missed != exact && (*missed - *exact).abs() > 0.1 * cell)
        .count();
    let verdict = judge(&with, &view, &missed);
    assert!(differing > 1000, "{differing}");
    // At the fence's edges, some rays pass it.
    assert!(verdict.wrong_in_depth <= differing, "{verdict}");
    assert!(
        verdict.wrong_in_depth as f64 > 0.97 * differing as f64,
        "{verdict} of {differing}"
    );
}

#[test]
fn sky_instead_of_ground_and_ground_instead_of_sky_are_found() {
    let (scene, view) = hills(|_, _| 0.0);
    let mut image = exact_image(&scene, view);
    let steady = steady_pixels(&scene, &image);
    let was_sky = |image: &Image| {
        let sky = |pixel: &&[u32; 2]| is_sky(image.depth[index(image, **pixel)]);
        steady.iter().filter(sky).count()
    };
    let skies = was_sky(&image);
    assert!(skies > 100 && steady.len() - skies > 100);
    for &pixel in &steady {
        let depth = &mut image.depth[(pixel[1] * 320 + pixel[0]) as usize];
        *depth = if is_sky(*depth) { 500.0 } else { f32::INFINITY };
    }
    assert_eq!(was_sky(&image), steady.len() - skies);
    let verdict = judge(&scene, &view, &image);
    assert_eq!(verdict.wrong_in_depth, steady.len(), "{verdict}");
    assert_eq!(verdict.wrong_in_colour, 0, "{verdict}");
}

#[test]
fn colours_that_are_off_by_five_are_found() {
    let (scene, view) = hills(|_, _| 0.0);
    let exact = exact_image(&scene, view);
    let steady = steady_pixels(&scene, &exact);
    for (off, wrong) in [(5, true), (3, true), (2, false)] {
        for channel in 0..3 {
            let mut image = exact.clone();
            for &pixel in &steady {
                let at = index(&exact, pixel);
                let level = &mut image.colour_mut()[at][channel];
                *level = if *level < 128 {
                    *level + off
                } else {
                    *level - off
                };
            }
            let verdict = judge(&scene, &view, &image);
            let expected = if wrong { steady.len() } else { 0 };
            assert_eq!(verdict.wrong_in_colour, expected, "{off}: {verdict}");
            assert_eq!(verdict.wrong_in_depth, 0, "{off}: {verdict}");
            assert!(
                verdict
                    .first
                    .iter()
                    .all(|pixel| pixel.fault == Fault::Colour)
            );
        }
    }
}

/// The colour of what is behind, at the depth of what is in front: each alone agrees with some ray
/// at an edge, but no ray has both.
#[test]
fn one_ray_answers_for_depth_and_colour() {
    let (scene, view) = hills(|_, _| 0.0);
    let exact = exact_image(&scene, view);
    let mut image = exact.clone();
    let mut mixed = 0;
    for at in 320..exact.depth.len() {
        let above = at - 320;
        if is_sky(exact.depth[above]) && !is_sky(exact.depth[at]) {
            image.colour_mut()[at] = exact.colour()[above];
            mixed += 1;
        }
    }
    let verdict = judge(&scene, &view, &image);
    assert!(mixed > 200, "{mixed}");
    assert_eq!(verdict.wrong_in_colour, mixed, "{verdict}");
}

/// What brute force sees through every pixel at most so many pixels off its centre, and where that
/// is told as the centre's ray, less than a tenth of a cell off its hit.
fn jittered(scene: &Scene, view: &View, off: f64, random: &mut Random) -> Image {
    let mut image = Image::default();
    image.reset(*view);
    let [width, height] = view.size;
    for index in 0..width * height {
        let angle = random.between(0.0, TAU);
        let mut off = off * random.unit().sqrt() * DVec2::from_angle(angle);
        let centre = DVec2::new(f64::from(index % width), f64::from(index / width)) + 0.5;
        let sight = loop {
            let sight = sight_through(scene, view, centre + off);
            let forward = |at: DVec2| view.direction(at.x, at.y).normalize();
            let turn = (forward(centre + off) - forward(centre)).length();
            let sideways = turn * sight.depth / scene.ground.grid().cell_length();
            if sight.depth.is_infinite() || sideways < 0.09 {
                break sight;
            }
            off *= 0.5;
        };
        image.depth[index as usize] = sight.depth as f32;
        image.colour_mut()[index as usize][..3].copy_from_slice(&sight.colour);
    }
    image
}

#[test]
fn any_ray_within_a_hundredth_of_a_pixel_will_do() {
    let mut random = Random::new(1);
    let mut searched = 0;
    for case in (0..15).map(case) {
        for off in [0.0099, 1e-3] {
            let image = jittered(&case.scene, &case.view, off, &mut random);
            let verdict = judge(&case.scene, &case.view, &image);
            assert_eq!(verdict.wrong(), 0, "{off} pixels off, {case}: {verdict}");
            searched += verdict.searched;
        }
    }
    // Many do differ from the centre's ray.
    assert!(searched > 300, "{searched}");
}

/// From a cell above a plane, depths of hundreds of cells lie within a disc near the horizon, many
/// more than rays in the rings.
#[test]
fn depths_that_range_over_the_pixels_are_searched_between_rays() {
    let ground = Ground::from_fn(2001, 400, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let camera = Camera {
        eye: DVec3::new(1.0, 200.0, 1.0),
        attitude: Attitude {
            yaw: FRAC_PI_2,
            ..Attitude::default()
        },
        horizontal_fov: 0.2,
    };
    let (scene, view) = (Scene::new(ground), camera.view([320, 240]));
    let image = jittered(&scene, &view, 0.0099, &mut Random::new(2));
    let verdict = judge(&scene, &view, &image);
    assert!(verdict.searched > 200, "{verdict}");
    assert_eq!(verdict.wrong(), 0, "{verdict}");
}

/// A wall of which a disc covers ten cells, and a slit in it, a cell and a half wide at most, that
/// lies beside the rays that are tried first.
#[test]
fn what_is_seen_through_a_slit_in_the_disc_passes() {
    let notch = |col: u32, _| if col == 20 { -16.0 } else { 0.0 };
    let ground = Ground::from_fn(41, 3, DVec2::ONE, notch).expect("a sound grid");
    let scene = Scene::new(ground);
    let camera = |eye| Camera {
        eye,
        attitude: Attitude::default(),
        horizontal_fov: 0.9,
    };
    let size = [320, 240];
    let (pixel, centre) = ([160, 120], DVec2::new(160.5, 120.5));
    let way = camera(DVec3::ZERO).view(size).direction(centre.x, centre.y);
    let across = camera(DVec3::ZERO).view(size).window.across().length() / 320.0;
    // The ray through the centre meets the wall 1.9 cells beside the slit.
    let eye = DVec3::new(18.1, 0.0, -8.0) - 500.0 / across * way;
    let view = camera(eye).view(size);
    let mut image = exact_image(&scene, view);
    assert!(!is_sky(image.depth[index(&image, pixel)]));
    let sky = sight_through(&scene, &view, centre + DVec2::new(1.9 / 500.0, 0.0));
    let at = index(&image, pixel);
    image.depth[at] = sky.depth as f32;
    image.colour_mut()[at][..3].copy_from_slice(&sky.colour);
    assert!(is_sky(image.depth[at]), "there is a slit");
    let verdict = judge(&scene, &view, &image);
    assert_eq!((verdict.searched, verdict.wrong()), (1, 0), "{verdict}");
}

#[test]
fn rays_a_tenth_of_a_pixel_off_are_found() {
    let (scene, view) = hills(|_, _| 0.0);
    let mut moved = view;
    let tenth = 0.1 / 240.0 * view.window.upwards();
    moved.window = view.window.map(|corner| corner + tenth);
    let mut image = exact_image(&scene, moved);
    image.view = view;
    let verdict = judge(&scene, &view, &image);
    // Where a ray meets the ground steeply and the ground is near, a tenth of a pixel is nothing.
    assert!(verdict.wrong() > 5_000, "{verdict}");
}

/// From so far that a hundredth of a pixel is a fifth of a cell, each way.
#[test]
fn a_far_hit_must_be_as_near_to_an_exact_one_as_a_near_hit() {
    let ground = Ground::from_fn(257, 257, DVec2::ONE, |_, _| 0.0).expect("a sound grid");
    let camera = Camera {
        eye: DVec3::new(128.0, -4872.0, 5000.0),
        attitude: Attitude {
            pitch: -FRAC_PI_4,
            ..Attitude::default()
        },
        horizontal_fov: 0.9,
    };
    let (scene, view) = (Scene::new(ground), camera.view([320, 240]));
    let mut moved = view;
    let off = 0.0099 / 240.0 * view.window.upwards();
    moved.window = view.window.map(|corner| corner + off);
    let mut image = exact_image(&scene, moved);
    image.view = view;
    let seen = image.depth.iter().filter(|depth| !is_sky(**depth)).count();
    let verdict = judge(&scene, &view, &image);
    assert!(
        seen > 80 && verdict.wrong_in_depth > seen * 3 / 4,
        "{verdict}"
    );
}
