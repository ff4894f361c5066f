//! `sandtable bench`: casters, timed side by side.

use crate::cli::{BenchArgs, ViewSet};
use crate::command::render::read_view;
use crate::exit::usage;
use crate::{resident, scene};
use anyhow::{Context, Result};
use sandtable_cast::{
    Brute, CASTERS, CastPool, Difference, Image, PreparedScene, ShadeFloor, standpoints,
};
use sandtable_view::View;
use serde::Serialize;
use std::io::{self, Write};
use std::sync::Arc;
use std::time::Instant;

/// One line of figures. The names are those that other programs read.
#[derive(Serialize)]
struct Figures {
    caster: String,
    view: String,
    threads: usize,
    isa: &'static str,
    median_ms: f64,
    p5_ms: f64,
    p95_ms: f64,
    mpix_per_s: f64,
    shade_only_ms: f64,
    rays: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    check: Option<Check>,
    first_picture_ms: f64,
    peak_resident_bytes: Option<u64>,
    resident_limit_bytes: u64,
}

/// The distance from brute force.
#[derive(Serialize)]
struct Check {
    /// Infinite where sky and ground were taken for each other; JSON has no infinity: it is `null`.
    max_cells: f64,
    over_0_1_cell: u64,
    over_0_5_cell: u64,
    psnr_db: Option<f64>,
}

pub(crate) fn run(args: &BenchArgs, started: Instant) -> Result<()> {
    if args.frames == 0 {
        return Err(usage("--frames must be at least 1"));
    }
    let casters = match args.caster.as_slice() {
        [] => vec![scene::caster(CASTERS[0].name)?],
        names => names
            .iter()
            .map(|name| scene::caster(name))
            .collect::<Result<_>>()?,
    };
    let open = scene::open(&args.terrain)?;
    let ground = Arc::clone(&open.scene.ground);
    let views: Vec<(String, View)> = match (args.view.as_slice(), args.views) {
        ([], set) => {
            let standpoints = match set {
                ViewSet::Mixed => standpoints::mixed(&ground),
                ViewSet::Level => standpoints::level(&ground, [640, 360]),
            };
            standpoints
                .into_iter()
                .map(|at| (at.name, at.view))
                .collect()
        }
        (files, _) => files
            .iter()
            .map(|path| Ok((path.display().to_string(), read_view(path)?.mono())))
            .collect::<Result<_>>()?,
    };
    let all_cores = CastPool::new(0).context("cannot start the casting threads")?;
    let first = all_cores.picture(&*casters[0].caster, &open.scene, views[0].1)?;
    let first_picture_ms = started.elapsed().as_secs_f64() * 1e3;
    drop(first);
    let peak_resident_bytes = resident::peak_bytes();
    let photo_pixels = ground.photo().map_or(0, |photo| {
        u64::from(photo.pixels.cols()) * u64::from(photo.pixels.rows())
    });
    let resident_limit_bytes = 300_000_000 + 4 * ground.grid().posts() + 4 * photo_pixels;

    let mut lines = Vec::new();
    for (name, view) in &views {
        let exact = args
            .check
            .then(|| all_cores.picture(&Brute, &open.scene, *view))
            .transpose()?;
        for &threads in &args.threads {
            let pool = CastPool::new(threads).context("cannot start the casting threads")?;
            for caster in &casters {
                let prepared = pool.run(|| caster.caster.prepare(Arc::clone(&open.scene)))?;
                let timed = time(&pool, &*prepared, *view, args.frames)?;
                let check = exact.as_ref().map(|exact| {
                    let difference =
                        Difference::between(&timed.image, exact, ground.grid().cell_length());
                    Check {
                        max_cells: difference.max_cells,
                        over_0_1_cell: difference.over_tenth_cell,
                        over_0_5_cell: difference.over_half_cell,
                        psnr_db: difference.psnr_db,
                    }
                });
                let rays = u64::from(view.size[0]) * u64::from(view.size[1]);
                lines.push(Figures {
                    caster: caster.name.clone(),
                    view: name.clone(),
                    threads: pool.threads(),
                    isa: "generic",
                    median_ms: timed.frames.at(0.5),
                    p5_ms: timed.frames.at(0.05),
                    p95_ms: timed.frames.at(0.95),
                    mpix_per_s: rays as f64 / timed.frames.at(0.5) / 1e3,
                    shade_only_ms: timed.shade_only.at(0.5),
                    rays,
                    check,
                    first_picture_ms,
                    peak_resident_bytes,
                    resident_limit_bytes,
                });
            }
        }
    }
    let mut out = std::io::stdout().lock();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&lines)?)?;
    } else {
        print_table(&mut out, &open.name, &ground, &lines)?;
    }
    Ok(())
}

/// Times in milliseconds, in order.
struct Times(Vec<f64>);

