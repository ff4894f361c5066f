//! Cohen-Or, Rich, Lerner and Shenkar (1996): pitch, processors, schemes and blended levels
//! (row C11).

use super::Setup;
use super::picture::strip;
use super::report::{Cell, Picture, Report, Table};
use super::trial::{Attempt, Outcome, Prepared, Trial, cell, outcomes, prepared};
use anyhow::Result;
use sandtable_cast::{CastError, CastPool, Image, Scene, Scheme, standpoints};
use sandtable_view::View;
use std::sync::Arc;

const CITATION: &str = "D. Cohen-Or, E. Rich, U. Lerner, V. Shenkar: A Real-Time Photo-Realistic \
                        Visual Flythrough. IEEE Transactions on Visualization and Computer \
                        Graphics, 1996.";

const SIZE: [u32; 2] = [640, 480];
/// One frame of the flight whose frames are compared.
const FLOWN: [u32; 2] = [320, 240];

/// Numbers of processors in the paper's table 1.
const PROCESSORS: [usize; 5] = [32, 16, 8, 4, 2];

/// Degrees down, and the paper's frames a second on those processors.
const PITCHES: [(f64, [f64; 5]); 3] = [
    (14.6, [11.0, 5.4, 2.5, 1.1, 0.36]),
    (26.5, [15.6, 7.6, 3.6, 1.5, 0.51]),
    (39.0, [16.3, 8.0, 3.7, 1.6, 0.53]),
];

/// Frames that are cast as one job.
const AT_ONCE: usize = 8;
/// Frames of the flight.
const FLIGHT: usize = 24;

/// Measures and draws.
pub(super) fn report(setup: &Setup) -> Result<Report> {
    let (name, scene) = setup.ridges(1025)?;
    let caster = prepared(&setup.many, &scene, "multiresolution")?;
    let mut report = Report::new("Photo-realistic visual flythrough, 1996", CITATION);
    report.paragraph(format!(
        "The paper casts columns of pixels through a pyramid of resolutions on an IBM Power \
         Visualization System. Its flight is over aerial photographs with an unnamed size of image; \
         ours is over {name} at {} by {} pixels.",
        SIZE[0], SIZE[1]
    ));
    report.heading("Pitch and processors");
    let one_level = prepared(&setup.many, &scene, "coherent")?;
    pitches(&mut report, setup, &scene, [&caster, &one_level])?;
    report.heading("Sharing out the work");
    report.table(schemes(setup, &scene, &caster)?);
    report.heading("Blended levels");
    flight(&mut report, setup, &scene)?;
    Ok(report)
}

/// Frame rates at three pitches, theirs and ours, and images of them.
fn pitches(
    report: &mut Report,
    setup: &Setup,
    scene: &Arc<Scene>,
    casters: [&Prepared; 2],
) -> Result<()> {
    let pools = setup.pools();
    let view = |degrees: f64| standpoints::flown(&scene.ground, degrees.to_radians(), 0.0, SIZE);
    // By pitch, then caster, then threads.
    let trials: Vec<_> = PITCHES
        .iter()
        .flat_map(|&(degrees, _)| casters.map(|prepared| (degrees, prepared)))
        .flat_map(|(degrees, prepared)| {
            pools.iter().map(move |pool| Trial {
                scheme: Scheme::ColumnPool,
                ..Trial::new(prepared, pool, view(degrees))
            })
        })
        .collect();
    let attempts = outcomes(setup.frames, &trials)?;
    let of_pitch: Vec<_> = attempts.chunks(casters.len() * pools.len()).collect();

    let mut columns = vec!["pitch °".to_owned()];
    columns.extend(PROCESSORS.map(|count| format!("paper, {count} processors")));
    for name in ["levels", "one level"] {
        columns.extend(pools.iter().map(|pool| match pool.threads() {
            1 => format!("ours, {name}, 1 thread"),
            count => format!("ours, {name}, {count} threads"),
        }));
    }
    let columns: Vec<_> = columns.iter().map(String::as_str).collect();
    let mut rates = Table::new(
        "Frames a second. One of the paper's processors only directs the others. Levels are cast \
         with two parallel rays a pixel; one level is the default caster, one ray a pixel and \
         without a pyramid.",
        &columns,
    );
    for ((degrees, paper), ours) in PITCHES.iter().zip(&of_pitch) {
        let mut cells = vec![Cell::Number(*degrees, 1)];
        cells.extend(paper.map(|fps| Cell::Number(fps, if fps < 1.0 { 2 } else { 1 })));
        cells.extend(ours.iter().map(|attempt| cell(attempt, 1, Outcome::fps)));
        rates.row(cells);
    }
    let mut cells = vec![Cell::from("39.0 to 14.6, ratio")];
    let (flat, steep) = (PITCHES[0].1, PITCHES[2].1);
    cells.extend((0..PROCESSORS.len()).map(|place| Cell::Number(steep[place] / flat[place], 2)));
    cells.extend(of_pitch[0].iter().zip(of_pitch[2]).map(|pair| match pair {
        (Ok(flat), Ok(steep)) => Cell::Number(steep.fps() / flat.fps(), 2),
        _ => Cell::Empty,
    }));
    rates.row(cells);
    report.table(rates);

    let mut speeds = Table::new(
        "The same in millions of pixels a second.",
        &columns
            .iter()
            .enumerate()
            .filter(|(place, _)| *place == 0 || *place > PROCESSORS.len())
            .map(|(_, column)| *column)
            .collect::<Vec<_>>(),
    );
    for ((degrees, _), ours) in PITCHES.iter().zip(&of_pitch) {
        let mut cells = vec![Cell::Number(*degrees, 1)];
        cells.extend(ours.iter().map(|it| cell(it, 2, Outcome::mpix_per_s)));
        speeds.row(cells);
    }
    report.table(speeds);
    let picture = |(degrees, ours): (f64, &&[Attempt])| {
        Picture::of(
            &ours[0],
            &format!("pitch-{degrees}"),
            &format!("{degrees}° down."),
        )
    };
    let angles = PITCHES.iter().map(|&(degrees, _)| degrees);
    report.figure(3, angles.zip(&of_pitch).filter_map(picture).collect());
    Ok(())
}

