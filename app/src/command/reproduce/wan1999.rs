//! Wan, Qu and Kaufman (1999): ray coherence, boundary cells, roll and workers (row W10).

use super::Setup;
use super::mesh::Mesh;
use super::report::{Cell, Picture, Report, Table};
use super::trial::{
    Attempt, Outcome, Prepared, Trial, all_prepared, cell, outcomes, prepared, ratio,
};
use super::voxel_model::{self, LEVELS};
use crate::command::bench::measure::{Times, take_turns};
use anyhow::Result;
use image::RgbaImage;
use sandtable_cast::{CastPool, Difference, Scene, Scheme, standpoints};
use sandtable_stage::Gpu;
use sandtable_view::View;
use std::sync::Arc;

const CITATION: &str = "M. Wan, H. Qu, A. Kaufman: Virtual Flythrough over a Voxel-Based Terrain. \
                        IEEE Virtual Reality, 1999.";

/// The casters, and the paper's seconds on one worker.
const CASTERS: [(&str, &str, Option<f64>); 4] = [
    (
        "volume?levels=64",
        "accurate: coherent rays through the volume",
        Some(0.92),
    ),
    (
        "boundary?levels=64",
        "approximate: first boundary cell",
        Some(0.65),
    ),
    (
        "conventional?levels=64",
        "conventional: each ray from the eye",
        Some(6.71),
    ),
    (
        "conventional?levels=64&start=volume",
        "conventional, from the volume's bounds",
        None,
    ),
];

/// Places among the casters.
const ACCURATE: usize = 0;
const APPROXIMATE: usize = 1;

/// The rival that is no caster, and the paper's seconds for it.
const MESH: &str = "two textured triangles a cell";
const MESH_SECONDS: f64 = 0.80;

/// Pixels of the paper's image.
const PIXELS: f64 = 500.0 * 400.0;

/// Workers, and the paper's seconds with the accurate and the approximate caster.
const WORKERS: [(usize, f64, f64); 5] = [
    (1, 0.92, 0.65),
    (4, 0.28, 0.21),
    (8, 0.15, 0.11),
    (12, 0.11, 0.08),
    (16, 0.09, 0.06),
];

/// Degrees of roll: ten, as many as the paper's mean is of.
const ROLLS: [f64; 10] = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0];

/// Measures and draws.
pub(super) fn report(setup: &Setup) -> Result<Report> {
    let (name, scene) = setup.ridges(512)?;
    let view = standpoints::wan(&scene.ground, 0.0);
    let casters = all_prepared(&setup.many, &scene, CASTERS.map(|(caster, ..)| caster))?;
    let pools = setup.pools();
    let trials: Vec<_> = pools
        .iter()
        .flat_map(|&pool| {
            casters.iter().map(move |prepared| Trial {
                scheme: Scheme::StaticInterleave,
                ..Trial::new(prepared, pool, view)
            })
        })
        .collect();
    let attempts = outcomes(setup.frames, &trials)?;
    let (one, many) = attempts.split_at(CASTERS.len());

    let mut report = Report::new("Flythrough over a voxel-based terrain, 1999", CITATION);
    report.paragraph(format!(
        "The paper casts 500 by 400 pixels of a volume of 512 by 512 by 64 voxels, looking 30° \
         down and 90° from north, on an SGI Power Challenge. Here the volume is made of {name}, \
         its relief over {LEVELS} levels. The paper does not say where its eye is; a tenth of the \
         terrain's side above its highest post it is here. Its conventional caster samples each \
         ray from the eye on; ours can begin at the volume's bounds too, which is a stronger rival. Each kind of time is \
         best compared as a ratio: theirs within their machine, ours within this one."
    ));
    report.heading("Coherence and boundary cells");
    let mesh = mesh(setup, &scene, &view);
    report.table(coherence(one, &mesh));
    report.heading("Workers");
    report.table(workers(&pools, one, many));
    report.heading("The approximate image");
    report.table(approximate(&scene, one));
    report.figure(3, stills(one, mesh));
    report.heading("The volume");
    report.table(voxel_model::size(setup, &scene)?);
    report.heading("Antialiasing");
    voxel_model::antialiasing(&mut report, setup, &scene, &view)?;
    report.heading("Roll");
    let roll_lines = prepared(&setup.many, &scene, "roll-lines?levels=64")?;
    roll(&mut report, setup, &scene, &roll_lines, &casters[ACCURATE])?;
    Ok(report)
}

/// The ground as triangles: their times and image, and on what they were drawn.
struct Drawn {
    adapter: String,
    times: Times,
    image: RgbaImage,
}

/// Draws the ground as triangles, or says why it cannot.
fn mesh(setup: &Setup, scene: &Scene, view: &View) -> Result<Drawn, String> {
    let draw = || -> Result<Drawn> {
        let gpu = Gpu::offscreen()?;
        let mesh = Mesh::new(&gpu, &scene.ground, view)?;
        let mut times = take_turns(setup.frames, &mut [mesh.as_work()])?;
        Ok(Drawn {
            adapter: gpu.description(),
            times: times.remove(0),
            image: mesh.image()?,
        })
    };
    draw().map_err(|error| format!("{error:#}"))
}