impl Times {
    /// Times `frames` runs of `work`, after one that warms the caches.
    fn of(frames: usize, mut work: impl FnMut()) -> Self {
        work();
        let mut times: Vec<_> = (0..frames)
            .map(|_| {
                let begin = Instant::now();
                work();
                begin.elapsed().as_secs_f64() * 1e3
            })
            .collect();
        times.sort_by(f64::total_cmp);
        Self(times)
    }

    /// The time below which `share` of the runs stayed.
    fn at(&self, share: f64) -> f64 {
        self.0[((self.0.len() - 1) as f64 * share).round() as usize]
    }
}

/// One caster's times and its last image.
struct Timed {
    frames: Times,
    shade_only: Times,
    image: Image,
}

fn time(pool: &CastPool, prepared: &dyn PreparedScene, view: View, frames: usize) -> Result<Timed> {
    let mut images = [Image::default()];
    // A view that the caster refuses is refused before anything is timed.
    pool.cast(prepared, &[view], &mut images)?;
    let cast = Times::of(frames, || {
        let _ = pool.cast(prepared, &[view], &mut images);
    });
    let [image] = images;
    let mut floor = ShadeFloor::new(&image);
    let ground = &prepared.scene().ground;
    let shade_only = Times::of(frames, || pool.run(|| floor.shade(ground)));
    Ok(Timed {
        frames: cast,
        shade_only,
        image,
    })
}

fn print_table(
    out: &mut impl Write,
    name: &str,
    ground: &sandtable_terrain::Ground,
    lines: &[Figures],
) -> io::Result<()> {
    let grid = ground.grid();
    writeln!(out, "{name}: {} by {} posts", grid.cols, grid.rows)?;
    writeln!(
        out,
        "{:<10} {:<24} {:>7} {:>10} {:>8} {:>8} {:>8} {:>10}  error against brute force",
        "caster", "view", "threads", "median ms", "p5", "p95", "Mpix/s", "shade only"
    )?;
    for line in lines {
        let check = line.check.as_ref().map_or_else(
            || "not checked (--check)".to_owned(),
            |check| {
                let psnr = check
                    .psnr_db
                    .map_or("identical".into(), |db| format!("{db:.1} dB"));
                format!(
                    "{} pixels over 0.1 cell, {} over 0.5; at most {:.3} cells; {psnr}",
                    check.over_0_1_cell, check.over_0_5_cell, check.max_cells
                )
            },
        );
        writeln!(
            out,
            "{:<10} {:<24} {:>7} {:>10.2} {:>8.2} {:>8.2} {:>8.2} {:>10.2}  {check}",
            line.caster,
            line.view,
            line.threads,
            line.median_ms,
            line.p5_ms,
            line.p95_ms,
            line.mpix_per_s,
            line.shade_only_ms,
        )?;
    }
    print_ratios(out, lines)?;
    if let Some(line) = lines.first() {
        let mb = |bytes: u64| bytes as f64 / 1e6;
        let peak = line
            .peak_resident_bytes
            .map_or("not known here".to_owned(), |bytes| {
                format!("{:.0} MB", mb(bytes))
            });
        writeln!(
            out,
            "first picture {:.0} ms after the start; peak resident memory then {peak} \
             (limit {:.0} MB)",
            line.first_picture_ms,
            mb(line.resident_limit_bytes)
        )?;
    }
    Ok(())
}

/// How many times as fast as brute force each other caster is, where brute force was timed too.
fn print_ratios(out: &mut impl Write, lines: &[Figures]) -> io::Result<()> {
    let is_brute = |line: &&Figures| line.caster == "brute";
    let mut groups: Vec<(&str, usize)> = Vec::new();
    for line in lines.iter().filter(|line| !is_brute(line)) {
        if !groups.contains(&(line.caster.as_str(), line.threads)) {
            groups.push((&line.caster, line.threads));
        }
    }
    for (caster, threads) in groups {
        let (mut own, mut brute, mut ratios) = (0.0, 0.0, Vec::new());
        for line in lines
            .iter()
            .filter(|line| line.caster == caster && line.threads == threads)
        {
            let rival = lines
                .iter()
                .filter(is_brute)
                .find(|rival| rival.view == line.view && rival.threads == threads);
            if let Some(rival) = rival {
                own += line.median_ms;
                brute += rival.median_ms;
                ratios.push(rival.median_ms / line.median_ms);
            }
        }
        if own > 0.0 {
            let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
            writeln!(
                out,
                "{caster} on {threads} threads is {:.1} times as fast as brute over all views, \
                 and at least {least:.1} times in each",
                brute / own
            )?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_without_a_number_is_null_in_json() {
        let check = Check {
            max_cells: f64::INFINITY,
            over_0_1_cell: 3,
            over_0_5_cell: 2,
            psnr_db: None,
        };
        let json = serde_json::to_value(&check).unwrap();
        assert!(json["max_cells"].is_null() && json["psnr_db"].is_null());
        assert_eq!(json["over_0_1_cell"], 3);
    }
}
