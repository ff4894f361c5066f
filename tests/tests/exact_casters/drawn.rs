//! Views drawn from seeds.

use super::{CASTER, is_sky};
use glam::DVec2;
use sandtable_cast::{CastPool, Caster, Image, PreparedScene, caster_by_name};
use sandtable_terrain::Ground;
use sandtable_tests::Random;
use sandtable_tests::exactness::{Verdict, judge};
use sandtable_tests::hard_views::hard_case;
use sandtable_tests::random_views::{Case, Kind, case};
use sandtable_view::{Attitude, Camera, View};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

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