fn coherence(one: &[Attempt], mesh: &Result<Drawn, String>) -> Table {
    let (_, _, accurate) = CASTERS[ACCURATE];
    let mut table = Table::new(
        "One worker; the accurate caster's time is 1. Triangles are drawn by the graphics adapter.",
        &[
            "caster",
            "paper s",
            "paper ratio",
            "ours ms",
            "our ratio",
            "p5 ms",
            "p95 ms",
            "Mpix/s",
        ],
    );
    for ((_, label, seconds), attempt) in CASTERS.iter().zip(one) {
        let paper_ratio = seconds.zip(accurate).map(|(time, unit)| time / unit);
        table.row([
            (*label).into(),
            Cell::quoted(*seconds, 2),
            Cell::quoted(paper_ratio, 2),
            cell(attempt, 1, Outcome::ms),
            ratio(attempt, &one[ACCURATE]),
            cell(attempt, 1, |it| it.times.at(0.05)),
            cell(attempt, 1, |it| it.times.at(0.95)),
            cell(attempt, 2, Outcome::mpix_per_s),
        ]);
    }
    table.row(match mesh {
        Ok(Drawn { adapter, times, .. }) => [
            format!("{MESH}, on {adapter}").into(),
            Cell::Number(MESH_SECONDS, 2),
            Cell::quoted(accurate.map(|unit| MESH_SECONDS / unit), 2),
            Cell::Number(times.median(), 1),
            match &one[ACCURATE] {
                Ok(accurate) => Cell::Number(times.median() / accurate.ms(), 2),
                Err(_) => Cell::Empty,
            },
            Cell::Number(times.at(0.05), 1),
            Cell::Number(times.at(0.95), 1),
            Cell::Number(PIXELS / times.median() / 1e3, 2),
        ],
        Err(reason) => [
            MESH.into(),
            Cell::Number(MESH_SECONDS, 2),
            Cell::quoted(accurate.map(|unit| MESH_SECONDS / unit), 2),
            Cell::Refused(reason.clone()),
            Cell::Empty,
            Cell::Empty,
            Cell::Empty,
            Cell::Empty,
        ],
    });
    table
}

fn workers(pools: &[&CastPool], one: &[Attempt], many: &[Attempt]) -> Table {
    let mut table = Table::new(
        "Speed-up over one worker; columns are interleaved statically.",
        &[
            "workers",
            "paper accurate s",
            "speed-up",
            "paper approximate s",
            "speed-up",
            "our accurate ms",
            "speed-up",
            "our approximate ms",
            "speed-up",
        ],
    );
    let ours = |count: usize| match pools.iter().position(|pool| pool.threads() == count) {
        Some(0) => Some(one),
        Some(_) => Some(many),
        None => None,
    };
    let mut counts: Vec<_> = WORKERS.iter().map(|&(count, ..)| count).collect();
    counts.extend(pools.iter().map(|pool| pool.threads()));
    counts.sort_unstable();
    counts.dedup();
    for count in counts {
        let paper = WORKERS.iter().find(|&&(workers, ..)| workers == count);
        let mut cells = vec![Cell::from(count)];
        for (time, alone) in [
            (paper.map(|row| row.1), WORKERS[0].1),
            (paper.map(|row| row.2), WORKERS[0].2),
        ] {
            cells.push(Cell::quoted(time, 2));
            cells.push(Cell::quoted(time.map(|time| alone / time), 1));
        }
        for place in [ACCURATE, APPROXIMATE] {
            match ours(count) {
                Some(attempts) => {
                    cells.push(cell(&attempts[place], 1, Outcome::ms));
                    cells.push(ratio(&one[place], &attempts[place]));
                }
                None => cells.extend([Cell::Empty, Cell::Empty]),
            }
        }
        table.row(cells);
    }
    table
}

/// What the approximate image loses against the accurate one.
fn approximate(scene: &Scene, one: &[Attempt]) -> Table {
    let mut table = Table::new(
        "The approximate image against the accurate one; the paper calls the difference minimal.",
        &["measure", "ours"],
    );
    let (Ok(accurate), Ok(approximate)) = (&one[ACCURATE], &one[APPROXIMATE]) else {
        table.row([
            "all".into(),
            "one of the casters could not be run, see above".into(),
        ]);
        return table;
    };
    let (accurate, approximate) = (&accurate.images[0], &approximate.images[0]);
    let cell_length = scene.ground.grid().cell_length();
    let difference = Difference::between(approximate, accurate, cell_length);
    table.row([
        "colours, PSNR in dB".into(),
        difference
            .psnr_db
            .map_or("identical".into(), |db| Cell::Number(db, 1)),
    ]);
    table.row([
        "rays stop earlier by, mean in voxels".into(),
        Cell::quoted(
            early_stop(&approximate.depth, &accurate.depth, cell_length),
            2,
        ),
    ]);
    table.row([
        "pixels more than a voxel apart in depth, %".into(),
        Cell::Number(
            100.0 * difference.over_one_cell as f64 / accurate.depth.len().max(1) as f64,
            1,
        ),
    ]);
    table
}

