//! Guedes, Gattass and Carvalho (1997): casters for inclined view planes (rows G3, G5).

use super::report::{Cell, Picture, Report, Table};
use super::trial::{Attempt, Outcome, Prepared, Trial, all_prepared, cell, outcomes, ratio};
use super::{Setup, blocks, opened};
use anyhow::Result;
use sandtable_cast::{CastPool, Difference, Scene, standpoints};
use sandtable_terrain::TerrainSource;
use sandtable_view::View;
use std::sync::Arc;

const CITATION: &str = "L. C. Guedes, M. Gattass, P. C. P. Carvalho: Real-Time Rendering of \
                        Photo-Textured Terrain Height Fields. SIBGRAPI, 1997.";

const SIZE: [u32; 2] = [640, 480];

/// The judge and the three casters for inclined planes, in the order of the paper's figures 11
/// and 12. Bilinear between posts, as the judge is, so that only the projection differs.
const DRAWN: [(&str, &str, &str); 4] = [
    ("brute", "brute", "brute force"),
    ("inclined-naive?posts=bilinear", "naive", "naive"),
    (
        "inclined?posts=bilinear",
        "uncorrected",
        "without correction",
    ),
    (
        "inclined-corrected?posts=bilinear",
        "corrected",
        "with correction",
    ),
];

/// The casters of the paper's table 1, with its milliseconds; posts as they stand, as there.
const TIMED: [(&str, &str, f64); 5] = [
    (
        "floating-horizon?depth=off&posts=nearest",
        "standard, upright plane",
        107.0,
    ),
    ("inclined-naive?posts=nearest", "naive", 123.0),
    ("inclined?posts=nearest", "without correction", 134.0),
    ("inclined-corrected?posts=nearest", "with correction", 277.0),
    ("brute", "brute force", 4697.0),
];

/// Degrees between the view plane and the vertical.
const INCLINATIONS: [f64; 3] = [30.0, 60.0, 90.0];

/// One of the paper's two kinds of scene.
struct Subject {
    scene: Arc<Scene>,
    /// What files begin with.
    file: &'static str,
    /// What tables call it.
    label: &'static str,
    casters: Vec<Prepared>,
}

/// Measures and draws.
pub(super) fn report(setup: &Setup) -> Result<Report> {
    let (name, terrain) = opened(&TerrainSource::Jacksboro)?;
    let subject = |scene: Arc<Scene>, file, label| -> Result<Subject> {
        Ok(Subject {
            casters: all_prepared(&setup.many, &scene, DRAWN.map(|(caster, ..)| caster))?,
            scene,
            file,
            label,
        })
    };
    let subjects = [
        subject(Arc::clone(&terrain), "terrain", "terrain")?,
        subject(blocks::scene()?, "blocks", "blocks")?,
    ];
    let mut report = Report::new("Inclined view planes, 1997", CITATION);
    report.paragraph(format!(
        "The floating horizon is made for upright view planes. The paper compares three ways to \
         keep most of its speed where the plane is inclined, on real terrain and on blocks over a \
         checkered ground. Here the real terrain is {name}; images have {} by {} pixels.",
        SIZE[0], SIZE[1]
    ));
    report.heading("Time per frame");
    report.table(times(setup, &terrain)?);
    report.heading("Error against brute force");
    let mut errors = Table::new(
        "Share of pixels more than a cell off in depth or wrongly sky, and PSNR of the colours.",
        &["scene", "inclined °", "caster", "pixels off %", "PSNR dB"],
    );
    let mut figures = Vec::new();
    for subject in &subjects {
        for inclination in INCLINATIONS {
            figures.push(compared(&setup.many, subject, inclination, &mut errors));
        }
    }
    report.table(errors);
    for (place, pictures) in figures.into_iter().enumerate() {
        let inclination = INCLINATIONS[place % INCLINATIONS.len()];
        let subject = &subjects[place / INCLINATIONS.len()];
        report.heading(format!(
            "{}, inclined by {inclination}°",
            capital(subject.label)
        ));
        // The paper's own figures are two by two; the others are one row each.
        report.figure(if inclination == 30.0 { 2 } else { 4 }, pictures);
    }
    Ok(report)
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    let first = letters.next().map(|letter| letter.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}

/// The paper's table 1 beside ours.
fn times(setup: &Setup, scene: &Arc<Scene>) -> Result<Table> {
    let inclination = INCLINATIONS[0].to_radians();
    let inclined = standpoints::inclined(&scene.ground, inclination, SIZE);
    let upright = upright(scene, &inclined);
    let casters = all_prepared(&setup.one, scene, TIMED.map(|(caster, ..)| caster))?;
    let trials: Vec<_> = casters
        .iter()
        .enumerate()
        .map(|(place, prepared)| {
            let view = if place == 0 { upright } else { inclined };
            Trial::new(prepared, &setup.one, view)
        })
        .collect();
    let attempts: Vec<Attempt> = outcomes(setup.frames, &trials)?;
    let mut table = Table::new(
        "One thread, the plane inclined by 30°; the standard caster's time is 1.",
        &[
            "caster",
            "paper ms",
            "paper ratio",
            "ours ms",
            "our ratio",
            "p5 ms",
            "p95 ms",
            "Mpix/s",
        ],
    );
    for ((_, label, paper), attempt) in TIMED.iter().zip(&attempts) {
        table.row([
            (*label).into(),
            Cell::Number(*paper, 0),
            Cell::Number(paper / TIMED[0].2, 2),
            cell(attempt, 1, Outcome::ms),
            ratio(attempt, &attempts[0]),
            cell(attempt, 1, |it| it.times.at(0.05)),
            cell(attempt, 1, |it| it.times.at(0.95)),
            cell(attempt, 2, Outcome::mpix_per_s),
        ]);
    }
    Ok(table)
}

/// The upright view from the eye of `inclined`.
fn upright(scene: &Scene, inclined: &View) -> View {
    let mut view = standpoints::ahead(&scene.ground, SIZE);
    let moved = inclined.eye - view.eye;
    view.eye += moved;
    view.window = view.window.map(|corner| corner + moved);
    view
}

/// Casts one scene by all casters, adds their errors to `errors`, and gives the images.
fn compared(
    pool: &CastPool,
    subject: &Subject,
    inclination: f64,
    errors: &mut Table,
) -> Vec<Picture> {
    let ground = &subject.scene.ground;
    let view = standpoints::inclined(ground, inclination.to_radians(), SIZE);
    let mut pictures = Vec::new();
    let mut exact = None;
    for ((_, file, label), prepared) in DRAWN.iter().zip(&subject.casters) {
        let row = |off: Cell, psnr: Cell| {
            let scene = Cell::from(subject.label);
            [
                scene,
                Cell::Number(inclination, 0),
                (*label).into(),
                off,
                psnr,
            ]
        };
        let image = match Trial::new(prepared, pool, view).images() {
            Ok(mut images) => images.swap_remove(0),
            Err(error) => {
                errors.row(row(Cell::Refused(error.to_string()), Cell::Empty));
                continue;
            }
        };
        pictures.push(Picture::new(
            format!("{}-{inclination}-{file}", subject.file),
            capital(label),
            super::picture::colours(&image),
        ));
        let Some(exact) = &exact else {
            exact = Some(image);
            continue;
        };
        let difference = Difference::between(&image, exact, ground.grid().cell_length());
        let off = 100.0 * difference.over_one_cell as f64 / exact.depth.len() as f64;
        errors.row(row(
            Cell::Number(off, 2),
            difference
                .psnr_db
                .map_or("identical".into(), |db| Cell::Number(db, 1)),
        ));
    }
    pictures
}