/// A view on the way of the flight at 14.6°, of `size` pixels.
fn on_the_way(scene: &Scene, frame: usize, frames: usize, size: [u32; 2]) -> View {
    // A short way, as between the frames of a real flight.
    let way = 0.05 * frame as f64 / frames.max(1) as f64;
    standpoints::flown(&scene.ground, PITCHES[0].0.to_radians(), way, size)
}

/// The schemes, frame by frame and with frames overlapped as one job.
fn schemes(setup: &Setup, scene: &Arc<Scene>, caster: &Prepared) -> Result<Table> {
    let pool: &CastPool = &setup.many;
    let views: Vec<_> = (0..AT_ONCE)
        .map(|frame| on_the_way(scene, frame, AT_ONCE, SIZE))
        .collect();
    let jobs = [vec![views[0]], views];
    let trials: Vec<_> = Scheme::ALL
        .into_iter()
        .flat_map(|scheme| jobs.iter().map(move |views| (scheme, views)))
        .map(|(scheme, views)| Trial {
            prepared: caster,
            pool,
            scheme,
            views: views.clone(),
        })
        .collect();
    let attempts = outcomes(setup.frames, &trials)?;
    let mut table = Table::new(
        format!(
            "Frames a second on {} threads: each frame waited for, and {AT_ONCE} frames as one job, \
             in which free threads begin the next frame. The paper's scheme is the column pool.",
            pool.threads()
        ),
        &[
            "scheme",
            "frame by frame",
            "p5",
            "p95",
            "overlapped",
            "p5",
            "p95",
        ],
    );
    for (scheme, pair) in Scheme::ALL.iter().zip(attempts.chunks(2)) {
        let mut cells = vec![Cell::from(match scheme {
            Scheme::WorkStealing => "work stealing",
            Scheme::StaticInterleave => "static interleave",
            Scheme::ColumnPool => "column pool",
        })];
        for attempt in pair {
            let fps = |outcome: &Outcome, share: f64| {
                1e3 * outcome.images.len() as f64 / outcome.times.at(share)
            };
            cells.push(cell(attempt, 1, Outcome::fps));
            cells.push(cell(attempt, 1, |it| fps(it, 0.95)));
            cells.push(cell(attempt, 1, |it| fps(it, 0.05)));
        }
        table.row(cells);
    }
    Ok(table)
}

/// How much successive frames differ with and without blended levels, and some of them.
fn flight(report: &mut Report, setup: &Setup, scene: &Arc<Scene>) -> Result<()> {
    let pool = &setup.many;
    let views: Vec<_> = (0..FLIGHT)
        .map(|frame| on_the_way(scene, frame, FLIGHT, FLOWN))
        .collect();
    let flown = |prepared: &Prepared| -> Result<Vec<Image>, CastError> {
        Trial {
            prepared,
            pool,
            scheme: Scheme::ColumnPool,
            views: views.clone(),
        }
        .images()
    };
    let mut table = Table::new(
        format!(
            "Mean change of a colour channel (of 255) from one frame to the next over {FLIGHT} \
             frames, and the greatest between two frames. Less is steadier."
        ),
        &["caster", "mean", "greatest"],
    );
    let mut shown = None;
    for (label, caster) in [
        ("levels, blended", "multiresolution?blend=on"),
        ("levels, not blended", "multiresolution?blend=off"),
        ("one level", "coherent"),
    ] {
        let images = flown(&prepared(pool, scene, caster)?);
        table.row(match &images {
            Ok(images) => {
                let changes: Vec<_> = images
                    .windows(2)
                    .map(|pair| change(&pair[0], &pair[1]))
                    .collect();
                let mean = changes.iter().sum::<f64>() / changes.len() as f64;
                let greatest = changes.iter().copied().fold(0.0, f64::max);
                [
                    label.into(),
                    Cell::Number(mean, 3),
                    Cell::Number(greatest, 3),
                ]
            }
            Err(error) => [label.into(), Cell::Refused(error.to_string()), Cell::Empty],
        });
        shown = shown.or(images.ok());
    }
    report.table(table);
    let some: Vec<_> = shown.into_iter().flatten().step_by(FLIGHT / 4).collect();
    let caption = format!("The flight, each {}th frame.", FLIGHT / 4);
    let strip = strip(&some).map(|strip| Picture::new("flight", caption, strip));
    report.figure(1, strip.into_iter().collect());
    Ok(())
}

/// The mean difference of two images' colour channels.
fn change(before: &Image, after: &Image) -> f64 {
    let pairs = before.colour().iter().zip(after.colour());
    let sum: u64 = pairs
        .map(|(a, b)| (0..3).map(|k| u64::from(a[k].abs_diff(b[k]))).sum::<u64>())
        .sum();
    sum as f64 / (3 * before.colour().len().max(1)) as f64
}