/// By how many voxels rays stop earlier at `depth` than at `exact` on average, over the pixels that
/// see ground in both.
fn early_stop(depth: &[f32], exact: &[f32], cell_length: f64) -> Option<f64> {
    let pairs = depth.iter().zip(exact);
    let stops: Vec<_> = pairs
        .map(|(found, wanted)| f64::from(wanted - found) / cell_length)
        .filter(|stop| stop.is_finite())
        .collect();
    let sum: f64 = stops.iter().sum();
    (!stops.is_empty()).then(|| sum / stops.len() as f64)
}

fn stills(one: &[Attempt], mesh: Result<Drawn, String>) -> Vec<Picture> {
    let cast = [
        (
            ACCURATE,
            "volume",
            "Accurate: trilinear densities, as the paper's figure 6.",
        ),
        (
            APPROXIMATE,
            "boundary",
            "Approximate: boundary cells alone, as the paper's figure 7.",
        ),
    ];
    let pictures = cast
        .into_iter()
        .filter_map(|(place, file, caption)| Picture::of(&one[place], file, caption));
    let caption = "Two textured triangles a cell, drawn by the graphics adapter.";
    let mesh = mesh.map(|drawn| Picture::new("mesh", caption, drawn.image));
    pictures.chain(mesh).collect()
}

/// The time over the roll angle: along lines parallel to the vertical, and along columns.
fn roll(
    report: &mut Report,
    setup: &Setup,
    scene: &Arc<Scene>,
    roll_lines: &Prepared,
    volume: &Prepared,
) -> Result<()> {
    let view = |roll: &f64| standpoints::wan(&scene.ground, roll.to_radians());
    let trials: Vec<_> = [roll_lines, volume]
        .into_iter()
        .flat_map(|prepared| ROLLS.iter().map(move |roll| (prepared, roll)))
        .map(|(prepared, roll)| Trial::new(prepared, &setup.one, view(roll)))
        .collect();
    let attempts = outcomes(setup.frames, &trials)?;
    let (lines, columns) = attempts.split_at(ROLLS.len());
    let mut table = Table::new(
        "One worker; the time without roll is 1. Columns are those of the accurate caster, which \
         does not turn with the image.",
        &[
            "roll °",
            "paper s",
            "paper ratio",
            "lines ms",
            "our ratio",
            "Mpix/s",
            "columns ms",
            "our ratio",
        ],
    );
    let paper = |angle: f64| match angle {
        0.0 => Some(0.92),
        45.0 => Some(1.04),
        _ => None,
    };
    for ((angle, on_lines), on_columns) in ROLLS.iter().zip(lines).zip(columns) {
        table.row([
            Cell::Number(*angle, 0),
            Cell::quoted(paper(*angle), 2),
            Cell::quoted(paper(*angle).map(|it| it / 0.92), 2),
            cell(on_lines, 1, Outcome::ms),
            ratio(on_lines, &lines[0]),
            cell(on_lines, 2, Outcome::mpix_per_s),
            cell(on_columns, 1, Outcome::ms),
            ratio(on_columns, &columns[0]),
        ]);
    }
    let mean = |attempts: &[Attempt]| {
        let times: Vec<_> = attempts.iter().flatten().map(|it| it.ms()).collect();
        let all = times.len() == attempts.len();
        all.then(|| times.iter().sum::<f64>() / times.len() as f64)
    };
    let to_first = |attempts: &[Attempt]| {
        let first = attempts[0].as_ref().ok()?;
        Some(mean(attempts)? / first.ms())
    };
    table.row([
        Cell::from("mean"),
        Cell::Number(0.96, 2),
        Cell::Number(0.96 / 0.92, 2),
        Cell::quoted(mean(lines), 1),
        Cell::quoted(to_first(lines), 2),
        Cell::Empty,
        Cell::quoted(mean(columns), 1),
        Cell::quoted(to_first(columns), 2),
    ]);
    report.table(table);
    let last = &lines[ROLLS.len() - 1];
    let picture = Picture::of(
        last,
        "roll-45",
        "Rolled by 45°, along lines parallel to the vertical.",
    );
    report.figure(2, picture.into_iter().collect());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_early_stop_is_the_mean_over_ground_in_cells() {
        let exact = [100.0, 50.0, f32::INFINITY, 80.0];
        let found = [90.0, 50.0, f32::INFINITY, f32::INFINITY];
        assert_eq!(early_stop(&found, &exact, 10.0), Some(0.5));
        assert_eq!(early_stop(&[], &[], 10.0), None);
    }
}
