//! Szenberg, Gattass and Carvalho (1997): depth beside the floating horizon, and the upload of
//! both (row Z5).

use super::Setup;
use super::picture::{colours, slice_depth};
use super::report::{Cell, Picture, Report, Table};
use super::trial::{Attempt, Prepared, Trial, all_prepared, outcomes};
use super::upload::Upload;
use crate::command::bench::measure::{Times, take_turns};
use anyhow::Result;
use sandtable_cast::{Image, Scene, standpoints};
use sandtable_stage::{Gpu, GpuError};

const CITATION: &str = "F. Szenberg, M. Gattass, P. C. P. Carvalho: An Algorithm for the \
                        Visualization of a Terrain with Objects. SIBGRAPI, 1997.";

/// The steps of a frame, and the paper's seconds for them on a Pentium 166 and an SGI Indigo 2.
const STEPS: [(&str, [f64; 2]); 4] = [
    ("floating horizon, colour and depth", [0.05, 0.18]),
    ("floating horizon, colour alone", [0.04, 0.13]),
    ("colour upload", [0.04, 0.04]),
    ("depth upload", [0.11, 0.11]),
];

const SIZES: [[u32; 2]; 2] = [[320, 200], [640, 400]];

/// Times of the four steps, or why there are none.
type Steps = Vec<Result<Times, String>>;

/// Measures and draws.
pub(super) fn report(setup: &Setup) -> Result<Report> {
    let (name, scene) = setup.ridges(512)?;
    let casters = ["floating-horizon?depth=on", "floating-horizon?depth=off"];
    let casters = all_prepared(&setup.one, &scene, casters)?;
    let gpu = Gpu::offscreen();
    let mut columns = Vec::new();
    for size in SIZES {
        columns.push((size, steps(setup, &scene, &casters, gpu.as_ref(), size)?));
    }
    let mut report = Report::new("Terrain with objects, 1997", CITATION);
    report.paragraph(format!(
        "The paper draws terrain on the processor by a floating horizon, with a depth for each \
         pixel so that the graphics card can draw houses and lines among it, and finds that \
         loading both images into the card takes longer than making them. Here the terrain is \
         {name}, seen along the horizon, on one thread; an upload is a texture written and waited \
         for, {}.",
        match &gpu {
            Ok(gpu) => format!("by {}", gpu.description()),
            Err(error) => format!("which could not be measured: {error}"),
        }
    ));
    report.heading("The steps of a frame");
    report.table(table(&columns));
    report.heading("Colour and depth");
    report.figure(2, pictures(setup, &scene, &casters[0]));
    Ok(report)
}

/// Times casting with and without depth in turns, and then both uploads.
fn steps(
    setup: &Setup,
    scene: &Scene,
    casters: &[Prepared],
    gpu: Result<&Gpu, &GpuError>,
    size: [u32; 2],
) -> Result<Steps> {
    let view = standpoints::ahead(&scene.ground, size);
    let trials: Vec<_> = casters
        .iter()
        .map(|prepared| Trial::new(prepared, &setup.one, view))
        .collect();
    // Apart from the uploads, which would leave the caches to whichever comes next.
    let casts = outcomes(setup.frames, &trials)?.into_iter();
    let times = |attempt: Attempt| attempt.map(|it| it.times).map_err(|it| it.to_string());
    let mut steps: Steps = casts.map(times).collect();
    // What is uploaded does not matter: any image of this size will do.
    let mut image = Image::default();
    image.reset(view);
    match gpu {
        Ok(gpu) => {
            let uploads = [
                Upload::of_colour(gpu, &image),
                Upload::of_depth(gpu, &image),
            ];
            let mut works = uploads.each_ref().map(Upload::as_work);
            steps.extend(take_turns(setup.frames, &mut works)?.into_iter().map(Ok));
        }
        Err(_) => steps.extend([(); 2].map(|()| Err("no graphics adapter".to_owned()))),
    }
    Ok(steps)
}

fn table(columns: &[([u32; 2], Steps)]) -> Table {
    let mut titles = vec![
        "step".to_owned(),
        "paper PC s".to_owned(),
        "ratio".to_owned(),
        "paper SGI s".to_owned(),
        "ratio".to_owned(),
    ];
    for ([width, height], _) in columns {
        titles.extend([
            format!("ours {width}×{height} ms"),
            "ratio".to_owned(),
            "Mpix/s".to_owned(),
        ]);
    }
    let titles: Vec<_> = titles.iter().map(String::as_str).collect();
    let mut table = Table::new(
        "Casting with depth is 1. The paper's steps without depth are those of its scene without \
         objects.",
        &titles,
    );
    for (place, (label, seconds)) in STEPS.iter().enumerate() {
        let mut cells = vec![Cell::from(*label)];
        for (machine, time) in seconds.iter().enumerate() {
            cells.push(Cell::Number(*time, 2));
            cells.push(Cell::Number(time / STEPS[0].1[machine], 2));
        }
        for (size, steps) in columns {
            let pixels = f64::from(size[0]) * f64::from(size[1]);
            cells.extend(match (&steps[place], &steps[0]) {
                (Ok(times), unit) => [
                    Cell::Number(times.median(), 2),
                    Cell::quoted(unit.as_ref().ok().map(|it| times.median() / it.median()), 2),
                    Cell::Number(pixels / times.median() / 1e3, 1),
                ],
                (Err(fault), _) => [Cell::Refused(fault.clone()), Cell::Empty, Cell::Empty],
            });
        }
        table.row(cells);
    }
    table.row(cost_of_depth(columns));
    table
}

/// What depth adds to the time of colour alone, in percent.
fn cost_of_depth(columns: &[([u32; 2], Steps)]) -> Vec<Cell> {
    let percent = |with: f64, without: f64| 100.0 * (with / without - 1.0);
    let mut cells = vec![Cell::from("what depth adds to colour, %")];
    for (with, without) in STEPS[0].1.iter().zip(STEPS[1].1) {
        cells.extend([Cell::Empty, Cell::Number(percent(*with, without), 1)]);
    }
    for (_, steps) in columns {
        let cost = match (&steps[0], &steps[1]) {
            (Ok(with), Ok(without)) => Cell::Number(percent(with.median(), without.median()), 1),
            _ => Cell::Empty,
        };
        cells.extend([Cell::Empty, cost, Cell::Empty]);
    }
    cells
}

fn pictures(setup: &Setup, scene: &Scene, with_depth: &Prepared) -> Vec<Picture> {
    let view = standpoints::ahead(&scene.ground, SIZES[1]);
    let Ok(images) = Trial::new(with_depth, &setup.many, view).images() else {
        // The table says why.
        return Vec::new();
    };
    vec![
        Picture::new(
            "colour",
            "The floating horizon's colours.",
            colours(&images[0]),
        ),
        Picture::new(
            "depth",
            "Its depths as the paper keeps them for the depth test: near is dark.",
            slice_depth(&images[0]),
        ),
    ]
}
