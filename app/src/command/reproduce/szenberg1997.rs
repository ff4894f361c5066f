//! Szenberg, Gattass and Carvalho (1997): depth beside the floating horizon, and the upload of
//! both (row Z5).

use super::Setup;
use super::picture::{colours, slice_depth};
use super::report::{Cell, Picture, Report, Table};
use super::trial::{Prepared, Trial, all_prepared};
use super::upload::Upload;
use crate::command::bench::measure::{Times, Work, take_turns};
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

/// Times casting with and without depth, and both uploads, in turns.
fn steps(
    setup: &Setup,
    scene: &Scene,
    casters: &[Prepared],
    gpu: Result<&Gpu, &GpuError>,
    size: [u32; 2],
) -> Result<Steps> {
    let view = standpoints::ahead(&scene.ground, size);
    let run = |prepared| Trial::new(prepared, &setup.one, view).run();
    let mut runs: Vec<_> = casters.iter().map(run).collect();
    // What is uploaded does not matter: any image of this size will do.
    let mut image = Image::default();
    image.reset(view);
    let uploads = gpu.map(|gpu| {
        [
            Upload::of_colour(gpu, &image),
            Upload::of_depth(gpu, &image),
        ]
    });
    let mut works: Vec<Work<'_>> = Vec::new();
    // Why a step is not among the works.
    let mut faults = Vec::new();
    for run in &mut runs {
        match run {
            Ok(run) => {
                works.push(run.as_work());
                faults.push(None);
            }
            Err(error) => faults.push(Some(error.to_string())),
        }
    }
    match &uploads {
        Ok(uploads) => {
            works.extend(uploads.iter().map(Upload::as_work));
            faults.extend([None, None]);
        }
        Err(_) => faults.extend([(); 2].map(|()| Some("no graphics adapter".to_owned()))),
    }
    let mut times = take_turns(setup.frames, &mut works)?.into_iter();
    let step = |fault: Option<String>| match fault {
        Some(fault) => Some(Err(fault)),
        None => times.next().map(Ok),
    };
    Ok(faults.into_iter().filter_map(step).collect())
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
    table
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
